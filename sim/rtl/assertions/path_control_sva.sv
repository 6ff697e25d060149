// SPDX-License-Identifier: Apache-2.0
// path_control_sva: a fault stays and stops everything until CLEAR; a command is not written over.
module path_control_sva #(
    parameter int unsigned Axes = 5
) (
    input logic clk_i,
    input logic rst_ni,
    input logic command_write_i,
    input logic word_write_i,
    input logic clear_i,
    input logic pending_o,
    input logic busy_o,
    input logic begins,
    input logic stop,
    input logic [6:0] fault_q,
    input logic [Axes-1:0] source_o,
    input logic [Axes-1:0] step_o
);

  FaultStays : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !clear_i |=> (fault_q & $past(fault_q)) == $past(fault_q))
  else $error("a fault went without CLEAR");

  NothingStartsInAFault : assert property (@(posedge clk_i) disable iff (!rst_ni)
      fault_q != '0 |-> !begins)
  else $error("a command began while a fault stood");

  NoneLost : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (command_write_i || word_write_i) && pending_o && !clear_i |=> fault_q != '0)
  else $error("a command was written over another, and nobody told");

  PendingIsKept : assert property (@(posedge clk_i) disable iff (!rst_ni)
      pending_o && !begins && !stop && fault_q == '0 |=> pending_o || fault_q != '0)
  else $error("a waiting command was lost");

  StopStops : assert property (@(posedge clk_i) disable iff (!rst_ni)
      stop |=> !busy_o && step_o == '0)
  else $error("a path went on after a stop");

  OwnAxesOnly : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (step_o & ~source_o) == '0)
  else $error("a step for an axis that has another source");

endmodule

bind path_control path_control_sva #(
    .Axes(Axes)
) u_sva (.*);
