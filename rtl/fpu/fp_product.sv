// SPDX-License-Identifier: Apache-2.0
// fp_product: 24 x 24 bit product as two addends, the last addition left to the caller. Combinational.
// Contract: a_i * b_i = outer_o + cross_o * 2^17. The operands are cut at bit 17, the widest unsigned
// factor of an 18 x 18 multiplier: four of them, as for an inferred `*`. Registering the two addends
// takes one of the two chained adders behind the multipliers out of the multiply stage.
module fp_product (
    input  logic [23:0] a_i,
    input  logic [23:0] b_i,
    output logic [47:0] outer_o,
    output logic [24:0] cross_o
);

  assign outer_o = {14'(a_i[23:17] * b_i[23:17]), 34'(a_i[16:0] * b_i[16:0])};
  assign cross_o = 25'(24'(a_i[16:0] * b_i[23:17])) + 25'(24'(a_i[23:17] * b_i[16:0]));

endmodule
