// SPDX-License-Identifier: Apache-2.0
// fp_product: 24 x 24 bit product as three addends, the additions left to the caller. Combinational.
// Contract: a_i * b_i = outer_o + (cross_low_o + cross_high_o) * 2^17. The operands are cut at bit 17,
// the widest unsigned factor of an 18 x 18 multiplier: four of them, as for an inferred `*`. Nothing
// follows the multipliers, so that they can have a pipeline stage of their own.
module fp_product (
    input  logic [23:0] a_i,
    input  logic [23:0] b_i,
    output logic [47:0] outer_o,
    output logic [23:0] cross_low_o,
    output logic [23:0] cross_high_o
);

  assign outer_o      = {14'(a_i[23:17] * b_i[23:17]), 34'(a_i[16:0] * b_i[16:0])};
  assign cross_low_o  = 24'(a_i[16:0] * b_i[23:17]);
  assign cross_high_o = 24'(a_i[23:17] * b_i[16:0]);

endmodule
