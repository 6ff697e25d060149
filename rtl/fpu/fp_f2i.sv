// SPDX-License-Identifier: Apache-2.0
// fp_f2i: binary32 to int32, toward zero (truncate_i) or to nearest even, one per clock.
// Contract: latency fp_pkg::FP_F2I_LATENCY register ranks, no stall. Out of range saturates to
// 7fffffff or 80000000 by sign and NaN gives 7fffffff, all with nv alone (as RISC-V fcvt.w.s);
// otherwise only nx can be set.
// Stages: e1 align to the integer place | e2 round, negate, saturate.
module fp_f2i (
    input  logic           clk_i,
    input  logic           rst_ni,
    input  logic           valid_i,
    input  logic           truncate_i,
    input  logic [31:0]    a_i,
    output logic           valid_o,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  // ---- e1: integer part, half bit and sticky bit ----
  // |24 significand|8 zeros|half| is the value for the exponent of 2^31; smaller exponents shift it
  // right by 1..33. Shifted by 33 (below 1/2, subnormals) only the sticky bit is left.
  logic [7:0] exponent_e1;
  logic [5:0] amount_e1;
  logic large_e1;  // at least 2^31, infinity or NaN
  logic unused_e1;  // 2^31, clear after a shift by at least one
  logic [31:0] aligned_e1;  // U(31.1)
  logic sticky_e1;

  assign exponent_e1 = a_i[30:23];
  assign large_e1    = exponent_e1 >= 8'd158;
  assign amount_e1   = (exponent_e1 < 8'd125) ? 6'd33 : 6'd30 - exponent_e1[5:0];

  fp_shift_right #(
      .Width(33),
      .AmountWidth(6)
  ) u_align (
      .value_i ({|exponent_e1, a_i[22:0], 9'd0}),
      .amount_i(amount_e1),
      .value_o ({unused_e1, aligned_e1}),
      .sticky_o(sticky_e1)
  );

  logic valid_e1_q, sign_e1_q, large_e1_q, nan_e1_q, exact_min_e1_q, half_e1_q, sticky_e1_q;
  logic truncate_e1_q;
  logic [30:0] integer_e1_q;  // U(31.0)

  always_ff @(posedge clk_i) begin
    sign_e1_q      <= a_i[31];
    large_e1_q     <= large_e1;
    nan_e1_q       <= fp_pkg::is_nan(a_i);
    exact_min_e1_q <= a_i == 32'hcf00_0000;   // -2^31
    integer_e1_q   <= aligned_e1[31:1];
    half_e1_q      <= aligned_e1[0];
    sticky_e1_q    <= sticky_e1;
    truncate_e1_q  <= truncate_i;
  end

  // ---- e2 ----
  // Round and negate with one carry: -(n + r) = ~n + 1 - r. Below 2^31 a binary32 number with a
  // fraction is below 2^23, so that rounding never reaches 2^31.
  logic increment_e2, negate_e2;
  logic [31:0] rounded_e2, result_e2;
  logic invalid_e2, inexact_e2;

  assign increment_e2 = !truncate_e1_q && half_e1_q && (sticky_e1_q || integer_e1_q[0]);
  assign negate_e2    = sign_e1_q;
  assign rounded_e2   = ({1'b0, integer_e1_q} ^ {32{negate_e2}})
                      + {31'd0, increment_e2 ^ negate_e2};

  assign invalid_e2 = large_e1_q && !exact_min_e1_q;
  assign inexact_e2 = !large_e1_q && (half_e1_q || sticky_e1_q);

  always_comb begin
    result_e2 = rounded_e2;
    if (large_e1_q) result_e2 = (sign_e1_q && !nan_e1_q) ? 32'h8000_0000 : 32'h7fff_ffff;
  end

  always_ff @(posedge clk_i) begin
    result_o <= result_e2;
    flags_o  <= {invalid_e2, 3'b000, inexact_e2};
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_e1_q <= 1'b0;
      valid_o    <= 1'b0;
    end else begin
      valid_e1_q <= valid_i;
      valid_o    <= valid_e1_q;
    end
  end

endmodule
