// SPDX-License-Identifier: Apache-2.0
// asip_limit: what a vector operation with a limit leaves of its operand a.
// Contract: with below_i the operand becomes max(min(a, 0), -32), with above_i max(a, 0); a NaN stays one, and
// without either the operand passes. A cycle after the inputs, keep_o is set if the operand is used and passes, least_o
// if it becomes -32. At most one of below_i and above_i is set.
// The exponents of the multiply-add follow in the cycle of the outputs, so only the last step of the test for a NaN is
// in that cycle.
module asip_limit (
    input  logic             clk_i,
    input  logic             used_i,
    input  logic             below_i,
    input  logic             above_i,
    input  asip_pkg::range_t range_i,
    output logic             keep_o,
    output logic             least_o
);

  logic used_q, limited_q, least_q, highest_q, fraction_q, number;

  always_ff @(posedge clk_i) begin
    used_q     <= used_i;
    limited_q  <= range_i.negative ? above_i || (below_i && range_i.beyond) : below_i;
    least_q    <= used_i && below_i && range_i.negative && range_i.beyond;
    highest_q  <= range_i.highest;
    fraction_q <= range_i.fraction;
  end

  assign number  = !(highest_q && fraction_q);
  assign keep_o  = used_q && !(limited_q && number);
  assign least_o = least_q && number;

endmodule
