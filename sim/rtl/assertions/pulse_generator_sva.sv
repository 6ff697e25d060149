// SPDX-License-Identifier: Apache-2.0
// pulse_generator_sva: a pulse is one clock long.
module pulse_generator_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic pulse_o,
    input logic [31:0] count_o
);

  OneClock : assert property (@(posedge clk_i) disable iff (!rst_ni)
      pulse_o |=> !pulse_o)
  else $error("two pulses in a row");

  EveryPulseCounts : assert property (@(posedge clk_i) disable iff (!rst_ni)
      pulse_o |=> count_o == $past(count_o) + 32'd1)
  else $error("a pulse was not counted");

  OnlyPulsesCount : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !pulse_o |=> $stable(count_o))
  else $error("the count changed without a pulse");

endmodule

bind pulse_generator pulse_generator_sva u_sva (.*);
