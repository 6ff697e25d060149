// SPDX-License-Identifier: Apache-2.0
// ci_faddsub: custom instruction, a + b (n 0) or a - b (n 1).
// Contract: fixed latency, fp_pkg::FP_ADD_LATENCY + 1 cycles. The pipeline runs freely on operands that
// the CPU holds, so that its result stands from then on, however long clk_en stalls. No flags;
// rounding, NaN and subnormal numbers are those of fp_add.
module ci_faddsub (
    input  logic        clk_i,
    input  logic        reset_i,     // active high, asynchronous, released with the clock
    input  logic        clk_en_i,
    input  logic        start_i,
    input  logic        n_i,         // 0 add, 1 subtract
    input  logic [31:0] dataa_i,
    input  logic [31:0] datab_i,
    output logic [31:0] result_o
);

  logic           unused_valid, unused_control;
  fp_pkg::flags_t unused_flags;
  assign unused_control = clk_en_i || start_i;

  fp_add unit (
      .clk_i   (clk_i),
      .rst_ni  (!reset_i),
      .valid_i (1'b0),
      .sub_i   (n_i),
      .a_i     (dataa_i),
      .b_i     (datab_i),
      .valid_o (unused_valid),
      .result_o(result_o),
      .flags_o (unused_flags)
  );

endmodule
