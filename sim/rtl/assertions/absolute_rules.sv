// SPDX-License-Identifier: Apache-2.0
// absolute_rules: of the master of an absolute encoder: a frame ends once; a bad one leaves the position alone; the clock
// rests high.
module absolute_rules #(
    parameter int unsigned Width = 25
) (
    input logic clk_i,
    input logic rst_ni,
    input logic start,
    input logic clock,
    input logic busy,
    input logic done,
    input logic [Width-1:0] position,
    input logic crc_error,
    input logic lost
);

  DoneOfAFrame : assert property (@(posedge clk_i) disable iff (!rst_ni)
      done |-> $past(busy) || $past(start))
  else $error("an end without a frame");

  BadFrameChangesNothing : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && (lost || crc_error || !done) |-> $stable(position))
  else $error("a position that no good frame brought");

  RequestLowersTheClock : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start && !busy |=> (busy && !clock) || (done && lost))
  else $error("a request neither lets the clock fall nor ends lost");

  RestsHigh : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !busy && !start |=> clock)
  else $error("the clock is low without a frame");

endmodule
