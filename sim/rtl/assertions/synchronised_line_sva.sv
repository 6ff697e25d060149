// SPDX-License-Identifier: Apache-2.0
// synchronised_line_sva: no line is started over another; a step moves the longest axis at least.
module synchronised_line_sva #(
    parameter int unsigned Axes = 5
) (
    input logic clk_i,
    input logic rst_ni,
    input logic flush_i,
    input logic start_i,
    input logic active_o,
    input logic ready_o,
    input logic [Axes-1:0] step_o
);

  NoStartWhileActive : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start_i |-> !active_o)
  else $error("a line was started over another");

  ReadyInAJob : assert property (@(posedge clk_i) disable iff (!rst_ni)
      ready_o |-> active_o)
  else $error("ready without a line");

  StepMoves : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (step_o != '0) == ready_o)
  else $error("a step without a motion, or a motion without a line");

  FlushEndsIt : assert property (@(posedge clk_i) disable iff (!rst_ni)
      flush_i |=> !active_o)
  else $error("a line went on after a flush");

endmodule

bind synchronised_line synchronised_line_sva #(
    .Axes(Axes)
) u_sva (.*);
