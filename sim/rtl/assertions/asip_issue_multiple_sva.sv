// SPDX-License-Identifier: Apache-2.0
// asip_issue_multiple_sva: the sine unit gets no operation while it is busy, and no result of it is lost.
module asip_issue_multiple_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic sine,       // issues
    input logic sine_busy,
    input logic sine_ends,  // its write begins to wait for the schedule
    input logic sine_waits,
    input logic sine_joins
);

  OneSine : assert property (@(posedge clk_i) disable iff (!rst_ni) sine |-> !sine_busy)
  else $error("a sine issued while the unit is busy");

  OneWaits : assert property (@(posedge clk_i) disable iff (!rst_ni)
      sine_ends |-> !sine_waits || sine_joins)
  else $error("the write of a sine replaced one that waits");

endmodule

bind asip_issue_multiple asip_issue_multiple_sva u_sva (
    .clk_i,
    .rst_ni,
    .sine      (issue && aux.sincos),
    .sine_busy (sin_busy_q),
    .sine_ends (sin_busy_q && sin_left_q == SinWidth'(1)),
    .sine_waits(sin_waits_q),
    .sine_joins(sin_join)
);
