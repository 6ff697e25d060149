// SPDX-License-Identifier: Apache-2.0
// asip_issue_single_sva: a unit that is busy gets no operation, and bank C no second write in a cycle.
module asip_issue_single_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic sine,          // issues
    input logic sine_busy,
    input logic division,      // issues
    input logic division_busy,
    input logic place_taken    // of the write of what issues
);

  OneSine : assert property (@(posedge clk_i) disable iff (!rst_ni) sine |-> !sine_busy)
  else $error("a sine issued while the unit is busy");

  OneDivision : assert property (@(posedge clk_i) disable iff (!rst_ni) division |-> !division_busy)
  else $error("a division issued while the unit is busy");

  PlaceIsFree : assert property (@(posedge clk_i) disable iff (!rst_ni) !place_taken)
  else $error("two writes of bank C in the same cycle, one of them lost");

endmodule

bind asip_issue_single asip_issue_single_sva u_sva (
    .clk_i,
    .rst_ni,
    .sine         (issue && op_d.sincos),
    .sine_busy    (sin_busy_q),
    .division     (issue && op_d.divsqrt),
    .division_busy(div_busy),
    .place_taken  (|(insert_c & taken_c))
);
