// SPDX-License-Identifier: Apache-2.0
// line_interpolator_sva: no job is started over another, no step is made without one, a flush ends it.
module line_interpolator_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic flush_i,
    input logic start_i,
    input logic active_o,
    input logic [1:0] step_o
);

  NoStartWhileActive : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start_i |-> !active_o)
  else $error("a job was started over another");

  FlushEndsIt : assert property (@(posedge clk_i) disable iff (!rst_ni)
      flush_i |=> !active_o)
  else $error("a job went on after a flush");

  StepMoves : assert property (@(posedge clk_i) disable iff (!rst_ni)
      active_o |-> step_o != 2'b00)
  else $error("a step without a motion");

  NoStepElse : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !active_o |-> step_o == 2'b00)
  else $error("a step without a job");

endmodule

bind line_interpolator line_interpolator_sva u_sva (.*);
