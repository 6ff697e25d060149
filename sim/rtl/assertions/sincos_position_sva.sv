// SPDX-License-Identifier: Apache-2.0
// sincos_position_sva: the point ends on the axis, one end for each sample, and the position holds between ends.
module sincos_position_sva #(
    parameter int unsigned Bits = 10
) (
    input logic clk_i,
    input logic rst_ni,
    input logic sample_i,
    input logic window_o,
    input logic busy_o,
    input logic done_o,
    input logic [1:0] state_q,
    input logic signed [63:0] x_q,
    input logic signed [63:0] y_q,
    input logic [Bits-1:0] position_o
);

  localparam logic [1:0] End = 2'd3;  // of state_q

  // The last rotation is by arctan(2^-Bits); each one may cut a bit off.
  EndsOnTheAxis : assert property (@(posedge clk_i) disable iff (!rst_ni)
      state_q == End |-> x_q >= -64'sd64 && y_q <= (x_q >>> Bits) + 64'sd64 && -y_q <= (x_q >>> Bits) + 64'sd64)
  else $error("the rotations did not reach the axis");

  OneWindowAtATime : assert property (@(posedge clk_i) disable iff (!rst_ni)
      window_o |-> sample_i && !busy_o)
  else $error("a window began without a request, or within another one");

  EndsOnce : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && done_o |-> $past(state_q) == End && !$past(done_o))
  else $error("an end without a sample");

  HoldsBetweenEnds : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && !done_o |-> position_o == $past(position_o))
  else $error("the position changed without an end");

endmodule

bind sincos_position sincos_position_sva #(
    .Bits(Bits)
) u_sva (
    .state_q(2'(state_q)),
    .x_q(64'(x_q)),
    .y_q(64'(y_q)),
    .*
);
