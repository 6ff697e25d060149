// SPDX-License-Identifier: Apache-2.0
// ecat_latch_sva: an event comes with an edge, keeps its time, and goes when its time was read.
module ecat_latch_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic [3:0] edges,
    input logic [3:0] single_q,
    input logic [3:0] event_q,
    input logic [3:0] cleared,
    input logic [255:0] times_q
);

  for (genvar n = 0; n < 4; n++) begin : gen_edge
    EventOfAnEdge : assert property (@(posedge clk_i) disable iff (!rst_ni)
        $rose(event_q[n]) |-> $past(edges[n] && single_q[n]))
    else $error("an event without an edge");

    EventStands : assert property (@(posedge clk_i) disable iff (!rst_ni)
        $past(rst_ni) && $fell(event_q[n]) |-> $past(cleared[n] || !single_q[n]))
    else $error("an event went before its time was read");

    EventKeepsItsTime : assert property (@(posedge clk_i) disable iff (!rst_ni)
        event_q[n] |=> $stable(times_q[64*n+:64]))
    else $error("a time changed while its event is set");
  end

endmodule

bind ecat_latch ecat_latch_sva u_sva (.*);
