// SPDX-License-Identifier: Apache-2.0
// step_interpolator_sva: steps come with valid_o, in two axes, one for each advance.
module step_interpolator_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic flush_i,
    input logic start_i,
    input logic advance_i,
    input logic active_o,
    input logic ready_o,
    input logic valid_o,
    input logic [2:0] step_o
);

  NoStartWhileActive : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start_i |-> !active_o)
  else $error("a job was started over another");

  StepOfAnAdvance : assert property (@(posedge clk_i) disable iff (!rst_ni)
      valid_o == ($past(advance_i && ready_o) && !$past(flush_i)) || $past(!rst_ni))
  else $error("a step was lost, or came unasked");

  StepWithValid : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (step_o != 3'b000) == valid_o)
  else $error("a step without valid_o, or valid_o without a step");

  TwoAxes : assert property (@(posedge clk_i) disable iff (!rst_ni)
      step_o != 3'b111)
  else $error("a step in three axes of a plane");

  FlushEndsIt : assert property (@(posedge clk_i) disable iff (!rst_ni)
      flush_i |=> !active_o)
  else $error("a job went on after a flush");

endmodule

bind step_interpolator step_interpolator_sva u_sva (.*);
