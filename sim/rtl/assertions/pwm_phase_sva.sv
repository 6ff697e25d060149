// SPDX-License-Identifier: Apache-2.0
// pwm_phase_sva: no shoot-through; no gate turns on before the dead time is over; off is off.
module pwm_phase_sva #(
    parameter int unsigned DeadBits = 8
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [DeadBits-1:0] dead_time_i,
    input logic off_i,
    input logic high_o,
    input logic low_o
);

  // Clocks without a gate so far, saturating; the dead time when the last one turned off.
  logic [DeadBits-1:0] none_q, dead_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      none_q <= '0;
      dead_q <= '0;
    end else if (high_o || low_o) begin
      none_q <= '0;
      dead_q <= dead_time_i;
    end else if (none_q != '1) none_q <= none_q + 1'b1;
  end

  NeverBoth : assert property (@(posedge clk_i) disable iff (!rst_ni) !(high_o && low_o))
  else $error("both gates of a phase are on");

  DeadTime : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (high_o && !$past(high_o)) || (low_o && !$past(low_o)) |-> none_q >= dead_q && none_q != '0)
  else $error("a gate turned on within the dead time");

  OffIsOff : assert property (@(posedge clk_i) disable iff (!rst_ni)
      off_i |=> !high_o && !low_o)
  else $error("a gate is on behind off_i");

endmodule

bind pwm_phase pwm_phase_sva #(
    .DeadBits(DeadBits)
) u_sva (.*);
