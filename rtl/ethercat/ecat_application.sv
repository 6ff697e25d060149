// SPDX-License-Identifier: Apache-2.0
// ecat_application: the application's Avalon-MM port: words of 32 bits, bytes in a row into the controller.
// Contract: the enabled bytes of an access go in, the lowest first, a byte a clock where frames leave room. A write is answered
// when its word is registered here. A write to the memory may follow others to the memory at once. Every other access begins when
// the bytes before it are done: a register has its effect some clocks after its byte. A read is answered when its bytes
// have come. readdata is valid in the clock in which waitrequest is low. Addresses from 0x8000 on are the SII image.
// A write of the word 0x4200 fetches data[25:16] bytes (1 to 512, otherwise none) from the controller's address data[15:2] * 4 on, without
// a pause between words. A read of 0x4000 + 4 n gives word n of them when it has come; other accesses wait for
// the end of the fetch. Bytes of the last word that were not fetched are not defined.
module ecat_application (
    input  logic        clk_i,
    input  logic        rst_ni,
    // Avalon-MM
    input  logic [13:0] avs_address_i,     // words
    input  logic        avs_read_i,
    input  logic        avs_write_i,
    input  logic [3:0]  avs_byteenable_i,
    input  logic [31:0] avs_writedata_i,
    output logic [31:0] avs_readdata_o,
    output logic        avs_waitrequest_o,
    // bytes of the controller
    output logic        valid_o,
    output logic        write_o,
    output logic [15:0] address_o,
    output logic [7:0]  data_o,
    input  logic        ready_i,
    input  logic        done_i,
    input  logic [7:0]  data_i,
    // bytes of the SII image
    output logic        sii_read_o,
    output logic        sii_write_o,
    input  logic [7:0]  sii_data_i,        // a clock after sii_read_o
    input  logic        sii_ready_i
);

  typedef enum logic [1:0] {
    StIdle   = 2'd0,
    StRead   = 2'd1,  // until the bytes of a read have come
    StAnswer = 2'd2
  } state_e;

  function automatic logic [3:0] lowest(input logic [3:0] set);
    lowest = set & (~set + 4'd1);
  endfunction

  // What the access begins.
  state_e state_q;
  logic asked, is_window, to_memory, fetch_q, begins, clear, take, take_start, take_word, fits;
  logic [3:0] inside_q, enter_q;
  logic sii_q;  // the last access was one to the SII image
  logic [13:0] word_q;  // of the bytes that go in
  logic [9:0] less;  // bytes of a fetch, less one
  logic [3:0] last;  // bytes of its last word

  assign asked      = state_q == StIdle && (avs_read_i || avs_write_i);
  assign is_window  = avs_address_i[13:8] == 6'h10;
  assign to_memory  = avs_write_i && !avs_address_i[13] && avs_address_i[12:10] != '0 && !sii_q && word_q[13:10] != '0;
  assign begins     = asked && enter_q == '0 && !fetch_q;
  assign clear      = inside_q == '0;
  assign take       = begins && !is_window && (clear || to_memory);
  assign take_start = begins && is_window && avs_write_i && clear;
  assign less       = avs_writedata_i[25:16] - 10'd1;
  assign last       = 4'hF >> ~less[1:0];
  assign fits       = !less[9] && avs_address_i[7:0] == 8'h80 && avs_byteenable_i == '1;

  // Bytes go in: of the word of an access, or of the words of a fetch one after the other.
  logic [31:0] data_q;
  logic [6:0] words_q;  // that follow this one
  logic [3:0] entering, last_q;
  logic [1:0] lane;
  logic write_q, enters, next_word;

  assign entering  = lowest(enter_q);
  assign lane      = {entering[3] || entering[2], entering[3] || entering[1]};
  assign valid_o   = enter_q != '0 && !sii_q;
  assign write_o   = write_q;
  assign address_o = {word_q, lane};
  assign data_o    = data_q[8*lane+:8];
  assign enters    = sii_q ? enter_q != '0 && sii_ready_i : valid_o && ready_i;
  assign next_word = enters && enter_q == entering && words_q != '0;
  assign sii_read_o  = enters && sii_q && !write_q;
  assign sii_write_o = enters && sii_q && write_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      enter_q  <= '0;
      words_q  <= '0;
      inside_q <= '0;
    end else begin
      if (take) begin
        enter_q <= avs_byteenable_i;
        words_q <= '0;
      end else if (take_start && fits) begin
        enter_q <= less[8:2] == '0 ? last : 4'hF;
        words_q <= less[8:2];
      end else if (next_word) begin
        enter_q <= words_q == 7'd1 ? last_q : 4'hF;
        words_q <= words_q - 7'd1;
      end else if (enters) begin
        enter_q <= enter_q & ~entering;
      end
      inside_q <= inside_q + {3'd0, valid_o && ready_i} - {3'd0, done_i};
    end
  end
  always_ff @(posedge clk_i) begin
    if (take || take_start) begin
      word_q  <= take ? avs_address_i : avs_writedata_i[15:2];
      write_q <= take && avs_write_i;
      sii_q   <= take && avs_address_i[13];
      data_q  <= avs_writedata_i;
      last_q  <= last;
    end else if (next_word) begin
      word_q <= word_q + 14'd1;
    end
  end

  // Answers come in the same order; a word of a fetch goes to the window.
  logic sii_came_q, comes, word_ends, store_q, from_window_q;
  logic [7:0] back_q;  // words of the fetch that have come
  logic [6:0] end_q, store_word_q;  // its last word; the one that goes to the window
  logic [3:0] done_q, wanted, got, finished;
  logic [31:0] read_q, window;

  assign wanted    = !fetch_q ? avs_byteenable_i : back_q[6:0] == end_q ? last_q : 4'hF;
  assign comes     = sii_q ? sii_came_q : done_i && !write_q;
  assign got       = comes ? lowest(wanted & ~done_q) : '0;
  assign finished  = done_q | got;
  assign word_ends = fetch_q && comes && finished == wanted;
  assign take_word = asked && is_window && avs_read_i && !store_q && (!fetch_q || {1'b0, avs_address_i[6:0]} < back_q);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q       <= StIdle;
      sii_came_q    <= 1'b0;
      fetch_q       <= 1'b0;
      store_q       <= 1'b0;
      from_window_q <= 1'b0;
      back_q        <= '0;
      end_q         <= '0;
      done_q        <= '0;
    end else begin
      case (state_q)
        StIdle: begin
          if (take && avs_read_i) state_q <= StRead;
          else if (take || take_start || take_word) state_q <= StAnswer;
        end
        StRead: if (finished == avs_byteenable_i) state_q <= StAnswer;
        default: state_q <= StIdle;
      endcase
      sii_came_q <= sii_read_o;
      store_q    <= word_ends;
      if (take || take_word) from_window_q <= take_word;
      if (take || take_start || word_ends) done_q <= '0;
      else done_q <= finished;
      if (take_start && fits) begin
        fetch_q <= 1'b1;
        back_q  <= '0;
        end_q   <= less[8:2];
      end else if (word_ends) begin
        fetch_q <= back_q[6:0] != end_q;
        back_q  <= back_q + 8'd1;
      end
    end
  end
  always_ff @(posedge clk_i) begin
    store_word_q <= back_q[6:0];
    for (int n = 0; n < 4; n++) if (got[n]) read_q[8*n+:8] <= sii_q ? sii_data_i : data_i;
  end

  ram_block #(
      .Words(128),
      .Width(32)
  ) u_window (
      .clk_i,
      .write_i        (store_q),
      .write_address_i(store_word_q),
      .write_data_i   (read_q),
      .read_i         (take_word),
      .read_address_i (avs_address_i[6:0]),
      .read_data_o    (window)
  );

  assign avs_readdata_o    = from_window_q ? window : read_q;
  assign avs_waitrequest_o = state_q != StAnswer;

endmodule
