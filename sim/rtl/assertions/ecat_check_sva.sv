// SPDX-License-Identifier: Apache-2.0
// ecat_check_sva: a verdict comes between two frames, and a frame ends once.
module ecat_check_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic tick_i,
    input ecat_pkg::nibble_t nibble_i,
    input logic body_o,
    input logic end_o,
    input logic bad_o,
    input logic marked_o,
    input logic error_o
);

  VerdictStands : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !(tick_i && nibble_i.valid) |=> $stable({bad_o, marked_o, error_o}))
  else $error("the verdict on a frame changed without a nibble");

  MarkedIsBad : assert property (@(posedge clk_i) disable iff (!rst_ni)
      marked_o || error_o |-> bad_o)
  else $error("a marked frame, or one with RX_ER, is good");

  EndOfABody : assert property (@(posedge clk_i) disable iff (!rst_ni)
      end_o |-> !nibble_i.valid && !body_o)
  else $error("a frame ends before its last nibble");

  EndOnce : assert property (@(posedge clk_i) disable iff (!rst_ni)
      tick_i && end_o |=> !end_o)
  else $error("a frame ends twice");

endmodule

bind ecat_check ecat_check_sva u_sva (.*);
