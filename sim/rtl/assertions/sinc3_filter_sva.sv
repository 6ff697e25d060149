// SPDX-License-Identifier: Apache-2.0
// sinc3_filter_sva: values change with the last of their three differences only.
module sinc3_filter_sva #(
    parameter int unsigned SlowRate = 64,
    parameter int unsigned FastRate = 8
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [2:0] corner_i,
    input logic [2:0] fast_i,
    input logic signed [3*$clog2(SlowRate):0] slow_o,
    input logic signed [3*$clog2(FastRate):0] fast_o
);

  SlowHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !corner_i[2] |=> $stable(slow_o))
  else $error("a sample changed between windows");

  FastHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !fast_i[2] |=> $stable(fast_o))
  else $error("a fast value changed between its instants");

endmodule

bind sinc3_filter sinc3_filter_sva #(
    .SlowRate(SlowRate),
    .FastRate(FastRate)
) u_sva (.*);
