// SPDX-License-Identifier: Apache-2.0
// step_output_sva: the drive's timing: pulse and pause last as long as the registers say, the direction is
// stable around a step; every step counts.
module step_output_sva #(
    parameter int unsigned TimeBits = 10
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [TimeBits-1:0] length_i,
    input logic [TimeBits-1:0] space_i,
    input logic [TimeBits-1:0] setup_i,
    input logic [TimeBits-1:0] hold_i,
    input logic step_o,
    input logic direction_o,
    input logic idle_o,
    input logic signed [31:0] position_o
);

  // Clocks that a line has been as it is, and since the last edge; saturating, from reset on long ago.
  logic [TimeBits:0] level_q, turned_q, fallen_q;

  function automatic logic [TimeBits:0] more(input logic [TimeBits:0] clocks);
    more = (clocks == '1) ? clocks : clocks + 1'b1;
  endfunction

  // 0 acts as 1.
  function automatic logic [TimeBits:0] least(input logic [TimeBits-1:0] clocks);
    least = (clocks == '0) ? (TimeBits + 1)'(1) : {1'b0, clocks};
  endfunction

  logic step_q, direction_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      step_q      <= 1'b0;
      direction_q <= 1'b0;
      level_q     <= '1;
      turned_q    <= '1;
      fallen_q    <= '1;
    end else begin
      step_q      <= step_o;
      direction_q <= direction_o;
      level_q     <= (step_o != step_q) ? (TimeBits + 1)'(1) : more(level_q);
      turned_q    <= (direction_o != direction_q) ? (TimeBits + 1)'(1) : more(turned_q);
      fallen_q    <= (step_q && !step_o) ? (TimeBits + 1)'(1) : more(fallen_q);
    end
  end

  PulseLength : assert property (@(posedge clk_i) disable iff (!rst_ni)
      step_q && !step_o |-> level_q == least(length_i))
  else $error("a step pulse is shorter or longer than asked for");

  PauseLength : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !step_q && step_o |-> level_q >= least(space_i))
  else $error("the pause between steps is too short");

  SetUp : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !step_q && step_o |-> turned_q >= least(setup_i) && direction_o == direction_q)
  else $error("the direction changed too late before a step");

  Hold : assert property (@(posedge clk_i) disable iff (!rst_ni)
      direction_o != direction_q |-> !step_o && !step_q && fallen_q >= least(hold_i))
  else $error("the direction changed too early after a step");

  EveryStepCounts : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !step_q && step_o |-> position_o == $past(position_o) + (direction_o ? -32'sd1 : 32'sd1))
  else $error("a step was not counted");

  OnlyStepsCount : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !(!step_q && step_o) |-> $stable(position_o) || $past(!rst_ni))
  else $error("the position changed without a step");

  IdleIsStill : assert property (@(posedge clk_i) disable iff (!rst_ni)
      idle_o |-> !step_o)
  else $error("idle within a step");

endmodule

bind step_output step_output_sva #(
    .TimeBits(TimeBits)
) u_sva (.*);
