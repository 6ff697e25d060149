// SPDX-License-Identifier: Apache-2.0
// ci_fdivsqrt: custom instruction, a / b (n 0) or square root of a (n 1).
// Contract: fixed latency, fp_pkg::FP_DIVSQRT_LATENCY + 1 cycles. The pipeline runs freely on operands that
// the CPU holds, so that its result holds from then on, however long clk_en stalls. No flags;
// rounding, NaN and subnormal numbers are those of fp_divsqrt.
module ci_fdivsqrt (
    input  logic        clk_i,
    input  logic        reset_i,     // active high, asynchronous, released with the clock
    input  logic        clk_en_i,
    input  logic        start_i,
    input  logic        n_i,         // 0 divide, 1 root
    input  logic [31:0] dataa_i,
    input  logic [31:0] datab_i,
    output logic [31:0] result_o
);

  logic unused_valid, unused_control;
  fp_pkg::flags_t unused_flags;
  assign unused_control = clk_en_i || start_i;

  fp_divsqrt u_unit (
      .clk_i   (clk_i),
      .rst_ni  (!reset_i),
      .valid_i (1'b0),
      .sqrt_i  (n_i),
      .a_i     (dataa_i),
      .b_i     (datab_i),
      .valid_o (unused_valid),
      .result_o(result_o),
      .flags_o (unused_flags)
  );

endmodule
