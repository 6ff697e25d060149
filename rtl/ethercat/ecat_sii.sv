// SPDX-License-Identifier: Apache-2.0
// ecat_sii: the slave information as registers 0x0500..0x050f show it, from an image in memory.
// Contract: a command begins after the commit (or the application's write) that gave it, when idle_i. Read: four words
// from SII_ADDRESS on; write: the first word of SII_DATA; reload: the check sum of words 0..6 is compared with
// word 7 (CRC-8, x^8+x^2+x+1, from FFh), and word 4 becomes the station alias if it is right. The application reaches the
// image's words at app_*. live_* as in ecat_control.
module ecat_sii #(
    parameter int unsigned Words = 2048
) (
    input  logic clk_i,
    input  logic rst_ni,
    input  ecat_pkg::register_access_t register_i,
    input  logic        idle_i,
    input  logic [11:0] live_address_i,
    output logic        live_hit_o,
    output logic [7:0]  live_data_o,
    // the image, for the application: a byte at a time
    input  logic        app_write_i,
    input  logic [$clog2(2*Words)-1:0] app_address_i,
    input  logic [7:0]  app_data_i,
    input  logic        app_read_i,
    output logic [7:0]  app_data_o,     // a clock after app_read_i, which asks for app_ready_o
    output logic        app_ready_o,    // no command is at work
    // what a reload found
    output logic        loaded_o,
    output logic        alias_valid_o,
    output logic [15:0] alias_o
);

  localparam int unsigned Width = $clog2(Words);
  localparam int unsigned CommandLow = esc_regmap_pkg::SII_CONTROL_COMMAND_LSB;
  localparam logic [11:0] CommandByte = esc_regmap_pkg::REG_SII_CONTROL + 12'(CommandLow / 8);
  localparam logic [2:0] CommandRead = 3'd1;
  localparam logic [2:0] CommandWrite = 3'd2;
  localparam logic [2:0] CommandReload = 3'd4;
  localparam logic [Width-1:0] WordAlias = Width'(4);
  localparam logic [Width-1:0] WordCheck = Width'(7);

  typedef enum logic [2:0] {
    StIdle      = 3'd0,
    StFetch     = 3'd1,  // address to the memory
    StTake      = 3'd2,  // its word
    StCheckLow  = 3'd3,  // sum over the word's bytes
    StCheckHigh = 3'd4,
    StWrite     = 3'd5
  } state_e;

  function automatic logic [7:0] check_sum(input logic [7:0] sum, input logic [7:0] data);
    check_sum = sum ^ data;
    for (int i = 0; i < 8; i++) check_sum = {check_sum[6:0], 1'b0} ^ (check_sum[7] ? 8'h07 : 8'h00);
  endfunction

  logic [7:0] low_q[0:Words-1];
  logic [7:0] high_q[0:Words-1];
  logic [15:0] word_q;
  logic [Width-1:0] place;
  logic [15:0] write_data;
  logic [1:0] write;

  state_e state_q;
  logic [2:0] command, command_q;
  logic [Width-1:0] count_q;
  logic [31:0] address_q;
  logic [63:0] data_q;
  logic [7:0] sum_q;
  logic enable_q, pending_q, command_error_q, write_error_q, checksum_error_q, loaded_q, upper_q;
  logic reload_q, beyond;
  logic [15:0] control, first_word_q;

  assign command     = register_i.data[CommandLow%8+:esc_regmap_pkg::SII_CONTROL_COMMAND_WIDTH];
  assign beyond      = address_q[31:Width] != '0;
  assign app_ready_o = state_q == StIdle;

  always_comb begin
    place = app_address_i[Width:1];
    write = {2{app_write_i && app_ready_o}} & {app_address_i[0], !app_address_i[0]};
    write_data = {app_data_i, app_data_i};
    if (state_q != StIdle) begin
      place      = reload_q ? count_q : address_q[Width-1:0] + count_q;
      write      = {2{state_q == StWrite}};
      write_data = data_q[15:0];
    end
  end
  always_ff @(posedge clk_i) begin
    word_q[7:0] <= low_q[place];
    if (write[0]) low_q[place] <= write_data[7:0];
  end
  always_ff @(posedge clk_i) begin
    word_q[15:8] <= high_q[place];
    if (write[1]) high_q[place] <= write_data[15:8];
  end
  always_ff @(posedge clk_i) begin
    if (app_read_i) upper_q <= app_address_i[0];
  end
  assign app_data_o = upper_q ? word_q[15:8] : word_q[7:0];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q          <= StIdle;
      command_q        <= '0;
      count_q          <= '0;
      address_q        <= '0;
      data_q           <= '0;
      sum_q            <= '1;
      enable_q         <= 1'b0;
      pending_q        <= 1'b0;
      reload_q         <= 1'b0;
      command_error_q  <= 1'b0;
      write_error_q    <= 1'b0;
      checksum_error_q <= 1'b0;
      loaded_q         <= 1'b0;
      first_word_q     <= '0;
    end else begin
      if (register_i.write) begin
        if (register_i.address == esc_regmap_pkg::REG_SII_CONTROL && !register_i.application) begin
          enable_q <= register_i.data[esc_regmap_pkg::SII_CONTROL_WRITE_ENABLE_LSB];
        end
        if (register_i.address == CommandByte) begin
          command_q       <= command;
          pending_q       <= command != '0;
          command_error_q <= 1'b0;
          write_error_q   <= 1'b0;
        end
        if (register_i.address[11:2] == esc_regmap_pkg::REG_SII_ADDRESS[11:2]) begin
          address_q[8*register_i.address[1:0]+:8] <= register_i.data;
        end
        if (register_i.address[11:3] == esc_regmap_pkg::REG_SII_DATA[11:3]) begin
          data_q[8*register_i.address[2:0]+:8] <= register_i.data;
        end
      end
      case (state_q)
        StIdle:
        if (pending_q && idle_i) begin
          pending_q <= 1'b0;
          count_q   <= '0;
          sum_q     <= '1;
          reload_q  <= command_q == CommandReload;
          if (command_q == CommandReload) state_q <= StFetch;
          else if (beyond || (command_q != CommandRead && command_q != CommandWrite)) command_error_q <= 1'b1;
          else if (command_q == CommandRead) state_q <= StFetch;
          else if (enable_q) state_q <= StWrite;
          else write_error_q <= 1'b1;
          enable_q <= 1'b0;
        end
        StFetch: state_q <= StTake;
        StTake: begin
          if (reload_q) begin
            state_q <= StCheckLow;
            if (count_q == WordAlias) first_word_q <= word_q;
          end else begin
            data_q  <= {word_q, data_q[63:16]};
            count_q <= count_q + 1'b1;
            state_q <= count_q == Width'(3) ? StIdle : StFetch;
          end
        end
        StCheckLow: begin
          sum_q   <= check_sum(sum_q, word_q[7:0]);
          state_q <= StCheckHigh;
          if (count_q == WordCheck) begin
            state_q          <= StIdle;
            checksum_error_q <= sum_q != word_q[7:0];
            loaded_q         <= sum_q == word_q[7:0];
          end
        end
        StCheckHigh: begin
          sum_q   <= check_sum(sum_q, word_q[15:8]);
          count_q <= count_q + 1'b1;
          state_q <= StFetch;
        end
        default: state_q <= StIdle;
      endcase
    end
  end

  assign loaded_o      = loaded_q;
  assign alias_valid_o = state_q == StIdle && loaded_q && reload_q;
  assign alias_o       = first_word_q;

  always_comb begin
    control = esc_regmap_pkg::RESET_SII_CONTROL;
    control[esc_regmap_pkg::SII_CONTROL_WRITE_ENABLE_LSB]   = enable_q;
    control[esc_regmap_pkg::SII_CONTROL_CHECKSUM_ERROR_LSB] = checksum_error_q;
    control[esc_regmap_pkg::SII_CONTROL_NOT_LOADED_LSB]     = !loaded_q;
    control[esc_regmap_pkg::SII_CONTROL_COMMAND_ERROR_LSB]  = command_error_q;
    control[esc_regmap_pkg::SII_CONTROL_WRITE_ERROR_LSB]    = write_error_q;
    control[esc_regmap_pkg::SII_CONTROL_BUSY_LSB]           = pending_q || state_q != StIdle;
    live_hit_o  = 1'b1;
    live_data_o = data_q[8*live_address_i[2:0]+:8];
    if (live_address_i == esc_regmap_pkg::REG_SII_CONTROL) live_data_o = control[7:0];
    else if (live_address_i == esc_regmap_pkg::REG_SII_CONTROL + 12'd1) live_data_o = control[15:8];
    else if (live_address_i[11:3] != esc_regmap_pkg::REG_SII_DATA[11:3]) live_hit_o = 1'b0;
  end

  logic unused;
  assign unused = &{register_i.read};

endmodule
