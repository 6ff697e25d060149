// SPDX-License-Identifier: Apache-2.0
// fp_product: 24 x 24 bit product as three addends, the additions left to the caller. Combinational.
// Contract: a_i * b_i = outer_o + (cross_low_o + cross_high_o) * 2^17. The operands are cut at bit 17,
// the widest unsigned factor of an 18 x 18 multiplier: four of them, as for an inferred `*`. With macro XILINX
// only b_i is cut, for the 25 x 18 multipliers of DSP48: two of them. Nothing
// follows the multipliers, so that they can have a pipeline stage of their own.
module fp_product (
    input  logic [23:0] a_i,
    input  logic [23:0] b_i,
    output logic [47:0] outer_o,
    output logic [23:0] cross_low_o,
    output logic [23:0] cross_high_o
);

  // Assigned to full width each: inside a cast or a concatenation a product would keep its factors' width.
`ifdef XILINX
  logic [30:0] high;
  logic [40:0] low;

  assign high         = a_i * b_i[23:17];
  assign low          = a_i * b_i[16:0];
  assign outer_o      = {high[30:24], low};
  assign cross_low_o  = high[23:0];
  assign cross_high_o = '0;
`else
  logic [13:0] high;
  logic [33:0] low;

  assign high         = a_i[23:17] * b_i[23:17];
  assign low          = a_i[16:0] * b_i[16:0];
  assign outer_o      = {high, low};
  assign cross_low_o  = a_i[16:0] * b_i[23:17];
  assign cross_high_o = a_i[23:17] * b_i[16:0];
`endif

endmodule
