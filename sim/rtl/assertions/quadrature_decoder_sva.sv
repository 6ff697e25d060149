// SPDX-License-Identifier: Apache-2.0
// quadrature_decoder_sva: the position moves by single counts, an illegal transition moves nothing.
module quadrature_decoder_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic signed [31:0] position_o,
    input logic illegal_o,
    input logic [7:0] illegal_count_o
);

  logic signed [31:0] before_q, moved;

  always_ff @(posedge clk_i) before_q <= rst_ni ? position_o : '0;

  assign moved = position_o - before_q;

  SingleCounts : assert property (@(posedge clk_i) disable iff (!rst_ni)
      moved >= -32'sd1 && moved <= 32'sd1)
  else $error("the position jumped");

  IllegalMovesNothing : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && illegal_count_o > $past(illegal_count_o) |-> moved == 32'sd0)
  else $error("an illegal transition was counted");

  FlagHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      illegal_o && !clear_i |=> illegal_o)
  else $error("an illegal transition was forgotten");

endmodule

bind quadrature_decoder quadrature_decoder_sva u_sva (.*);
