// SPDX-License-Identifier: Apache-2.0
// asip_limit: what a vector operation with a limit leaves of its operand a. Combinational.
// Contract: with below_i the operand becomes max(min(a, 0), -32), with above_i max(a, 0); a NaN stays one, and without
// either the operand passes. asip_pkg::limited makes the result of the outputs: the operand passes with keep_o, it is a
// NaN and stays one with both of nan_o, which are the halves of fp_pkg::is_nan because it is late, and -32 comes from
// least_o. At most one of below_i and above_i is set.
module asip_limit (
    input  logic        below_i,
    input  logic        above_i,
    input  logic [31:0] word_i,
    output logic        keep_o,
    output logic [1:0]  nan_o,  // the exponent is all ones, the fraction is not zero
    output logic        least_o
);

  logic beyond;  // the magnitude is 32 or more, or the word is not finite

  assign beyond  = word_i[30] && (|word_i[29:25]);
  assign keep_o  = word_i[31] ? !above_i && !(below_i && beyond) : !below_i;
  assign nan_o   = {&word_i[30:23], |word_i[22:0]};
  assign least_o = below_i && word_i[31] && beyond;

endmodule
