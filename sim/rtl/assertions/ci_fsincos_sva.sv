// SPDX-License-Identifier: Apache-2.0
// ci_fsincos_sva: a result is there from its cycle to the next one, however long the CPU stalls.
module ci_fsincos_sva (
    input logic        clk_i,
    input logic        reset_i,
    input logic        valid,
    input logic [31:0] result_o
);

  ResultStays : assert property (@(posedge clk_i) disable iff (reset_i)
      !valid |-> result_o == $past(result_o))
  else $error("a result changed without an operation");

endmodule

bind ci_fsincos ci_fsincos_sva u_sva (.*);
