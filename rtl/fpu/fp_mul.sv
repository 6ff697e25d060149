// SPDX-License-Identifier: Apache-2.0
// fp_mul: binary32 multiplication a * b, pipelined, one operation per clock.
// Contract: latency fp_pkg::FP_MUL_LATENCY register ranks, no stall. Subnormal operands enter the
// product without hidden bit; one shifter then restores lost leading zeros or denormalises.
// Stages: e1 unpack | e2 product and shift amount | e3 shift | e4 round and pack.
module fp_mul (
    input  logic           clk_i,
    input  logic           rst_ni,
    input  logic           valid_i,
    input  logic [31:0]    a_i,
    input  logic [31:0]    b_i,
    output logic           valid_o,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  // ---- e1: unpack ----
  logic a_subnormal_e1, b_subnormal_e1;
  logic [23:0] sig_a_e1, sig_b_e1;  // U(1.23), hidden bit 0 for subnormals and zero
  logic [9:0] exp_e1;  // S(10.0): biased exponent of the product, minus one
  logic nan_e1, invalid_e1, inf_e1, zero_e1;

  assign a_subnormal_e1 = !(|a_i[30:23]);
  assign b_subnormal_e1 = !(|b_i[30:23]);
  assign sig_a_e1       = {!a_subnormal_e1, a_i[22:0]};
  assign sig_b_e1       = {!b_subnormal_e1, b_i[22:0]};
  // A subnormal has the exponent of the smallest normal numbers.
  assign exp_e1 = {2'b00, a_i[30:24], a_i[23] || a_subnormal_e1}
                + {2'b00, b_i[30:24], b_i[23] || b_subnormal_e1} - 10'd128;

  assign inf_e1     = fp_pkg::is_inf(a_i) || fp_pkg::is_inf(b_i);
  assign zero_e1    = fp_pkg::is_zero(a_i) || fp_pkg::is_zero(b_i);
  assign invalid_e1 = fp_pkg::is_snan(a_i) || fp_pkg::is_snan(b_i)
                   || (fp_pkg::is_inf(a_i) && fp_pkg::is_zero(b_i))
                   || (fp_pkg::is_zero(a_i) && fp_pkg::is_inf(b_i));
  assign nan_e1     = fp_pkg::is_nan(a_i) || fp_pkg::is_nan(b_i) || invalid_e1;

  logic valid_e1_q, sign_e1_q, nan_e1_q, invalid_e1_q, inf_e1_q, zero_e1_q;
  logic [23:0] sig_a_e1_q, sig_b_e1_q;
  logic [23:0] sig_small_e1_q;  // the subnormal operand, if there is one
  logic [9:0] exp_e1_q;

  always_ff @(posedge clk_i) begin
    sign_e1_q      <= a_i[31] ^ b_i[31];
    nan_e1_q       <= nan_e1;
    invalid_e1_q   <= invalid_e1;
    inf_e1_q       <= inf_e1;
    zero_e1_q      <= zero_e1;
    sig_a_e1_q     <= sig_a_e1;
    sig_b_e1_q     <= sig_b_e1;
    sig_small_e1_q <= a_subnormal_e1 ? sig_a_e1 : sig_b_e1;
    exp_e1_q       <= exp_e1;
  end

  // ---- e2: product U(2.46) and the shift that brings it to its final exponent ----
  // {product, 10 zeros} >> shift leaves U(2.25), and 31 keeps the place. Less restores the zeros that
  // a subnormal operand brought, only as far as the exponent allows: its leading one or the bit where
  // the room ends, whichever is first. More denormalises; 58 or more leaves only the sticky bit, as
  // for the product of two subnormals, which is below 2^-250.
  logic [23:0] stop_e2;
  logic [4:0] zeros_e2;
  logic unused_empty_e2, denormal_e2, far_e2;
  logic [5:0] shift_e2;
  logic [8:0] exp_e2;  // U(9.0), biased exponent after the shift, minus one

  always_comb begin
    for (int i = 0; i < 24; i++) stop_e2[23-i] = sig_small_e1_q[23-i] || (exp_e1_q[8:0] == 9'(i));
  end

  fp_lzc #(
      .CountWidth(5)
  ) u_lzc (
      .value_i({stop_e2, 8'd0}),
      .count_o(zeros_e2),
      .zero_o (unused_empty_e2)
  );

  assign denormal_e2 = exp_e1_q[9];
  assign far_e2      = !(&exp_e1_q[8:5]);
  assign shift_e2    = denormal_e2 ? {1'b1, ~exp_e1_q[4:0] | {5{far_e2}}} : {1'b0, ~zeros_e2};
  assign exp_e2      = denormal_e2 ? 9'd0 : exp_e1_q[8:0] - {4'd0, zeros_e2};

  logic [47:0] outer_e2;  // product = outer + cross * 2^17
  logic [23:0] cross_low_e2, cross_high_e2;
  logic [24:0] cross_e2;

  fp_product u_multiply (
      .a_i         (sig_a_e1_q),
      .b_i         (sig_b_e1_q),
      .outer_o     (outer_e2),
      .cross_low_o (cross_low_e2),
      .cross_high_o(cross_high_e2)
  );

  assign cross_e2 = {1'b0, cross_low_e2} + {1'b0, cross_high_e2};

  logic valid_e2_q, sign_e2_q, nan_e2_q, invalid_e2_q, inf_e2_q, zero_e2_q;
  logic [47:0] outer_e2_q;
  logic [24:0] cross_e2_q;
  logic [5:0] shift_e2_q;
  logic [8:0] exp_e2_q;

  always_ff @(posedge clk_i) begin
    outer_e2_q   <= outer_e2;
    cross_e2_q   <= cross_e2;
    shift_e2_q   <= shift_e2;
    exp_e2_q     <= exp_e2;
    sign_e2_q    <= sign_e1_q;
    nan_e2_q     <= nan_e1_q;
    invalid_e2_q <= invalid_e1_q;
    inf_e2_q     <= inf_e1_q;
    zero_e2_q    <= zero_e1_q;
  end

  // ---- e3: shift, then at most one place to the right ----
  logic [47:0] product_e3;  // U(2.46)
  logic [30:0] unused_shifted_e3;  // zeros, since the product is below 4 after the shift
  logic [26:0] shifted_e3;  // U(2.25)
  logic lost_e3, high_e3;
  logic [8:0] exp_low_e3, exp_high_e3;

  assign product_e3 = outer_e2_q + {6'd0, cross_e2_q, 17'd0};

  fp_shift_right #(
      .Width(58),
      .AmountWidth(6)
  ) u_normalise (
      .value_i ({product_e3, 10'd0}),
      .amount_i(shift_e2_q),
      .value_o ({unused_shifted_e3, shifted_e3}),
      .sticky_o(lost_e3)
  );

  assign high_e3     = shifted_e3[26];
  assign exp_low_e3  = exp_e2_q + 9'd1;
  assign exp_high_e3 = exp_e2_q + 9'd2;  // both ahead of the late selection

  logic valid_e3_q, sign_e3_q, nan_e3_q, invalid_e3_q, inf_e3_q, zero_e3_q;
  logic [25:0] sig_e3_q;  // U(1.25)
  logic sticky_e3_q;
  logic [8:0] exp_e3_q;  // U(9.0), biased

  always_ff @(posedge clk_i) begin
    sig_e3_q     <= high_e3 ? shifted_e3[26:1] : shifted_e3[25:0];
    sticky_e3_q  <= lost_e3 || (high_e3 && shifted_e3[0]);
    exp_e3_q     <= high_e3 ? exp_high_e3 : exp_low_e3;
    sign_e3_q    <= sign_e2_q;
    nan_e3_q     <= nan_e2_q;
    invalid_e3_q <= invalid_e2_q;
    inf_e3_q     <= inf_e2_q;
    zero_e3_q    <= zero_e2_q;
  end

  // ---- e4: round, pack, special results ----
  logic [31:0] result_e4;
  fp_pkg::flags_t flags_e4;

  fp_pack u_pack (
      .sign_i   (sign_e3_q),
      .exp_i    (exp_e3_q),
      .sig_i    (sig_e3_q[25:2]),
      .guard_i  (sig_e3_q[1]),
      .round_i  (sig_e3_q[0]),
      .sticky_i (sticky_e3_q),
      .exact_i  (1'b0),
      .nan_i    (nan_e3_q),
      .invalid_i(invalid_e3_q),
      .inf_i    (inf_e3_q),
      .by_zero_i(1'b0),
      .zero_i   (zero_e3_q),
      .result_o (result_e4),
      .flags_o  (flags_e4)
  );

  always_ff @(posedge clk_i) begin
    result_o <= result_e4;
    flags_o  <= flags_e4;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_e1_q <= 1'b0;
      valid_e2_q <= 1'b0;
      valid_e3_q <= 1'b0;
      valid_o    <= 1'b0;
    end else begin
      valid_e1_q <= valid_i;
      valid_e2_q <= valid_e1_q;
      valid_e3_q <= valid_e2_q;
      valid_o    <= valid_e3_q;
    end
  end

endmodule
