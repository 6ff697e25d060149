// SPDX-License-Identifier: Apache-2.0
// ecat_application: the application's Avalon-MM port: words of 32 bits, bytes in a row into the controller.
// Contract: an access waits until all of its enabled bytes are done, the lowest first, a byte a clock where frames leave
// room; readdata is valid in the clock in which waitrequest is low. Addresses from 0x8000 on are the SII image.
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
    StBytes = 2'd0,  // bytes go in and answers come back, both in order
    StSii   = 2'd1,
    StDone  = 2'd2
  } state_e;

  function automatic logic [3:0] lowest(input logic [3:0] set);
    lowest = set & (~set + 4'd1);
  endfunction

  state_e state_q;
  logic [3:0] sent_q, done_q;  // bytes that are in, that are through
  logic [3:0] next, answered, finished;
  logic [1:0] byte_now;
  logic [31:0] data_q;
  logic asked, is_sii, sii_taken;

  assign asked    = avs_read_i || avs_write_i;
  assign is_sii   = avs_address_i[13];
  assign next     = lowest(avs_byteenable_i & ~sent_q);
  assign answered = lowest(avs_byteenable_i & ~done_q);
  assign byte_now = {next[3] || next[2], next[3] || next[1]};

  assign valid_o     = state_q == StBytes && asked && next != '0 && !is_sii;
  assign sii_taken   = state_q == StBytes && asked && next != '0 && is_sii && sii_ready_i;
  assign sii_read_o  = sii_taken && avs_read_i;
  assign sii_write_o = sii_taken && avs_write_i;
  assign write_o     = avs_write_i;
  assign address_o   = {avs_address_i, byte_now};
  assign data_o      = avs_writedata_i[8*byte_now+:8];
  assign finished    = done_q | (done_i || state_q == StSii ? answered : '0);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q <= StBytes;
      sent_q  <= '0;
      done_q  <= '0;
      data_q  <= '0;
    end else if (state_q == StDone) begin
      state_q <= StBytes;
      sent_q  <= '0;
      done_q  <= '0;
    end else if (asked) begin
      if ((valid_o && ready_i) || sii_taken) sent_q <= sent_q | next;
      done_q <= finished;
      for (int n = 0; n < 4; n++) begin
        if (answered[n] && state_q == StSii) data_q[8*n+:8] <= sii_data_i;
        else if (answered[n] && done_i) data_q[8*n+:8] <= data_i;
      end
      if (finished == avs_byteenable_i) state_q <= StDone;
      else state_q <= sii_taken ? StSii : StBytes;
    end
  end

  assign avs_readdata_o    = data_q;
  assign avs_waitrequest_o = state_q != StDone;

endmodule
