// SPDX-License-Identifier: Apache-2.0
// asip_redundancy_sva: two runs before outputs are shown, three at most, each from a core in reset; busy ends in any case.
module asip_redundancy_sva #(
    parameter int unsigned Drain = 256
) (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic [31:0] watchdog_i,
    input logic busy_i,
    input logic start_o,
    input logic scrub_o,
    input logic scrub_control_o,
    input logic commit_o,
    input logic busy_o,
    input logic done_o,
    input logic fault_o,
    input logic [3:0] cause_o,
    input logic repaired_o,
    input logic [31:0] cycles_o
);

  localparam int unsigned Copies = 80;  // a third of the clocks of copies and resets in a tick

  logic [1:0]  runs_q;   // of this tick
  logic        reset_q;  // the core was in reset since the last of them began
  logic [31:0] watchdog_q;
  logic [34:0] clocks_q, most;

  assign most = 35'd3 * (35'(watchdog_i) + 35'(Drain + Copies));

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      runs_q     <= '0;
      reset_q    <= 1'b0;
      watchdog_q <= '0;
      clocks_q   <= '0;
    end else begin
      runs_q     <= !busy_o ? '0 : runs_q + 2'(start_o);
      reset_q    <= !start_o && (reset_q || (scrub_o && scrub_control_o));
      watchdog_q <= watchdog_i;
      clocks_q   <= busy_o && watchdog_i == watchdog_q ? clocks_q + 35'd1 : '0;
    end
  end

  OneVerdict : assert property (@(posedge clk_i) disable iff (!rst_ni) !(done_o && fault_o))
  else $error("a tick is done and at fault");

  CauseOfAFault : assert property (@(posedge clk_i) disable iff (!rst_ni)
      fault_o == (cause_o != asip_regmap_pkg::FAULT_NONE))
  else $error("a fault without a cause, or a cause without a fault");

  FaultStays : assert property (@(posedge clk_i) disable iff (!rst_ni)
      fault_o && !clear_i |=> fault_o)
  else $error("a fault fell before CLEAR");

  CommitOfTwoRuns : assert property (@(posedge clk_i) disable iff (!rst_ni)
      commit_o |-> busy_o && runs_q >= 2'd2)
  else $error("outputs were shown of fewer than two runs");

  CommitOfAGoodTick : assert property (@(posedge clk_i) disable iff (!rst_ni)
      commit_o |=> done_o && !busy_o && !fault_o)
  else $error("outputs of a tick that did not end well were shown");

  ThreeRunsAtMost : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start_o |-> busy_o && runs_q != 2'd3)
  else $error("a run outside a tick, or a fourth one");

  StartOfAnIdleCore : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start_o |-> !busy_i && !scrub_o)
  else $error("a run was started in a core that is busy or in reset");

  ResetBetweenRuns : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start_o && runs_q != 2'd0 |-> reset_q)
  else $error("a run begins with what the one before has left");

  RepairedByAThird : assert property (@(posedge clk_i) disable iff (!rst_ni)
      repaired_o && !$past(repaired_o) |-> runs_q == 2'd3)
  else $error("a tick was repaired without a third run");

  BusyEnds : assert property (@(posedge clk_i) disable iff (!rst_ni)
      busy_o |-> clocks_q < most)
  else $error("a tick outlasts its watchdogs");

  CyclesKept : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !busy_o |=> busy_o || $stable(cycles_o))
  else $error("CYCLES changed outside a tick");

endmodule

bind asip_redundancy asip_redundancy_sva #(
    .Drain(Drain)
) u_sva (.*);
