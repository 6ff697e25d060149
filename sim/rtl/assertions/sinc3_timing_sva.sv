// SPDX-License-Identifier: Apache-2.0
// sinc3_timing_sva: filters work between two strobes, a window ends at a corner.
module sinc3_timing_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic strobe_o,
    input logic [2:0] corner_o,
    input logic [2:0] fast_o,
    input logic fast_valid_o,
    input logic done_o
);

  BehindAStrobe : assert property (@(posedge clk_i) disable iff (!rst_ni)
      corner_o[0] || fast_o[0] |-> $past(strobe_o))
  else $error("a filter's step without new bits");

  DoneOfACorner : assert property (@(posedge clk_i) disable iff (!rst_ni)
      done_o |-> $past(corner_o[2]))
  else $error("a window's end without a corner");

  ValidOfAStep : assert property (@(posedge clk_i) disable iff (!rst_ni)
      fast_valid_o |-> $past(fast_o[2]))
  else $error("a fast value without its differences");

endmodule

bind sinc3_timing sinc3_timing_sva u_sva (.*);
