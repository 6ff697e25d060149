// SPDX-License-Identifier: Apache-2.0
// quadrature_time_sva: samples stay until the next one, and a stamp is odd or says that nothing was counted.
module quadrature_time_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic sample_i,
    input logic signed [31:0] position_o,
    input logic signed [31:0] stamp_o
);

  StaysWithoutASample : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && !$past(sample_i)
      |-> position_o == $past(position_o) && stamp_o == $past(stamp_o))
  else $error("a sample changed by itself");

  OddOrNone : assert property (@(posedge clk_i) disable iff (!rst_ni) stamp_o[0] || stamp_o == '0)
  else $error("a stamp is no middle of a clock");

endmodule

bind quadrature_time quadrature_time_sva u_sva (.*);
