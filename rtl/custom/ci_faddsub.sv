// SPDX-License-Identifier: Apache-2.0
// ci_faddsub: custom instruction, a + b (n 0) or a - b (n 1), in few long stages for a 100 MHz CPU.
// Contract: fixed latency, ci_pkg::FPGA2_FADD_CYCLES cycles: two register ranks run freely on the
// operands, which the CPU holds, and the third stage ends in the CPU. The result stands from then
// on, however long clk_en stalls. IEEE 754: to nearest even, subnormal numbers, canonical NaN; no
// flags. Stages: s1 order, align | s2 add, count, shift by fours | s3 shift by ones, round, pack.
module ci_faddsub (
    input  logic        clk_i,
    input  logic        reset_i,
    input  logic        clk_en_i,
    input  logic        start_i,
    input  logic        n_i,         // 0 add, 1 subtract
    input  logic [31:0] dataa_i,
    input  logic [31:0] datab_i,
    output logic [31:0] result_o
);

  logic unused_control;
  assign unused_control = reset_i || clk_en_i || start_i;

  // ---- s1: align the operand with the smaller exponent; equal exponents need no shift ----
  // A subnormal number has exponent 0 and twice its significand, so that the exponents need no fixing.
  logic a_normal, b_normal, b_above, a_larger, swap;
  logic [7:0] exp_a, exp_b, distance;
  logic [8:0] a_minus_b;  // S(8.0)
  logic [23:0] sig_a, sig_b;  // U(1.23)
  logic [24:0] moved;  // U(1.24)
  assign exp_a     = dataa_i[30:23];
  assign exp_b     = datab_i[30:23];
  assign a_normal  = |exp_a;
  assign b_normal  = |exp_b;
  assign sig_a     = a_normal ? {1'b1, dataa_i[22:0]} : {dataa_i[22:0], 1'b0};
  assign sig_b     = b_normal ? {1'b1, datab_i[22:0]} : {datab_i[22:0], 1'b0};
  assign a_minus_b = {1'b0, exp_a} - {1'b0, exp_b};
  // If b is above, the complement is one less than the distance: sig_a has moved by that one.
  assign b_above   = a_minus_b[8];
  assign distance  = a_minus_b[7:0] ^ {8{b_above}};
  assign moved     = b_above ? {1'b0, sig_a} : {sig_b, 1'b0};
  assign a_larger  = dataa_i[30:0] >= datab_i[30:0];
  // At equal exponents the larger significand goes first, so that no difference is negative.
  assign swap      = !a_larger && !b_above;

  logic [31:0] aligned;  // U(1.31): distances up to 31 leave 26 bits and a sticky
  logic lost, far;
  logic [26:0] minor;  // |24 bits|guard|round|sticky|, U(1.26)
  assign far = |distance[7:5];
  fp_shift_right #(
      .Width(32),
      .AmountWidth(5),
      .WidestFirst(1'b0)
  ) u_align (
      .value_i ({moved, 7'd0}),
      .amount_i(distance[4:0]),
      .value_o (aligned),
      .sticky_o(lost)
  );
  always_comb begin
    minor[26:1] = aligned[31:6] & {26{!far}};
    minor[0]    = far ? (|moved) : (lost || (|aligned[5:0]));
    if (swap) minor = {sig_a, 3'd0};
  end

  logic sign_b, subtract, infinities;
  assign sign_b     = datab_i[31] ^ n_i;
  assign subtract   = dataa_i[31] ^ sign_b;
  assign infinities = fp_pkg::is_inf(dataa_i) && fp_pkg::is_inf(datab_i);

  logic [23:0] large_s1_q;
  logic [26:0] minor_s1_q;  // its complement to subtract it
  logic [7:0] exp_s1_q;
  logic subtract_s1_q, sign_s1_q, nan_s1_q, inf_s1_q;
  always_ff @(posedge clk_i) begin
    large_s1_q    <= (b_above || swap) ? sig_b : sig_a;
    minor_s1_q    <= minor ^ {27{subtract}};
    exp_s1_q      <= b_above ? exp_b : exp_a;
    subtract_s1_q <= subtract;
    sign_s1_q     <= a_larger ? dataa_i[31] : sign_b;
    nan_s1_q      <= fp_pkg::is_nan(dataa_i) || fp_pkg::is_nan(datab_i) || (infinities && subtract);
    inf_s1_q      <= fp_pkg::is_inf(dataa_i) || fp_pkg::is_inf(datab_i);
  end

  // ---- s2: add; count leading zeros; the coarse part of the shift ----
  // The sticky bit takes part in the subtraction: a difference that loses more than one leading bit
  // has operands less than two places apart and so no sticky bit.
  logic [27:0] sum, room, coarse;  // U(2.26)
  logic [4:0] zeros;
  logic unused_empty, zero;
  assign sum = {1'b0, large_s1_q, 3'd0} + {subtract_s1_q, minor_s1_q} + {27'd0, subtract_s1_q};
  // The bit that would be the leading one at the least exponent: left shifts stop there.
  always_comb begin
    for (int i = 0; i < 28; i++) room[27-i] = exp_s1_q == 8'(i);
  end
  fp_lzc #(
      .CountWidth(5)
  ) u_lzc (
      .value_i({sum | room, 4'd0}),
      .count_o(zeros),
      .zero_o (unused_empty)
  );
  always_comb begin
    coarse = sum;
    for (int k = 4; k >= 2; k--) if (zeros[k]) coarse = coarse << (1 << k);
  end
  assign zero = !(|sum);

  logic [27:0] coarse_s2_q;
  logic [4:0] zeros_s2_q;
  logic [8:0] exp_s2_q;  // U(9.0), biased, before the shift
  logic sign_s2_q, nan_s2_q, inf_s2_q, zero_s2_q;
  always_ff @(posedge clk_i) begin
    coarse_s2_q <= coarse;
    zeros_s2_q  <= zeros;
    exp_s2_q    <= {1'b0, exp_s1_q} + 9'd1;
    // Exact cancellation gives +0.
    sign_s2_q   <= sign_s1_q && !(zero && subtract_s1_q && !inf_s1_q);
    nan_s2_q    <= nan_s1_q;
    inf_s2_q    <= inf_s1_q;
    zero_s2_q   <= zero;
  end

  // ---- s3: the rest of the shift, round, pack, special results ----
  logic [27:0] sig;  // U(1.27)
  logic [31:0] rounded;
  fp_pkg::flags_t unused_flags;
  assign sig = coarse_s2_q << zeros_s2_q[1:0];
  fp_round u_round (
      .sign_i  (sign_s2_q),
      .exp_i   (exp_s2_q - {4'd0, zeros_s2_q}),
      .sig_i   (sig[27:4]),
      .guard_i (sig[3]),
      .round_i (sig[2]),
      .sticky_i(|sig[1:0]),
      .result_o(rounded),
      .flags_o (unused_flags)
  );
  always_comb begin
    result_o = rounded;
    if (nan_s2_q) result_o = fp_pkg::CANON_NAN;
    else if (inf_s2_q) result_o = {sign_s2_q, fp_pkg::PLUS_INF[30:0]};
    else if (zero_s2_q) result_o = {sign_s2_q, 31'd0};
  end

endmodule
