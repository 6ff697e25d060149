// SPDX-License-Identifier: Apache-2.0
// asip_limit: what a vector operation with a limit leaves of its operand a, which is one of several.
// Contract: with below_i the operand becomes max(min(a, 0), -32), with above_i max(a, 0); a NaN stays one, and
// without either the operand passes. At most one operand is used; range_i has an asip_pkg::range_t of each. A cycle after
// the inputs, keep_o is set for an operand that is used and passes, least_o if the one used becomes -32. At most one of
// below_i and above_i is set.
// The exponents of the multiply-add follow in the cycle of the outputs, so only the last step of the test for a NaN is
// in that cycle.
module asip_limit #(
    parameter int unsigned Operands = 1
) (
    input  logic                  clk_i,
    input  logic [  Operands-1:0] used_i,
    input  logic                  below_i,
    input  logic                  above_i,
    input  logic [4*Operands-1:0] range_i,
    output logic [  Operands-1:0] keep_o,
    output logic                  least_o
);

  logic [Operands-1:0] used_q, limited_q, highest_q, fraction_q, nan, beyond;
  logic least_q;

  genvar i;
  generate
    for (i = 0; i < Operands; i++) begin : gen_operand
      asip_pkg::range_t range;

      assign range     = range_i[4*i+:4];
      assign beyond[i] = used_i[i] && range.negative && range.beyond;

      always_ff @(posedge clk_i) begin
        used_q[i]     <= used_i[i];
        limited_q[i]  <= range.negative ? above_i || (below_i && range.beyond) : below_i;
        highest_q[i]  <= used_i[i] && range.highest;
        fraction_q[i] <= range.fraction;
      end

      assign keep_o[i] = used_q[i] && (!limited_q[i] || nan[i]);
    end
  endgenerate

  always_ff @(posedge clk_i) least_q <= below_i && (|beyond);

  assign nan     = highest_q & fraction_q;
  assign least_o = least_q && !(|nan);

endmodule
