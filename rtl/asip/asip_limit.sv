// SPDX-License-Identifier: Apache-2.0
// asip_limit: what a vector operation with a limit leaves of its operand a. Combinational.
// Contract: with below_i the operand becomes max(min(a, 0), -32), with above_i max(a, 0); a NaN stays one, and without
// either the operand passes. asip_pkg::limited makes the result of the outputs: the operand passes with keep_o, it is a
// NaN and stays one with both bits of nan_o, which are two because they are late, and -32 comes from least_o. At most
// one of below_i and above_i is set.
module asip_limit (
    input  logic             below_i,
    input  logic             above_i,
    input  asip_pkg::facts_t facts_i,  // of the operand
    output logic             keep_o,
    output logic [1:0]       nan_o,
    output logic             least_o
);

  assign keep_o  = facts_i.negative ? !above_i && !(below_i && facts_i.beyond) : !below_i;
  assign nan_o   = {facts_i.highest, facts_i.fraction};
  assign least_o = below_i && facts_i.negative && facts_i.beyond;

endmodule
