// SPDX-License-Identifier: Apache-2.0
// n2_mul: 32 x 32 bit multiplier over stages E, M and A.
// Contract: operands in E, product_a_o registered in A. Cut at bit 16 into four 17 x 17 bit signed
// products, registered between E and M, so that each is one element of any vendor's DSP block; their sum
// is registered between M and A. The low word does not depend on the signs.
module n2_mul (
    input  logic        clk_i,
    input  logic        en_i,
    input  logic [31:0] a_i,
    input  logic [31:0] b_i,
    input  logic        signed_a_i,
    input  logic        signed_b_i,
    output logic [63:0] product_a_o
);

  logic signed [16:0] a_low, a_high, b_low, b_high;
  logic signed [33:0] cross_ab_q, cross_ba_q;
  logic [31:0] low_q, high_q;
  logic signed [34:0] middle;
  logic [47:0] upper;
  logic [63:0] product_a_q;

  assign a_low  = {1'b0, a_i[15:0]};
  assign b_low  = {1'b0, b_i[15:0]};
  assign a_high = {signed_a_i && a_i[31], a_i[31:16]};
  assign b_high = {signed_b_i && b_i[31], b_i[31:16]};

  assign middle = 35'(cross_ab_q) + 35'(cross_ba_q);
  assign upper = {high_q, low_q[31:16]} + {{13{middle[34]}}, middle};

  always_ff @(posedge clk_i) begin
    if (en_i) begin
      low_q       <= a_low * b_low;    // all four 17 x 17 bit products take the width of their target
      cross_ab_q  <= a_high * b_low;
      cross_ba_q  <= a_low * b_high;
      high_q      <= a_high * b_high;
      product_a_q <= {upper, low_q[15:0]};
    end
  end

  assign product_a_o = product_a_q;

endmodule
