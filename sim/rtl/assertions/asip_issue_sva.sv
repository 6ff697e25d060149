// SPDX-License-Identifier: Apache-2.0
// asip_issue_sva: bundles issue within a run, and none behind a branch that is undecided.
module asip_issue_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic run_i,
    input logic valid_d_i,
    input logic issue_o,
    input logic branch_wait_o
);

  BundleOfARun : assert property (@(posedge clk_i) disable iff (!rst_ni)
      issue_o |-> run_i && valid_d_i)
  else $error("a bundle issued that is not there, or outside a run");

  NoneBehindABranch : assert property (@(posedge clk_i) disable iff (!rst_ni)
      branch_wait_o |-> !issue_o)
  else $error("a bundle issued behind a branch that is undecided");

endmodule

bind asip_issue asip_issue_sva u_sva (.*);
