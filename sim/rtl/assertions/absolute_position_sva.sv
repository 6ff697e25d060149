// SPDX-License-Identifier: Apache-2.0
// absolute_position_sva: single counts between frames, and no request of a port that is at work.
module absolute_position_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic request_o,
    input logic busy_i,
    input logic accept,
    input logic signed [31:0] position_o,
    input logic jump_o,
    input logic lost_o,
    input logic clear_i
);

  RequestsAnIdlePort : assert property (@(posedge clk_i) disable iff (!rst_ni)
      request_o |-> !busy_i)
  else $error("a frame was requested of a port that is at work");

  CountsSingly : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && !$past(accept)
      |-> position_o - $past(position_o) <= 1 && $past(position_o) - position_o <= 1)
  else $error("the position jumped without a frame");

  FlagsHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && !$past(clear_i) |-> (jump_o || !$past(jump_o)) && (lost_o || !$past(lost_o)))
  else $error("a fault of the encoder was forgotten without a clear");

endmodule

bind absolute_position absolute_position_sva u_sva (.*);
