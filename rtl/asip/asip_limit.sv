// SPDX-License-Identifier: Apache-2.0
// asip_limit: what a vector operation with a limit leaves of its operand a. Combinational.
// Contract: with below_i the operand becomes max(min(a, 0), -32), with above_i max(a, 0); a NaN stays one, and without
// either the operand passes. asip_pkg::limited makes the result of the three outputs: the operand passes with keep_o,
// a NaN stays one with nan_o, which is late and depends on the word alone, and -32 comes from least_o. At most one of
// below_i and above_i is set.
module asip_limit (
    input  logic        below_i,
    input  logic        above_i,
    input  logic [31:0] word_i,
    output logic        keep_o,
    output logic        nan_o,
    output logic        least_o
);

  logic beyond;  // the magnitude is 32 or more, or the word is not finite

  assign beyond  = word_i[30] && (|word_i[29:25]);
  assign keep_o  = word_i[31] ? !above_i && !(below_i && beyond) : !below_i;
  assign nan_o   = fp_pkg::is_nan(word_i);
  assign least_o = below_i && word_i[31] && beyond;

endmodule
