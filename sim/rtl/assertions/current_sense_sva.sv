// SPDX-License-Identifier: Apache-2.0
// current_sense_sva: a limit of 0 switches the comparator off.
module current_sense_sva #(
    parameter int unsigned FastRate = 8
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [3*$clog2(FastRate):0] limit_i,
    input logic over_o
);

  LimitZeroIsOff : assert property (@(posedge clk_i) disable iff (!rst_ni)
      limit_i == '0 |-> !over_o)
  else $error("an overcurrent without a limit");

endmodule

bind current_sense current_sense_sva #(
    .FastRate(FastRate)
) u_sva (.*);
