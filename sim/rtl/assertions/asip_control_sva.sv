// SPDX-License-Identifier: Apache-2.0
// asip_control_sva: a run is accepted once, commits or faults, and its first fault stays until CLEAR.
module asip_control_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic active,
    input logic start_q,
    input logic run_start_o,
    input logic commit_o,
    input logic fault_o,
    input logic busy_o,
    input logic done_o,
    input logic run_o,
    input logic [3:0] cause_o,
    input logic [15:0] fault_info_o,
    input logic [31:0] cycles_o
);

  StartOnlyIdle : assert property (@(posedge clk_i) disable iff (!rst_ni)
      run_start_o |-> !run_o && !fault_o)
  else $error("a run was accepted while one was active or a fault stood");

  BusyFromStart : assert property (@(posedge clk_i) disable iff (!rst_ni)
      run_start_o |=> busy_o && run_o)
  else $error("an accepted run does not run");

  BusyWhileActive : assert property (@(posedge clk_i) disable iff (!rst_ni)
      busy_o == (active || start_q))
  else $error("busy is not what control is");

  CommitOfAGoodRun : assert property (@(posedge clk_i) disable iff (!rst_ni)
      commit_o |=> done_o && !busy_o && !fault_o)
  else $error("outputs of a run that did not end well were shown");

  FirstFaultStays : assert property (@(posedge clk_i) disable iff (!rst_ni)
      fault_o && !clear_i |=> fault_o && $stable(cause_o) && $stable(fault_info_o))
  else $error("a fault or its cause changed before CLEAR");

  CauseOfAFault : assert property (@(posedge clk_i) disable iff (!rst_ni)
      fault_o == (cause_o != asip_regmap_pkg::FAULT_NONE))
  else $error("a fault without a cause, or a cause without a fault");

  CyclesKept : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !busy_o |=> busy_o || $stable(cycles_o))
  else $error("CYCLES changed outside a run");

endmodule

bind asip_control asip_control_sva u_sva (.*);
