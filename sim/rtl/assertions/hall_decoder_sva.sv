// SPDX-License-Identifier: Apache-2.0
// hall_decoder_sva: a sector changes with an edge alone, single counts within it, and faults are held.
module hall_decoder_sva #(
    parameter int unsigned Bits = 8
) (
    input logic clk_i,
    input logic rst_ni,
    input logic valid,
    input logic edge_found,
    input logic late,
    input logic legal,
    input logic clear_i,
    input logic signed [31:0] position_o,
    input logic jump_o,
    input logic illegal_o
);

  // The first sector is taken without an edge, from position 2^Bits / 2.
  SectorOfAnEdge : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && !$past(valid) |-> position_o[31:Bits] == $past(position_o[31:Bits]))
  else $error("the sector changed without a state of the lines");

  CountsSingly : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && !$past(edge_found || late || (valid && !legal)) && $past(position_o) != 32'(1 << (Bits - 1))
      |-> position_o - $past(position_o) <= 1 && $past(position_o) - position_o <= 1)
  else $error("the position jumped within a sector");

  FlagsHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && !$past(clear_i) |-> (jump_o || !$past(jump_o)) && (illegal_o || !$past(illegal_o)))
  else $error("a fault of the lines was forgotten without a clear");

endmodule

bind hall_decoder hall_decoder_sva #(
    .Bits(Bits)
) u_sva (.*);
