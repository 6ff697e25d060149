// SPDX-License-Identifier: Apache-2.0
// n2_timer_sva: an event is not lost: it stays until it is cleared.
module n2_timer_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic last,
    input logic write_i,
    input logic event_q,
    input logic tick_o,
    input logic irq_o
);

  EventStands : assert property (@(posedge clk_i) disable iff (!rst_ni)
      event_q && !write_i |=> event_q)
  else $error("an event went without being cleared");

  EventOfAnEnd : assert property (@(posedge clk_i) disable iff (!rst_ni)
      last |=> event_q)
  else $error("the end of a period made no event");

  TickAtTheEnd : assert property (@(posedge clk_i) disable iff (!rst_ni)
      tick_o |-> last)
  else $error("a tick within a period");

  InterruptOfAnEvent : assert property (@(posedge clk_i) disable iff (!rst_ni)
      irq_o |-> event_q)
  else $error("an interrupt without an event");

endmodule

bind n2_timer n2_timer_sva u_sva (.*);
