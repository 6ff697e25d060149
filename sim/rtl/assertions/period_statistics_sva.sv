// SPDX-License-Identifier: Apache-2.0
// period_statistics_sva: extremes hold the last value, and move one way until they are cleared.
module period_statistics_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic [15:0] command_max_o,
    input logic [15:0] copy_max_o,
    input logic [15:0] used_max_o,
    input logic [31:0] left_min_o
);

  MaximaGrow : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !clear_i |=> command_max_o >= $past(command_max_o) && copy_max_o >= $past(copy_max_o) &&
      used_max_o >= $past(used_max_o))
  else $error("a maximum became smaller");

  MinimumFalls : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !clear_i |=> left_min_o <= $past(left_min_o))
  else $error("a minimum became larger");

endmodule

bind period_statistics period_statistics_sva u_sva (.*);
