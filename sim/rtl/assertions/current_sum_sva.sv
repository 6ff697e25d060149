// SPDX-License-Identifier: Apache-2.0
// current_sum_sva: a limit of 0 switches the comparison off, and a sum that was found stays until it is cleared.
module current_sum_sva #(
    parameter int unsigned SlowRate = 64
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [3*$clog2(SlowRate)+1:0] limit_i,
    input logic clear_i,
    input logic over_o
);

  LimitZeroIsOff : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && $past(limit_i) == '0 && over_o |-> $past(over_o))
  else $error("a sum is reported without a limit");

  StaysUntilCleared : assert property (@(posedge clk_i) disable iff (!rst_ni)
      over_o && !clear_i |=> over_o)
  else $error("a sum is forgotten without a clear");

endmodule

bind current_sum current_sum_sva #(
    .SlowRate(SlowRate)
) u_sva (.*);
