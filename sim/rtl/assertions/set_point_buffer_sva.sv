// SPDX-License-Identifier: Apache-2.0
// set_point_buffer_sva: a set-point is handed over whole.
module set_point_buffer_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic swap_i,
    input logic write_i,
    input logic complete_i,
    input logic valid_o,
    input logic hold_o,
    input logic underrun_o
);

  NotTornApart : assert property (@(posedge clk_i) disable iff (!rst_ni)
      swap_i |-> !write_i && !complete_i)
  else $error("a word was written while the banks change");

  HoldAfterAnUnderrun : assert property (@(posedge clk_i) disable iff (!rst_ni)
      underrun_o && !clear_i |=> hold_o)
  else $error("an old set-point is used as a new one");

  HoldOfASetPoint : assert property (@(posedge clk_i) disable iff (!rst_ni)
      hold_o |-> valid_o)
  else $error("a set-point is held that never was");

endmodule

bind set_point_buffer set_point_buffer_sva u_sva (.*);
