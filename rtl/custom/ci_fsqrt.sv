// SPDX-License-Identifier: Apache-2.0
// ci_fsqrt: custom instruction, square root of a.
// Contract: that of ci_fdivsqrt with its n at 1; two of them on the same CPU share ci_fdivsqrt instead.
module ci_fsqrt (
    input  logic        clk_i,
    input  logic        reset_i,
    input  logic        clk_en_i,
    input  logic        start_i,
    input  logic [31:0] dataa_i,
    output logic [31:0] result_o
);

  ci_fdivsqrt u_core (
      .clk_i   (clk_i),
      .reset_i (reset_i),
      .clk_en_i(clk_en_i),
      .start_i (start_i),
      .n_i     (1'b1),
      .dataa_i (dataa_i),
      .datab_i (32'd0),
      .result_o(result_o)
  );

endmodule
