// SPDX-License-Identifier: Apache-2.0
// period_timer_sva: a period starts at 0, and counts up by one to its end.
module period_timer_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic start_o,
    input logic [15:0] elapsed_o
);

  StartsAtZero : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start_o |-> elapsed_o == 16'd0)
  else $error("a period starts away from 0");

  ByOne : assert property (@(posedge clk_i) disable iff (!rst_ni)
      elapsed_o != 16'd0 |-> elapsed_o == $past(elapsed_o) + 16'd1 ||
      elapsed_o == $past(elapsed_o))
  else $error("a clock of a period was left out");

endmodule

bind period_timer period_timer_sva u_sva (.*);
