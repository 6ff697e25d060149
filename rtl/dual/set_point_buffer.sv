// SPDX-License-Identifier: Apache-2.0
// set_point_buffer: double buffer that hands set-points from one core to the other.
// Contract: words are written into the back bank; complete_i says that all of them are there. swap_i, at the
// start of a period, brings a complete back bank to the front. Without one the front stays: hold_o is high
// until the next swap, underrun_o pulses, and words with a bit in zero_on_hold_i read 0. A word is at
// read_data_o in the clock after its index. Not both swap_i and write_i or complete_i in the same clock.
module set_point_buffer #(
    parameter int unsigned Words = 15  // 2..32
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        clear_i,         // nothing has been handed over
    input  logic        swap_i,
    input  logic        write_i,
    input  logic [4:0]  write_index_i,   // beyond the last word: not written
    input  logic [31:0] write_data_i,
    input  logic        complete_i,
    input  logic [31:0] zero_on_hold_i,
    input  logic [4:0]  read_index_i,    // beyond the last word: 0
    output logic [31:0] read_data_o,
    output logic        valid_o,         // a set-point has been handed over
    output logic        hold_o,
    output logic        underrun_o
);

  localparam int unsigned IndexWidth = $clog2(Words);

  logic [31:0] memory[0:(2 << IndexWidth)-1];
  logic [31:0] read_q;
  logic front_q, complete_q, valid_q, hold_q, zero_q;

  always_ff @(posedge clk_i) begin
    if (write_i && 32'(write_index_i) < Words) memory[{!front_q, write_index_i[IndexWidth-1:0]}] <= write_data_i;
    read_q <= memory[{front_q, read_index_i[IndexWidth-1:0]}];
    zero_q <= 32'(read_index_i) >= Words || (hold_q && zero_on_hold_i[read_index_i]);
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      front_q    <= 1'b0;
      complete_q <= 1'b0;
      valid_q    <= 1'b0;
      hold_q     <= 1'b0;
    end else if (clear_i) begin
      complete_q <= 1'b0;
      valid_q    <= 1'b0;
      hold_q     <= 1'b0;
    end else if (swap_i) begin
      if (complete_q) front_q <= !front_q;
      complete_q <= 1'b0;
      valid_q    <= valid_q || complete_q;
      hold_q     <= valid_q && !complete_q;
    end else if (complete_i) begin
      complete_q <= 1'b1;
    end
  end

  assign read_data_o = zero_q ? 32'd0 : read_q;
  assign valid_o     = valid_q;
  assign hold_o      = hold_q;
  assign underrun_o  = swap_i && valid_q && !complete_q;

endmodule
