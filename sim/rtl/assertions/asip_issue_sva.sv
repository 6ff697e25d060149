// SPDX-License-Identifier: Apache-2.0
// asip_issue_sva: bundles issue within a run, none after a branch that is undecided; writes are announced.
module asip_issue_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic run_i,
    input logic valid_d_i,
    input logic issue_o,
    input logic branch_wait_o,
    input logic [2:0] soon_o,
    input logic [2:0] next_o,
    input logic [2:0] write_o
);

  BundleOfARun : assert property (@(posedge clk_i) disable iff (!rst_ni)
      issue_o |-> run_i && valid_d_i)
  else $error("a bundle issued that is not there, or outside a run");

  NoneBehindABranch : assert property (@(posedge clk_i) disable iff (!rst_ni)
      branch_wait_o |-> !issue_o)
  else $error("a bundle issued behind a branch that is undecided");

  WriteIsAnnounced : assert property (@(posedge clk_i) disable iff (!rst_ni)
      1'b1 |=> (next_o & ~$past(soon_o)) == 3'b000 && (write_o & ~$past(next_o)) == 3'b000)
  else $error("a write that readers did not know of two cycles before");

endmodule

bind asip_issue asip_issue_sva u_sva (.*);
