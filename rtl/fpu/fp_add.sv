// SPDX-License-Identifier: Apache-2.0
// fp_add: binary32 addition a + b and subtraction a - b, pipelined, one operation per clock.
// Contract: latency fp_pkg::FP_ADD_LATENCY register ranks, no stall.
// Stages: e1 unpack, order by magnitude | e2 align and add | e3 normalise | e4 round and pack.
module fp_add (
    input  logic           clk_i,
    input  logic           rst_ni,
    input  logic           valid_i,
    input  logic           sub_i,
    input  logic [31:0]    a_i,
    input  logic [31:0]    b_i,
    output logic           valid_o,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  // ---- e1: the operand of larger magnitude goes first, so that no difference is negative ----
  logic a_subnormal_e1, b_subnormal_e1, a_larger_e1, sign_b_e1, subtract_e1, infinities_e1;
  logic [7:0] exp_a_e1, exp_b_e1;  // biased; a subnormal has that of the least normal
  logic [7:0] a_above_b_e1, b_above_a_e1;
  logic [23:0] sig_a_e1, sig_b_e1;  // U(1.23), hidden bit 0 for subnormals and zero

  assign a_subnormal_e1 = !(|a_i[30:23]);
  assign b_subnormal_e1 = !(|b_i[30:23]);
  assign exp_a_e1       = {a_i[30:24], a_i[23] || a_subnormal_e1};
  assign exp_b_e1       = {b_i[30:24], b_i[23] || b_subnormal_e1};
  assign sig_a_e1       = {!a_subnormal_e1, a_i[22:0]};
  assign sig_b_e1       = {!b_subnormal_e1, b_i[22:0]};
  assign a_larger_e1    = a_i[30:0] >= b_i[30:0];
  assign a_above_b_e1   = exp_a_e1 - exp_b_e1;
  assign b_above_a_e1   = exp_b_e1 - exp_a_e1;
  assign sign_b_e1      = b_i[31] ^ sub_i;
  assign subtract_e1    = a_i[31] ^ sign_b_e1;
  assign infinities_e1  = fp_pkg::is_inf(a_i) && fp_pkg::is_inf(b_i);

  logic valid_e1_q, sign_e1_q, subtract_e1_q, nan_e1_q, invalid_e1_q, inf_e1_q;
  logic [23:0] large_e1_q, small_e1_q;  // U(1.23)
  logic [7:0] exp_e1_q, distance_e1_q;

  always_ff @(posedge clk_i) begin
    large_e1_q    <= a_larger_e1 ? sig_a_e1 : sig_b_e1;
    small_e1_q    <= a_larger_e1 ? sig_b_e1 : sig_a_e1;
    exp_e1_q      <= a_larger_e1 ? exp_a_e1 : exp_b_e1;
    distance_e1_q <= a_larger_e1 ? a_above_b_e1 : b_above_a_e1;
    sign_e1_q     <= a_larger_e1 ? a_i[31] : sign_b_e1;
    subtract_e1_q <= subtract_e1;
    nan_e1_q      <= fp_pkg::is_nan(a_i) || fp_pkg::is_nan(b_i) || (infinities_e1 && subtract_e1);
    invalid_e1_q  <= fp_pkg::is_snan(a_i) || fp_pkg::is_snan(b_i) || (infinities_e1 && subtract_e1);
    inf_e1_q      <= fp_pkg::is_inf(a_i) || fp_pkg::is_inf(b_i);
  end

  // ---- e2: align and add ----
  //  | carry | 24 bits of the larger | guard | round | sticky |      28 bits, U(2.26)
  // The sticky bit takes part in the subtraction as a bit of its own: a difference that loses more
  // than one leading bit has operands less than two places apart and so no sticky bit.
  logic [31:0] aligned_e2;  // U(1.31): distances up to 31 leave 26 bits and a sticky
  logic lost_e2, far_e2;
  logic [26:0] small_e2;
  logic [27:0] sum_e2, room_e2;

  assign far_e2 = |distance_e1_q[7:5];

  fp_shift_right #(
      .Width(32),
      .AmountWidth(5),
      .WidestFirst(1'b0)
  ) u_align (
      .value_i ({small_e1_q, 8'd0}),
      .amount_i(distance_e1_q[4:0]),
      .value_o (aligned_e2),
      .sticky_o(lost_e2)
  );

  assign small_e2[26:1] = aligned_e2[31:6] & {26{!far_e2}};
  assign small_e2[0]    = far_e2 ? (|small_e1_q) : (lost_e2 || (|aligned_e2[5:0]));
  assign sum_e2 = {1'b0, large_e1_q, 3'd0} + ({1'b0, small_e2} ^ {28{subtract_e1_q}})
                + {27'd0, subtract_e1_q};

  // The bit that would be the leading one at the least exponent: left shifts stop there.
  always_comb begin
    for (int i = 0; i < 28; i++) room_e2[27-i] = exp_e1_q == 8'(i);
  end

  logic valid_e2_q, sign_e2_q, subtract_e2_q, nan_e2_q, invalid_e2_q, inf_e2_q;
  logic [27:0] sum_e2_q, room_e2_q;
  logic [7:0] exp_e2_q;

  always_ff @(posedge clk_i) begin
    sum_e2_q      <= sum_e2;
    room_e2_q     <= room_e2;
    exp_e2_q      <= exp_e1_q;
    sign_e2_q     <= sign_e1_q;
    subtract_e2_q <= subtract_e1_q;
    nan_e2_q      <= nan_e1_q;
    invalid_e2_q  <= invalid_e1_q;
    inf_e2_q      <= inf_e1_q;
  end

  // ---- e3: normalise ----
  logic [4:0] zeros_e3;
  logic unused_empty_e3, zero_e3;
  logic [27:0] shifted_e3;

  fp_lzc #(
      .CountWidth(5)
  ) u_lzc (
      .value_i({sum_e2_q | room_e2_q, 4'd0}),
      .count_o(zeros_e3),
      .zero_o (unused_empty_e3)
  );

  // Widest shift first: the upper bits of the count are known first.
  always_comb begin
    shifted_e3 = sum_e2_q;
    for (int k = 4; k >= 0; k--) if (zeros_e3[k]) shifted_e3 = shifted_e3 << (1 << k);
  end

  assign zero_e3 = !(|sum_e2_q);

  logic valid_e3_q, sign_e3_q, zero_e3_q, nan_e3_q, invalid_e3_q, inf_e3_q;
  logic [27:0] sig_e3_q;  // U(1.27)
  logic [8:0] exp_e3_q;  // U(9.0), biased

  always_ff @(posedge clk_i) begin
    sig_e3_q     <= shifted_e3;
    exp_e3_q     <= {1'b0, exp_e2_q} + 9'd1 - {4'd0, zeros_e3};
    zero_e3_q    <= zero_e3;
    // Exact cancellation gives +0.
    sign_e3_q    <= sign_e2_q && !(zero_e3 && subtract_e2_q && !inf_e2_q);
    nan_e3_q     <= nan_e2_q;
    invalid_e3_q <= invalid_e2_q;
    inf_e3_q     <= inf_e2_q;
  end

  // ---- e4: round, pack, special results ----
  logic [31:0] result_e4;
  fp_pkg::flags_t flags_e4;

  fp_pack u_pack (
      .sign_i   (sign_e3_q),
      .exp_i    (exp_e3_q),
      .sig_i    (sig_e3_q[27:4]),
      .guard_i  (sig_e3_q[3]),
      .round_i  (sig_e3_q[2]),
      .sticky_i (|sig_e3_q[1:0]),
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
