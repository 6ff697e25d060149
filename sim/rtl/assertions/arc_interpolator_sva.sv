// SPDX-License-Identifier: Apache-2.0
// arc_interpolator_sva: no job is started over another, no step is made without one, a flush ends it.
module arc_interpolator_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic flush_i,
    input logic start_i,
    input logic advance_i,
    input logic active_o,
    input logic [1:0] step_o,
    input logic ready_o,
    input logic valid_o
);

  NoStartWhileActive : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start_i |-> !active_o)
  else $error("a job was started over another");

  FlushEndsIt : assert property (@(posedge clk_i) disable iff (!rst_ni)
      flush_i |=> !active_o)
  else $error("a job went on after a flush");

  StepOfAnAdvance : assert property (@(posedge clk_i) disable iff (!rst_ni)
      valid_o |-> $past(advance_i && ready_o))
  else $error("a step that nobody asked for");

  ReadyInAJob : assert property (@(posedge clk_i) disable iff (!rst_ni)
      ready_o |-> active_o)
  else $error("ready without a job");

  StepMoves : assert property (@(posedge clk_i) disable iff (!rst_ni)
      valid_o |-> step_o != 2'b00)
  else $error("a step without a motion");

endmodule

bind arc_interpolator arc_interpolator_sva u_sva (.*);
