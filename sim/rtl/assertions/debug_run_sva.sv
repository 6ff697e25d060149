// SPDX-License-Identifier: Apache-2.0
// debug_run_sva: a held core issues nothing but what a step or resume releases, and stops at its breakpoints.
module debug_run_sva (
    input logic                clk_i,
    input logic                rst_ni,
    input logic                run,
    input logic                quiet,
    input logic                issue_i,
    input logic [3:0]          match_d_q,
    input logic                release_q,
    input logic                resume,
    input logic                held_o,
    input logic                halted_o,
    input logic                freeze_o,
    input logic                wrote_q
);

  HeldIssuesNothing : assert property (@(posedge clk_i) disable iff (!rst_ni)
      held_o && !release_q |=> !issue_i)
  else $error("a bundle issued while the core is held");

  HaltedIsEmpty : assert property (@(posedge clk_i) disable iff (!rst_ni)
      halted_o |-> held_o && run && quiet && !issue_i)
  else $error("halted with a bundle or a result on its way: held %b run %b quiet %b issue %b", held_o, run,
              quiet, issue_i);

  OneBundlePerStep : assert property (@(posedge clk_i) disable iff (!rst_ni)
      held_o && $past(held_o && issue_i && !resume) |-> !issue_i)
  else $error("a step issued two bundles");

  StopsAtBreakpoint : assert property (@(posedge clk_i) disable iff (!rst_ni)
      issue_i && |match_d_q |-> $past(release_q))
  else $error("a bundle with a breakpoint issued without a release");

  WrittenFirst : assert property (@(posedge clk_i) disable iff (!rst_ni)
      wrote_q |=> !issue_i)
  else $error("a bundle issued while a word that the host wrote is on its way to its memory");

  FreezesHalted : assert property (@(posedge clk_i) disable iff (!rst_ni)
      freeze_o |-> halted_o)
  else $error("the watchdog stands while the core runs");

endmodule

bind debug_run debug_run_sva u_sva (
    .run  (core_i.run),
    .quiet(core_i.quiet),
    .*
);
