// SPDX-License-Identifier: Apache-2.0
// pwm_bridge_sva: a fault turns all gates off after the second edge that sees it, and stays.
module pwm_bridge_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic fault_i,
    input logic alarm_i,
    input logic clear_i,
    input logic trip_o,
    input logic [2:0] high_o,
    input logic [2:0] low_o
);

  logic [1:0] seen_q;  // a fault one, two clocks ago

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) seen_q <= '0;
    else seen_q <= {seen_q[0], fault_i || alarm_i};
  end

  OffInTwoClocks : assert property (@(posedge clk_i) disable iff (!rst_ni)
      seen_q[1] |-> high_o == 3'd0 && low_o == 3'd0 && trip_o)
  else $error("a gate is on two clocks behind a fault");

  TripHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      trip_o && !clear_i |=> trip_o)
  else $error("a trip was forgotten");

  OffWhileTripped : assert property (@(posedge clk_i) disable iff (!rst_ni)
      trip_o |=> high_o == 3'd0 && low_o == 3'd0)
  else $error("a gate is on in a trip");

endmodule

bind pwm_bridge pwm_bridge_sva u_sva (.*);
