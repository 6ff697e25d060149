// SPDX-License-Identifier: Apache-2.0
// ci_fsincos: custom instruction, sine (n 0) or cosine (n 1) of a in radians.
// Contract: fixed latency, fp_pkg::FP_SINCOS_LATENCY + 1 cycles. The unit takes the operand at the
// first edge with start and clk_en and runs on through stalls; its result holds until the next
// start. Range, NaN and error are those of fp_sincos; no flags.
module ci_fsincos (
    input  logic        clk_i,
    input  logic        reset_i,     // active high, asynchronous, released with the clock
    input  logic        clk_en_i,
    input  logic        start_i,
    input  logic        n_i,         // 0 sine, 1 cosine
    input  logic [31:0] dataa_i,
    output logic [31:0] result_o
);

  logic unused_ready, valid;
  logic [31:0] result, result_q;
  fp_pkg::flags_t unused_flags;

  fp_sincos u_unit (
      .clk_i   (clk_i),
      .rst_ni  (!reset_i),
      .valid_i (start_i && clk_en_i),
      .cos_i   (n_i),
      .a_i     (dataa_i),
      .ready_o (unused_ready),
      .valid_o (valid),
      .result_o(result),
      .flags_o (unused_flags)
  );

  // The unit shows its result for one cycle.
  always_ff @(posedge clk_i) if (valid) result_q <= result;
  assign result_o = valid ? result : result_q;

endmodule
