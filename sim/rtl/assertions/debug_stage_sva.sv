// SPDX-License-Identifier: Apache-2.0
// debug_stage_sva: a staged page is taken between two runs, whole.
module debug_stage_sva (
    input logic        clk_i,
    input logic        rst_ni,
    input logic        core_busy_i,
    input logic        run_start_i,
    input logic        write_o,
    input logic        wait_i,
    input logic        last,
    input logic [6:0]  next_q,
    input logic [15:0] version_o
);

  BetweenRuns : assert property (@(posedge clk_i) disable iff (!rst_ni)
      write_o |-> !core_busy_i && !run_start_i)
  else $error("a parameter changed inside a run");

  WholePage : assert property (@(posedge clk_i) disable iff (!rst_ni)
      write_o && !wait_i && !last |=> write_o)
  else $error("a commit stopped between two words");

  NoRunOnPart : assert property (@(posedge clk_i) disable iff (!rst_ni)
      run_start_i |-> next_q == '0)
  else $error("a run began on a part of the staged words");

  WordWaits : assert property (@(posedge clk_i) disable iff (!rst_ni)
      write_o && !wait_i |=> !write_o || wait_i)
  else $error("a word was taken before the next one was read");

  VersionOfWholePages : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !last |=> $stable(version_o))
  else $error("the version changed without a commit");

endmodule

bind debug_stage debug_stage_sva u_sva (.*);
