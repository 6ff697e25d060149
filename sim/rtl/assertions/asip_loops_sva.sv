// SPDX-License-Identifier: Apache-2.0
// asip_loops_sva: bundles issue in the order that the loops of D say, so fetch decided as D does.
module asip_loops_sva #(
    parameter int unsigned Loops = 1,
    parameter int unsigned CountWidth = 1
) (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic branch_i,
    input logic resume_i,
    input logic advance_i,
    input logic turn_o,
    input logic issue_i,
    input logic [15:0] pc_d_i,
    input logic [1:0] step,
    input logic [1:0] turns,
    input logic [1:0] late_q,
    input logic [1:0][1:0] turning,
    input logic [15:0] target_q,
    input logic [1:0][Loops-1:0] more,
    input logic [Loops-1:0][CountWidth-1:0] left
);

  // Bundle that issues next, once one has since the last redirection.
  logic known_q;
  logic [15:0] next_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) known_q <= 1'b0;
    else if (clear_i || branch_i) known_q <= 1'b0;
    else if (issue_i) known_q <= 1'b1;
  end

  always_ff @(posedge clk_i) if (issue_i) next_q <= turning[1][1] ? target_q : pc_d_i + 16'd1;

  InOrder : assert property (@(posedge clk_i) disable iff (!rst_ni)
      issue_i && known_q |-> pc_d_i == next_q)
  else $error("the bundle that issues is not the one that the loops say");

  NothingIssues : assert property (@(posedge clk_i) disable iff (!rst_ni)
      clear_i || branch_i || resume_i |-> !issue_i)
  else $error("a bundle issues in the cycle of a redirection");

  RoundsLeft : assert property (@(posedge clk_i) disable iff (!rst_ni)
      |more[0] |-> |left)
  else $error("a loop goes on without a round left");

  OneTurn : assert property (@(posedge clk_i) disable iff (!rst_ni)
      step[1] && turns[1] |-> turning[1] == 2'b00)
  else $error("a mark counts in the two bundles after another");

  TurnOfAMark : assert property (@(posedge clk_i) disable iff (!rst_ni)
      turn_o |-> late_q[1] || (advance_i && turns[0]))
  else $error("fetch turns without a mark");

  Closed : assert property (@(posedge clk_i) disable iff (!rst_ni)
      clear_i |=> more == '0)
  else $error("a loop is open before the first bundle");

endmodule

bind asip_loops asip_loops_sva #(
    .Loops(Loops),
    .CountWidth(CountWidth)
) u_sva (.*);
