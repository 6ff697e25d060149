// SPDX-License-Identifier: Apache-2.0
// n2_control_sva: one event per cycle, but a return to a bad target is a fault too, and the fault counts;
// an interrupt is requested only while enabled.
module n2_control_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic strobe_i,
    input logic fault_i,
    input logic leave_i,
    input logic wrctl_i,
    input logic interrupt_o,
    input logic pie_q
);

  OneEvent : assert property (@(posedge clk_i) disable iff (!rst_ni)
      strobe_i |-> $onehot0({fault_i || leave_i, wrctl_i}))
  else $error("two events in one cycle, one of them lost");

  InterruptEnabled : assert property (@(posedge clk_i) disable iff (!rst_ni)
      interrupt_o |-> $past(pie_q))
  else $error("an interrupt while they are off");

  FaultTurnsOff : assert property (@(posedge clk_i) disable iff (!rst_ni)
      strobe_i && fault_i |=> !pie_q)
  else $error("interrupts stay on in a handler");

endmodule

bind n2_control n2_control_sva u_sva (.*);
