// SPDX-License-Identifier: Apache-2.0
// biss_master_sva: a frame ends once; a bad one leaves the position alone; MA rests high.
module biss_master_sva #(
    parameter int unsigned Width = 26
) (
    input logic clk_i,
    input logic rst_ni,
    input logic start_i,
    input logic ma_o,
    input logic busy_o,
    input logic done_o,
    input logic [Width-1:0] position_o,
    input logic crc_error_o,
    input logic lost_o
);

  DoneOfAFrame : assert property (@(posedge clk_i) disable iff (!rst_ni)
      done_o |-> $past(busy_o) || $past(start_i))
  else $error("an end without a frame");

  BadFrameChangesNothing : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && (lost_o || crc_error_o || !done_o) |-> $stable(position_o))
  else $error("a position that no good frame brought");

  RequestLowersMa : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start_i && !busy_o |=> (busy_o && !ma_o) || (done_o && lost_o))
  else $error("a request neither lets MA fall nor ends lost");

  RestsHigh : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !busy_o && !start_i |=> ma_o)
  else $error("MA is low without a frame");

endmodule

bind biss_master biss_master_sva #(
    .Width(Width)
) u_sva (.*);
