// SPDX-License-Identifier: Apache-2.0
// fp_divsqrt: binary32 quotient a / b or square root of a (sqrt_i), pipelined, one per clock.
// Contract: latency fp_pkg::FP_DIVSQRT_LATENCY register ranks, no stall; b_i is ignored for roots.
// Radix-2 restoring digit recurrence, two digits per stage, shared by both; no multiplier.
// Stages: operands | e1 unpack, normalise | 13 digit stages, the last also denormalises | round, pack.
module fp_divsqrt (
    input  logic           clk_i,
    input  logic           rst_ni,
    input  logic           valid_i,
    input  logic           sqrt_i,
    input  logic [31:0]    a_i,
    input  logic [31:0]    b_i,
    output logic           valid_o,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  // Recurrence (Ercegovac and Lang, Digital Arithmetic, ch. 5, 6), digit k = 0..25 of weight 2^-k:
  //   trial = 2 r - d_k;  digit = trial >= 0;  r = digit ? trial : 2 r
  //   quotient: r starts at a/2, d_k = b with a, b in [1, 2).             Invariant 0 <= r < b.
  //   root: r starts at m/4, m in [1, 4); d_k = Q + 2^-(k+1), where Q is the root truncated to the
  //         digits before k. After digit k, r = 2^(k-1) (m - Q^2).  Invariant r < Q + 2^-(k+1).
  // So r is U(1.26), its last bit needed by digit 25 of a root only, and 2 r is U(2.26). The digits
  // are the conventional binary result, no conversion is needed; a/b lies in (1/2, 2), the root in
  // [1, 2). The result is inexact exactly if the last r is not zero.

  localparam int unsigned Digits = 26;  // 2^0 .. 2^-25: 24, one for a < b, one to round
  localparam int unsigned Stages = Digits / 2;

  // ---- operands: a rank of their own, as they may come from far away ----
  logic [31:0] a_e1_q, b_e1_q;
  logic a_normal_e1_q, b_normal_e1_q;  // the exponent field is not zero
  logic sqrt_e1_q, valid_e1_q;

  always_ff @(posedge clk_i) begin
    a_e1_q        <= a_i;
    b_e1_q        <= b_i;
    sqrt_e1_q     <= sqrt_i;
    a_normal_e1_q <= |a_i[30:23];
    b_normal_e1_q <= |b_i[30:23];
  end

  // ---- e1: unpack, normalise subnormals ----
  logic [4:0] zeros_a_e1, zeros_b_e1;
  logic a_zero_sig_e1, b_zero_sig_e1;  // fraction and hidden bit all zero
  logic [23:0] sig_a_e1, sig_b_e1;  // U(1.23), normalised
  logic [7:0] exp_a_e1, exp_b_e1;  // biased, before normalisation: 1 .. 255

  // The hidden bit of a normal number makes its count zero.
  fp_normalise u_normalise_a (
      .value_i({a_normal_e1_q, a_e1_q[22:0]}),
      .value_o(sig_a_e1),
      .count_o(zeros_a_e1),
      .zero_o (a_zero_sig_e1)
  );
  fp_normalise u_normalise_b (
      .value_i({b_normal_e1_q, b_e1_q[22:0]}),
      .value_o(sig_b_e1),
      .count_o(zeros_b_e1),
      .zero_o (b_zero_sig_e1)
  );

  assign exp_a_e1 = {a_e1_q[30:24], a_e1_q[23] || !a_normal_e1_q};
  assign exp_b_e1 = {b_e1_q[30:24], b_e1_q[23] || !b_normal_e1_q};

  // A root halves the exponent; an odd unbiased one (even biased) leaves a factor 2 in m.
  logic factor2_e1;
  assign factor2_e1 = exp_a_e1[0] == zeros_a_e1[0];

  // Result that the recurrence does not give; the flags it raises are nv and dz.
  logic a_nan_e1, a_inf_e1, b_nan_e1, b_inf_e1;
  logic nan_e1, inf_e1, zero_e1, invalid_e1, by_zero_e1;

  assign a_nan_e1 = fp_pkg::is_nan(a_e1_q);
  assign a_inf_e1 = fp_pkg::is_inf(a_e1_q);
  assign b_nan_e1 = fp_pkg::is_nan(b_e1_q);
  assign b_inf_e1 = fp_pkg::is_inf(b_e1_q);

  always_comb begin
    if (sqrt_e1_q) begin
      invalid_e1 = fp_pkg::is_snan(a_e1_q) || (a_e1_q[31] && !a_nan_e1 && !a_zero_sig_e1);
      nan_e1     = a_nan_e1 || invalid_e1;
      inf_e1     = a_inf_e1;
      zero_e1    = a_zero_sig_e1;
      by_zero_e1 = 1'b0;
    end else begin
      invalid_e1 = fp_pkg::is_snan(a_e1_q) || fp_pkg::is_snan(b_e1_q) || (a_inf_e1 && b_inf_e1)
                || (a_zero_sig_e1 && b_zero_sig_e1);
      nan_e1     = a_nan_e1 || b_nan_e1 || invalid_e1;
      inf_e1     = a_inf_e1 || b_zero_sig_e1;
      zero_e1    = a_zero_sig_e1 || b_inf_e1;
      by_zero_e1 = b_zero_sig_e1 && !(&a_e1_q[30:23]) && !a_zero_sig_e1;
    end
  end

  // ---- what travels with the digits ----
  // Entry s is the register in front of digit stage s, entry Stages the one in front of rounding.
  // The exponent of the result joins in stage 0: of digit 0 in entry 1, then of the leading one.
  logic [Stages-1:0] sqrt_q;
  logic [Stages:0] valid_q, sign_q, nan_q, inf_q, zero_q;
  logic [Stages:0] raises_q;  // of a NaN nv, of an infinity dz
  logic [7:0] exp_a_q, exp_b_q;  // entry 0
  logic [4:0] zeros_a_q, zeros_b_q;  // entry 0
  logic [Stages-1:1][9:0] exp_q;  // S(10.0), biased: -150 .. 404
  logic [23:0] sig_a_q;  // entry 0: U(1.23), normalised
  logic halved_q;  // entry 0: a root with m in [1, 2)
  logic [Stages-1:1][26:0] remainder_q;  // U(1.26)
  logic [Stages-1:0][26:0] divisor_q;  // U(1.26): d_k of the first digit of a stage
  logic [Stages-1:0][23:0] digits_q;  // right aligned, 2 s digits at entry s
  logic [4:0] amount_q;  // entry Stages - 1: places to denormalise
  logic [2:0] few_q;  // entry Stages - 1: the amount is 2, 1, 0
  logic [8:0] exp_round_q;  // entry Stages: U(9.0), biased, 1 for a subnormal result
  logic [25:0] sig_q;  // entry Stages: U(1.25), denormalised, without the last two digits
  logic [2:0] late_q;  // entry Stages: the last two digits in the lowest places
  logic lost_q;  // entry Stages: sig_q lost a one of digits 0..23
  logic nonzero_q;  // entry Stages: something is left, see gen_denormalise

  always_ff @(posedge clk_i) begin
    sqrt_q[0]      <= sqrt_e1_q;
    sign_q[0]      <= a_e1_q[31] ^ (b_e1_q[31] && !sqrt_e1_q);
    nan_q[0]       <= nan_e1;
    inf_q[0]       <= inf_e1;
    zero_q[0]      <= zero_e1;
    raises_q[0]    <= invalid_e1 || by_zero_e1;
    exp_a_q        <= exp_a_e1;
    exp_b_q        <= exp_b_e1;
    zeros_a_q      <= zeros_a_e1;
    zeros_b_q      <= zeros_b_e1;
    sig_a_q        <= sig_a_e1;
    halved_q       <= sqrt_e1_q && !factor2_e1;
    divisor_q[0]   <= sqrt_e1_q ? 27'h200_0000 : {sig_b_e1, 3'd0};
    digits_q[0]    <= 24'd0;
  end

  // Entry 0 halves after its register: that it does is the last that e1 knows.
  logic [Stages-1:0][26:0] remainder;

  assign remainder = {remainder_q, halved_q ? {2'b00, sig_a_q, 1'b0} : {1'b0, sig_a_q, 2'b00}};

  logic [9:0] exp_a, exp_b;  // S(10.0), biased, -22 .. 255
  logic [8:0] exp_root;  // U(9.0), (exp_a + 127) / 2
  logic unused_root;

  assign exp_a = {2'd0, exp_a_q} - {5'd0, zeros_a_q};
  assign exp_b = {2'd0, exp_b_q} - {5'd0, zeros_b_q};
  assign {exp_root, unused_root} = exp_a + 10'd127;

  always_ff @(posedge clk_i) exp_q[1] <= sqrt_q[0] ? {1'b0, exp_root} : exp_a - exp_b + 10'd127;

  // ---- digit stages ----
  genvar s;
  generate
    for (s = 0; s < Stages; s++) begin : gen_stage
      localparam int unsigned First = 2 * s;  // digit k has bit 26 - k in U(1.26)

      // Root: d_k is |digits 0..k-1|0|1|0..0|, the one at 2^-(k+1). The next one gets digit k in the
      // place of the zero, 0 in the place of the one, and a one below.
      logic [26:0] divisor_second;  // of a root without digit k
      logic [27:0] twice_first;  // U(2.26)
      logic [27:0] trial_first, trial_second;  // S(2.26), in (-d_k, d_k)
      logic [26:0] remainder_first;
      logic digit_first, digit_second;

      assign twice_first = {remainder[s], 1'b0};

      always_comb begin
        digit_first = !trial_first[27];
        remainder_first = digit_first ? trial_first[26:0] : twice_first[26:0];

        divisor_second = divisor_q[s];
        if (sqrt_q[s]) divisor_second[25-First-:2] = 2'b01;
        digit_second = !trial_second[27];
      end

      // 2 remainder - divisor
      if (s == 0) begin : gen_first_halved
        logic unused_twice;
        assign unused_twice = twice_first[27];

        fp_select_sub u_first (
            .root_i      (1'b0),
            .select_i    (halved_q),
            .place_i     (28'd1),
            .one_i       ({2'b00, sig_a_q, 2'b00}),
            .zero_i      ({1'b0, sig_a_q, 3'b000}),
            .subtrahend_i({1'b0, divisor_q[0]}),
            .difference_o(trial_first)
        );
      end else begin : gen_first
        assign trial_first = twice_first - {1'b0, divisor_q[s]};
      end

      // 2 remainder_first - divisor_second
      fp_select_sub u_second (
          .root_i      (sqrt_q[s]),
          .select_i    (trial_first[27]),  // no inverter after the first carry chain
          .place_i     (28'h400_0000 >> First),
          .one_i       ({twice_first[26:0], 1'b0}),
          .zero_i      ({trial_first[26:0], 1'b0}),
          .subtrahend_i({1'b0, divisor_second}),
          .difference_o(trial_second)
      );

      always_ff @(posedge clk_i) begin
        sign_q[s+1]      <= sign_q[s];
        nan_q[s+1]       <= nan_q[s];
        inf_q[s+1]       <= inf_q[s];
        zero_q[s+1]      <= zero_q[s];
        raises_q[s+1]    <= raises_q[s];
      end

      if (s < Stages - 1) begin : gen_inner
        // From digit 2 to 22 nothing is below bit 3: a quotient has 24 bits, and the one of d_k comes down.
        localparam logic [26:0] Kept = s < Stages - 2 ? 27'h7ff_fff8 : 27'h7ff_ffff;

        logic [26:0] divisor_next, remainder_second;
        logic unused_top;

        assign unused_top       = remainder_first[26];
        assign remainder_second = digit_second ? trial_second[26:0] : {remainder_first[25:0], 1'b0};

        always_comb begin
          divisor_next = divisor_second;
          if (sqrt_q[s]) divisor_next[26-First-:4] = {digit_first, digit_second, 2'b01};
        end

        always_ff @(posedge clk_i) begin
          sqrt_q[s+1]    <= sqrt_q[s];
          divisor_q[s+1] <= divisor_next & Kept;
          remainder_q[s+1] <= remainder_second & Kept;
          digits_q[s+1]  <= {digits_q[s][21:0], digit_first, digit_second};
        end
      end

      if (s == 1) begin : gen_exponent  // digit 0 is in bit 1 of digits_q
        always_ff @(posedge clk_i) exp_q[s+1] <= exp_q[s] - {9'd0, !digits_q[s][1]};
      end else if (s > 1 && s < Stages - 1) begin : gen_exponent
        always_ff @(posedge clk_i) exp_q[s+1] <= exp_q[s];
      end

      // |digit 0|digits 1..25|0| >> amount leaves a significand with its leading one in digit 1, or
      // right of it for a subnormal result: one place if digit 0 is one, and 1 - exp more for a
      // subnormal result. From 26 on only the sticky bit is left. The shift of the known
      // digits runs next to the last two, which can only reach the lowest places.
      if (s == Stages - 2) begin : gen_amount
        logic digit0, subnormal, vanished;

        assign digit0    = digits_q[s][First-1];
        assign subnormal = exp_q[s][9] || exp_q[s] == 10'd0;
        assign vanished  = exp_q[s][9] && exp_q[s][8:0] < 9'd487;   // exp < -25

        always_ff @(posedge clk_i) begin
          if (vanished) amount_q <= 5'd31;
          else amount_q <= (subnormal ? 5'd1 - exp_q[s][4:0] : 5'd0) + {4'd0, digit0};
          few_q <= {
            subnormal && (digit0 ? exp_q[s] == 10'd0 : &exp_q[s]),
            digit0 ? !subnormal : exp_q[s] == 10'd0,
            !subnormal && !digit0
          };
        end
      end

      if (s == Stages - 1) begin : gen_denormalise
        logic unused_top;  // digit 0 has moved right
        logic [25:0] shifted;
        logic shifted_out, subnormal;

        fp_shift_right #(
            .Width(27),
            .AmountWidth(5)
        ) u_denormalise (
            .value_i ({digits_q[s], 3'd0}),
            .amount_i(amount_q),
            .value_o ({unused_top, shifted}),
            .sticky_o(shifted_out)
        );

        assign subnormal = exp_q[s][9] || exp_q[s] == 10'd0;

        // The result is exact if nothing is left before the last digit: an exact quotient or root has at
        // most 24 bits, and fewer if a < b puts its leading one in digit 1 (q b = a), so that
        // digit 25 is zero, which leaves the remainder as it was. The same holds for a one that is
        // lost here: it needs no bit of its own.
        always_ff @(posedge clk_i) nonzero_q <= |remainder_first;

        logic unused_trial;
        assign unused_trial = ^trial_second[26:0];

        always_ff @(posedge clk_i) begin
          exp_round_q <= subnormal ? 9'd1 : exp_q[s][8:0];
          sig_q       <= shifted;
          late_q      <= ({3{few_q[0]}} & {digit_first, digit_second, 1'b0}) |
                         ({3{few_q[1]}} & {1'b0, digit_first, digit_second}) |
                         ({3{few_q[2]}} & {2'b00, digit_first});
          lost_q      <= shifted_out;
        end
      end
    end
  endgenerate

  // ---- last rank: round, pack, special results ----
  logic [31:0] result;
  fp_pkg::flags_t flags;

  fp_pack u_pack (
      .sign_i   (sign_q[Stages]),
      .exp_i    (exp_round_q),
      .sig_i    ({sig_q[25:3], sig_q[2] || late_q[2]}),
      .guard_i  (sig_q[1] || late_q[1]),
      .round_i  (sig_q[0] || late_q[0]),
      .sticky_i (lost_q || nonzero_q),
      .exact_i  (1'b0),
      .nan_i    (nan_q[Stages]),
      .invalid_i(raises_q[Stages]),
      .inf_i    (inf_q[Stages]),
      .by_zero_i(raises_q[Stages]),
      .zero_i   (zero_q[Stages]),
      .result_o (result),
      .flags_o  (flags)
  );

  always_ff @(posedge clk_i) begin
    result_o <= result;
    flags_o  <= flags;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_e1_q <= 1'b0;
      valid_q    <= '0;
      valid_o    <= 1'b0;
    end else begin
      valid_e1_q <= valid_i;
      valid_q    <= {valid_q[Stages-1:0], valid_e1_q};
      valid_o    <= valid_q[Stages];
    end
  end

endmodule
