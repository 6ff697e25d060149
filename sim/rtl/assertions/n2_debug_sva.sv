// SPDX-License-Identifier: Apache-2.0
// n2_debug_sva: a halted core issues the debugger's instructions, each once, and nothing else.
module n2_debug_sva (
    input logic       clk_i,
    input logic       rst_ni,
    input logic       enable,
    input logic       halted,
    input logic       valid,
    input logic       issue,
    input logic       stop,
    input logic       watched,
    input logic       en,
    input logic [2:0] count
);

  HaltedIssuesNothing : assert property (@(posedge clk_i) disable iff (!rst_ni) halted && issue |-> valid)
  else $error("a halted core issued an instruction that its debugger had not asked for");

  IssuedOnce : assert property (@(posedge clk_i) disable iff (!rst_ni) valid && en |=> !valid)
  else $error("an instruction of the debugger was issued twice");

  IssuedInTime : assert property (@(posedge clk_i) disable iff (!rst_ni) valid && en |-> issue)
  else $error("an instruction of the debugger was lost");

  BusyOnlyHalted : assert property (@(posedge clk_i) disable iff (!rst_ni) $rose(count != 3'd0) |-> halted)
  else $error("an instruction of the debugger went to a core that runs");

  StopsOnlyEnabled : assert property (@(posedge clk_i) disable iff (!rst_ni) stop || watched |-> enable && !halted)
  else $error("a core without a debugger was stopped, or a halted one");

endmodule

bind n2_debug n2_debug_sva u_sva (
    .clk_i,
    .rst_ni (core_rst_ni),
    .enable (enable_q),
    .halted (halted_q),
    .valid  (state_o.valid),
    .issue  (event_i.issue_d),
    .stop   (break_d_o),
    .watched(watch_e_o),
    .en     (event_i.en),
    .count  (count_q)
);
