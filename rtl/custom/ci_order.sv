// SPDX-License-Identifier: Apache-2.0
// ci_order: order of two binary32 numbers. Combinational.
// Contract: below_o is the total order of numbers with -0 below +0, less_o and equal_o are those of
// IEEE 754-2019 (the zeros are equal). Meaningful only if neither operand is a NaN.
module ci_order (
    input  logic [31:0] a_i,
    input  logic [31:0] b_i,
    output logic        below_o,
    output logic        less_o,
    output logic        equal_o
);

  logic same, magnitude_below, zeros;
  assign same            = a_i[30:0] == b_i[30:0];
  assign magnitude_below = a_i[30:0] < b_i[30:0];
  assign zeros           = !(|{a_i[30:0], b_i[30:0]});

  assign below_o = (a_i[31] != b_i[31]) ? a_i[31] : !same && (magnitude_below != a_i[31]);
  assign less_o  = below_o && !zeros;
  assign equal_o = (same && a_i[31] == b_i[31]) || zeros;

endmodule
