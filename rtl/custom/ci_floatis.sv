// SPDX-License-Identifier: Apache-2.0
// ci_floatis: custom instruction, signed integer to float.
// Contract: fixed latency, fp_pkg::FP_I2F_LATENCY + 1 cycles. The pipeline runs freely on operands that
// the CPU holds, so that its result holds from then on, however long clk_en stalls. No flags;
// rounding, NaN and subnormal numbers are those of fp_i2f.
module ci_floatis (
    input  logic        clk_i,
    input  logic        reset_i,     // active high, asynchronous, released with the clock
    input  logic        clk_en_i,
    input  logic        start_i,
    input  logic [31:0] dataa_i,
    output logic [31:0] result_o
);

  logic unused_valid, unused_control;
  fp_pkg::flags_t unused_flags;
  assign unused_control = clk_en_i || start_i;

  fp_i2f u_unit (
      .clk_i   (clk_i),
      .rst_ni  (!reset_i),
      .valid_i (1'b0),
      .unsigned_i(1'b0),
      .a_i     (dataa_i),
      .valid_o (unused_valid),
      .result_o(result_o),
      .flags_o (unused_flags)
  );

endmodule
