// SPDX-License-Identifier: Apache-2.0
// asip_limit: what a vector operation with a limit leaves of its operand a.
// Contract: with below_i the operand becomes max(min(a, 0), -32), with above_i max(a, 0); a NaN stays one, and without
// either the operand passes. A cycle after the inputs, keep_o is set if the operand passes, least_o if it becomes -32;
// it is zero without either, as is an operand that is not used. At most one of below_i and above_i is set.
module asip_limit (
    input  logic        clk_i,
    input  logic        used_i,
    input  logic        below_i,
    input  logic        above_i,
    input  logic [31:0] word_i,
    output logic        keep_o,
    output logic        least_o
);

  logic beyond, nan, limited;  // beyond: the magnitude is 32 or more, or the word is not finite

  assign beyond  = word_i[30] && (|word_i[29:25]);
  assign nan     = (&word_i[30:23]) && (|word_i[22:0]);
  assign limited = word_i[31] ? above_i || (below_i && beyond) : below_i;

  always_ff @(posedge clk_i) begin
    keep_o  <= used_i && (!limited || nan);
    least_o <= used_i && below_i && word_i[31] && beyond && !nan;
  end

endmodule
