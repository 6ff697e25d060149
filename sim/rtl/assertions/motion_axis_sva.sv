// SPDX-License-Identifier: Apache-2.0
// motion_axis_sva: after an abort an axis asks for nothing more.
module motion_axis_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic abort_i,
    input logic pulse_o
);

  NoPulseAfterAnAbort : assert property (@(posedge clk_i) disable iff (!rst_ni)
      abort_i |=> !pulse_o)
  else $error("a pulse after an abort");

endmodule

bind motion_axis motion_axis_sva u_sva (.*);
