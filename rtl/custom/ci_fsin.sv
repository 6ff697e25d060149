// SPDX-License-Identifier: Apache-2.0
// ci_fsin: custom instruction, sine of a in radians.
// Contract: that of ci_fsincos with its n at 0; two of them on the same CPU share ci_fsincos instead.
module ci_fsin (
    input  logic        clk_i,
    input  logic        reset_i,
    input  logic        clk_en_i,
    input  logic        start_i,
    input  logic [31:0] dataa_i,
    output logic [31:0] result_o
);

  ci_fsincos u_core (
      .clk_i   (clk_i),
      .reset_i (reset_i),
      .clk_en_i(clk_en_i),
      .start_i (start_i),
      .n_i     (1'b0),
      .dataa_i (dataa_i),
      .result_o(result_o)
  );

endmodule
