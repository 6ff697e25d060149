// SPDX-License-Identifier: Apache-2.0
// debug_link_sva: the line changes its rate by a write only; every dropped packet counts.
module debug_link_sva (
    input logic        clk_i,
    input logic        rst_ni,
    input logic        csr_write_i,
    input logic        dropped,
    input logic [15:0] divider_q,
    input logic [15:0] dropped_q
);

  RateStays : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !csr_write_i |=> $stable(divider_q))
  else $error("the rate of the line changed without a write");

  DroppedCount : assert property (@(posedge clk_i) disable iff (!rst_ni)
      1'b1 |=> dropped_q == $past(dropped_q) + 16'($past(dropped)))
  else $error("a dropped packet was not counted, or twice");

endmodule

bind debug_link debug_link_sva u_sva (.*);
