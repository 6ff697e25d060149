// SPDX-License-Identifier: Apache-2.0
// fp_fma: binary32 fused multiply-add +-(a*b) +- c, one rounding; also a*b and a +- c. Pipelined.
// Contract: latency fp_pkg::FP_FMA_LATENCY register ranks, one operation per clock, no stall.
// kind_i: 0 +-(a*b) +- c; 1 +-(a*b), ignores c_i and neg_addend_i (c := -0); 2 +-a +- c, ignores b_i
// (b := 1), so both are the IEEE operations; 3 is reserved. neg_product_i negates a*b (of kind 2: a),
// neg_addend_i negates c. 0 * infinity raises nv and gives NaN whatever c is, a quiet NaN too, which
// IEEE 754-2019 7.2 leaves open. Quiet NaNs otherwise give NaN without nv.
// Stages: e1 unpack | e2 multiply, align | e3 add all products and the addend | e4 coarse normalise |
//         e5 fine normalise | e6 magnitude, round and pack.
module fp_fma (
    input  logic           clk_i,
    input  logic           rst_ni,
    input  logic           valid_i,
    input  logic [1:0]     kind_i,         // fp_pkg::FMA_KIND_*
    input  logic           neg_product_i,
    input  logic           neg_addend_i,
    input  logic [31:0]    a_i,
    input  logic [31:0]    b_i,
    input  logic [31:0]    c_i,
    output logic           valid_o,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  // The frame holds product and addend. Bit 76 is its top; the unit bit of the product is bit 49:
  //
  //   76       53 52 51 50                     3 2   0
  //  |  addend   | 0  0|  product U(2.46)       | 000 |      addend shifted right by 0..127
  //
  // An addend 27 or more places above stays at the top: the product is below its round bit and only
  // sticky. The three low bits serve a product with a subnormal factor, whose leading one may lie
  // at bit 26; an addend that loses bits below bit 0 is then still too small to cancel it.
  localparam int unsigned Frame = 77;

  // ---- e1: unpack, alignment distance ----
  logic [31:0] b_e1;
  logic [30:0] c_e1;
  logic a_subnormal_e1, b_subnormal_e1, c_subnormal_e1;
  logic [7:0] exp_c_e1;  // biased; a subnormal has that of the least normal
  logic add_e1, mul_e1;
  logic a_fraction_e1, b_fraction_e1, c_fraction_e1;  // not zero
  logic sign_product_e1, sign_addend_e1;
  logic [9:0] save1_e1, carry1_e1, save2_e1, carry2_e1;
  logic [7:0] b_field_e1, not_c_field_e1;
  logic [9:0] distance_e1;  // S(10.0): right shift of the addend
  logic unused_e1;

  assign add_e1 = kind_i == fp_pkg::FMA_KIND_ADD;
  assign mul_e1 = kind_i == fp_pkg::FMA_KIND_MUL;
  assign b_e1   = add_e1 ? fp_pkg::ONE : b_i;
  assign c_e1   = mul_e1 ? 31'd0 : c_i[30:0];

  assign sign_product_e1 = a_i[31] ^ b_e1[31] ^ neg_product_i;
  assign sign_addend_e1  = mul_e1 || (c_i[31] ^ neg_addend_i);

  assign a_subnormal_e1 = !(|a_i[30:23]);
  assign b_subnormal_e1 = !(|b_i[30:23]) && !add_e1;   // kind_i next to the exponents, not before them
  assign c_subnormal_e1 = !(|c_i[30:23]) || mul_e1;
  assign exp_c_e1 = {c_e1[30:24], c_e1[23] || c_subnormal_e1};

  assign a_fraction_e1 = |a_i[22:0];
  assign b_fraction_e1 = |b_e1[22:0];
  assign c_fraction_e1 = |c_e1[22:0];

  // The distance is exp_a + exp_b - exp_c - (127 - 27). A subnormal number adds one to its exponent field, and that it is
  // subnormal is known later than the field. So this is a carry into the sum of the fields: free lowest places of two
  // rows, and a bit appended below. With the field C of the addend, -exp_c = ~C - 255 - subnormal = ~C - 256 + !subnormal.
  localparam logic [9:0] Offset = 10'd668;  // -(256 + 127 - 27)

  assign b_field_e1     = b_e1[30:23];
  assign not_c_field_e1 = ~c_e1[30:23];
  assign save1_e1       = {2'b00, a_i[30:23] ^ b_field_e1 ^ not_c_field_e1};
  assign carry1_e1      = {1'b0, (a_i[30:23] & (b_field_e1 | not_c_field_e1)) | (b_field_e1 & not_c_field_e1),
                           !c_subnormal_e1};
  assign save2_e1       = save1_e1 ^ carry1_e1 ^ Offset;
  assign carry2_e1      = {(save1_e1[8:0] & carry1_e1[8:0]) | (Offset[8:0] & (save1_e1[8:0] | carry1_e1[8:0])),
                           a_subnormal_e1};
  assign {distance_e1, unused_e1} = {save2_e1, 1'b1} + {carry2_e1, b_subnormal_e1};

  logic valid_e1_q;
  logic [23:0] sig_a_e1_q, sig_b_e1_q, sig_c_e1_q;  // U(1.23), hidden bit 0 for subnormals
  logic [9:0] distance_e1_q;
  logic [7:0] exp_c_e1_q;
  logic sign_product_e1_q, sign_addend_e1_q;
  logic b_zero_e1_q;
  logic [2:0] highest_e1_q, fraction_e1_q;  // of c, b, a: exponent all ones, fraction not zero

  always_ff @(posedge clk_i) begin
    sig_a_e1_q        <= {!a_subnormal_e1, a_i[22:0]};
    sig_b_e1_q        <= {!b_subnormal_e1, b_e1[22:0]};
    sig_c_e1_q        <= {!c_subnormal_e1, c_e1[22:0]};
    distance_e1_q     <= distance_e1;
    exp_c_e1_q        <= exp_c_e1;
    sign_product_e1_q <= sign_product_e1;
    sign_addend_e1_q  <= sign_addend_e1;
    highest_e1_q      <= {&c_e1[30:23], &b_e1[30:23], &a_i[30:23]};
    fraction_e1_q     <= {c_fraction_e1, b_fraction_e1, a_fraction_e1};
    b_zero_e1_q       <= b_subnormal_e1 && !b_fraction_e1;
  end

  // ---- e2: product; addend into the frame ----
  // Shift by 0..15 first, while the addend is narrow, then by groups of 16 with one select per group.
  logic above_e2, subtract_e2, far_e2, invalid_e2;
  logic [3:0] fine_e2;
  logic [4:0] coarse_e2;  // one-hot
  logic [38:0] fine_addend_e2;  // U(1.38)
  logic [15:1] upto_e2;  // bit i: the shift is i or more
  logic [2:0] tail_e2;  // any bit of the addend at all, in [25:0], in [9:0] of fine_addend
  logic [Frame-1:0] addend_e2;
  logic [47:0] outer_e2;  // product U(2.46) = outer + (low + high) * 2^17
  logic [23:0] cross_low_e2, cross_high_e2;
  logic [2:0] nans_e2, quiet_e2;
  logic signalling_e2, product_inf_e2, product_zero_e2, addend_inf_e2;

  assign nans_e2         = highest_e1_q & fraction_e1_q;
  assign quiet_e2        = {sig_c_e1_q[22], sig_b_e1_q[22], sig_a_e1_q[22]};
  assign signalling_e2   = |(nans_e2 & ~quiet_e2);
  assign product_inf_e2  = |(highest_e1_q[1:0] & ~fraction_e1_q[1:0]);
  assign product_zero_e2 = (!sig_a_e1_q[23] && !fraction_e1_q[0]) || b_zero_e1_q;  // a comes late to E1 in a lane
  assign addend_inf_e2   = highest_e1_q[2] && !fraction_e1_q[2];

  // A zero product must not push the addend out: treat it as infinitely far below.
  assign above_e2    = distance_e1_q[9] || product_zero_e2;
  assign subtract_e2 = sign_product_e1_q ^ sign_addend_e1_q;
  assign invalid_e2  = signalling_e2 || (product_inf_e2 && product_zero_e2)
                    || (product_inf_e2 && addend_inf_e2 && subtract_e2 && !(|nans_e2));

  assign fine_e2        = distance_e1_q[3:0] & {4{!above_e2}};
  assign fine_addend_e2 = {sig_c_e1_q, 15'd0} >> fine_e2;
  assign far_e2         = !above_e2 && (distance_e1_q[8:4] > 5'd4);

  // In front of the shift, whose amount is only used where the addend is not above.
  assign upto_e2 = 15'h7fff >> ~distance_e1_q[3:0];
  assign tail_e2 = {fraction_e1_q[2] || sig_c_e1_q[23],
                    (|sig_c_e1_q[10:0]) || (|(sig_c_e1_q[23:11] & upto_e2[13:1])),
                    |(sig_c_e1_q[9:0] & upto_e2[15:6])};

  always_comb begin
    for (int g = 0; g < 5; g++) coarse_e2[g] = !above_e2 && distance_e1_q[8:4] == 5'(g);
    coarse_e2[0] = coarse_e2[0] || above_e2;
    addend_e2 = {77{1'b0}};
    for (int g = 0; g < 5; g++) addend_e2 = addend_e2 | (({fine_addend_e2, 38'd0} >> (16 * g)) & {77{coarse_e2[g]}});
  end

  fp_product u_multiply (
      .a_i         (sig_a_e1_q),
      .b_i         (sig_b_e1_q),
      .outer_o     (outer_e2),
      .cross_low_o (cross_low_e2),
      .cross_high_o(cross_high_e2)
  );

  logic valid_e2_q;
  logic [47:0] outer_e2_q;
  logic [23:0] cross_low_e2_q, cross_high_e2_q;
  logic [Frame-1:0] addend_e2_q;  // ones' complement if subtracted
  logic [2:0] tail_e2_q;
  logic [2:0] drops_e2_q;  // parts below the frame: 3, the lower 2, the lowest
  logic subtract_e2_q, sign_e2_q, nan_e2_q, invalid_e2_q, inf_e2_q;
  logic [8:0] exp_top_e2_q;  // U(9.0): biased exponent of bit 76, at least 1

  always_ff @(posedge clk_i) begin
    outer_e2_q    <= outer_e2;
    cross_low_e2_q  <= cross_low_e2;
    cross_high_e2_q <= cross_high_e2;
    addend_e2_q   <= addend_e2 ^ {77{subtract_e2}};
    tail_e2_q     <= tail_e2;
    drops_e2_q    <= {far_e2, coarse_e2[4], coarse_e2[3]};
    subtract_e2_q <= subtract_e2;
    exp_top_e2_q  <= {1'b0, exp_c_e1_q} + (above_e2 ? 9'd0 : distance_e1_q[8:0]);
    sign_e2_q     <= addend_inf_e2 ? sign_addend_e1_q : sign_product_e1_q;
    nan_e2_q      <= (|nans_e2) || invalid_e2;
    invalid_e2_q  <= invalid_e2;
    inf_e2_q      <= product_inf_e2 || addend_inf_e2;
  end

  // ---- e3: product +- addend; negative only if the addend is larger, and then nothing was lost ----
  // Bits lost from a subtracted addend make the true difference lie just below: no carry in.
  // Carry-save adders, one where the cross products overlap the outer ones (frame bits 20..43), one for
  // the addend up to the top of the product, bit 50, leave two addends for the only carry chain.
  logic [50:0] outer_e3;
  logic [23:0] save1_e3, carry1_e3;
  logic [30:0] rows_e3, carries_e3, save2_e3, carry2_e3;
  logic unused_e3;
  logic [Frame:0] sum_e3;  // S(78.0)
  logic lost_e3;
  logic [8:0] room_e3;  // left shifts until the exponent would be below 1

  assign lost_e3    = |(drops_e2_q & tail_e2_q);
  assign outer_e3   = {outer_e2_q, 3'd0};
  assign save1_e3   = outer_e3[43:20] ^ cross_low_e2_q ^ cross_high_e2_q;
  assign carry1_e3  = (outer_e3[43:20] & (cross_low_e2_q | cross_high_e2_q))
                    | (cross_low_e2_q & cross_high_e2_q);
  assign rows_e3    = {outer_e3[50:44], save1_e3};
  assign carries_e3 = {6'd0, carry1_e3, 1'b0};
  assign save2_e3   = rows_e3 ^ carries_e3 ^ addend_e2_q[50:20];
  assign carry2_e3  = (rows_e3 & (carries_e3 | addend_e2_q[50:20])) | (carries_e3 & addend_e2_q[50:20]);
  // The bit appended below carries into the sum.
  assign {sum_e3, unused_e3} =
      {subtract_e2_q, addend_e2_q[76:51], save2_e3, addend_e2_q[19:0], 1'b1}
    + {26'd0, carry2_e3, 1'b0, outer_e3[19:0], subtract_e2_q && !lost_e3};
  assign room_e3    = exp_top_e2_q - 9'd1;

  logic valid_e3_q;
  logic [Frame:0] sum_e3_q;
  logic lost_e3_q, subtract_e3_q, sign_e3_q, nan_e3_q, invalid_e3_q, inf_e3_q;
  logic [8:0] exp_top_e3_q;
  logic [4:0] coarse_room_e3_q;  // one bit per group: the room ends inside it
  logic [3:0] fine_room_e3_q;

  always_ff @(posedge clk_i) begin
    sum_e3_q       <= sum_e3;
    lost_e3_q      <= lost_e3;
    subtract_e3_q  <= subtract_e2_q;
    exp_top_e3_q   <= exp_top_e2_q;
    for (int g = 0; g < 5; g++) coarse_room_e3_q[g] <= room_e3[8:4] == 5'(g);
    fine_room_e3_q <= room_e3[3:0];
    sign_e3_q      <= sign_e2_q;
    nan_e3_q       <= nan_e2_q;
    invalid_e3_q   <= invalid_e2_q;
    inf_e3_q       <= inf_e2_q;
  end

  // ---- e4: left shift by whole groups of 16 bits ----
  // A negative sum stays in two's complement up to e6. Its ones' complement V is the magnitude minus
  // one, that is 0.V111.. with ones for ever, so its leading one and rounding bits serve as well: in
  // the sum itself those ones are the zeros that a left shift brings. The group wanted is the first
  // that differs from the sign, or the one in which the room ends.
  logic [79:0] groups_e4;  // group 0 (top) .. 4, three zeros at the end
  logic negative_e4, below_e4;
  logic [3:0] differs_e4, stop_e4;
  logic [4:0] group_e4;  // one-hot
  logic [47:0] window_e4;

  assign groups_e4   = {sum_e3_q[Frame-1:0], 3'd0};
  assign negative_e4 = sum_e3_q[Frame];

  always_comb begin
    for (int g = 0; g < 4; g++) differs_e4[g] = negative_e4 ? !(&groups_e4[16*(4-g)+:16]) : (|groups_e4[16*(4-g)+:16]);
    stop_e4 = differs_e4 | coarse_room_e3_q[3:0];
    group_e4 = {stop_e4[3:0] == 4'b0000, stop_e4[3:0] == 4'b1000, stop_e4[2:0] == 3'b100,
                stop_e4[1:0] == 2'b10, stop_e4[0]};
    window_e4 = 48'd0;
    for (int g = 0; g < 5; g++) window_e4 = window_e4 | (48'({groups_e4, 64'd0} >> (16 * (6 - g))) & {48{group_e4[g]}});
    below_e4 = (group_e4[0] && (|groups_e4[31:0])) || (group_e4[1] && (|groups_e4[15:0]));
  end

  logic valid_e4_q;
  logic [47:0] window_e4_q;  // U(1.47), not yet normalised
  logic negative_e4_q, below_e4_q;
  logic zero_e4_q, subtract_e4_q, sign_e4_q, nan_e4_q, invalid_e4_q, inf_e4_q;
  logic [15:0] room_e4_q;  // one-hot: the left shift that ends the room, or none
  logic [2:0] group_e4_q;
  logic [8:0] exp_top_e4_q;

  always_ff @(posedge clk_i) begin
    window_e4_q    <= window_e4;
    negative_e4_q  <= negative_e4;
    below_e4_q     <= below_e4 || lost_e3_q;
    group_e4_q     <= {group_e4[4], group_e4[3] || group_e4[2], group_e4[3] || group_e4[1]};
    for (int i = 0; i < 16; i++) room_e4_q[15-i] <= (|(coarse_room_e3_q & group_e4)) && fine_room_e3_q == 4'(i);
    exp_top_e4_q   <= exp_top_e3_q;
    zero_e4_q      <= !(|sum_e3_q) && !lost_e3_q;
    // An infinity brought its own sign.
    sign_e4_q      <= sign_e3_q ^ (negative_e4 && !inf_e3_q);
    subtract_e4_q  <= subtract_e3_q;
    nan_e4_q       <= nan_e3_q;
    invalid_e4_q   <= invalid_e3_q;
    inf_e4_q       <= inf_e3_q;
  end

  // ---- e5: left shift by 0..15, no further than the exponent allows ----
  logic [3:0] zeros_e5;
  logic [25:0] sig_e5;
  logic sticky_e5;

  fp_fine_left u_fine (
      .window_i  (window_e4_q),
      .negative_i(negative_e4_q),
      .room_i    (room_e4_q),
      .count_o   (zeros_e5),
      .sig_o     (sig_e5),
      .sticky_o  (sticky_e5)
  );

  logic valid_e5_q;
  logic [25:0] sig_e5_q;  // U(1.25), ones' complement if negative
  logic negative_e5_q, sticky_e5_q;
  logic zero_e5_q, sign_e5_q, nan_e5_q, invalid_e5_q, inf_e5_q;
  logic [8:0] exp_e5_q;  // U(9.0), biased

  always_ff @(posedge clk_i) begin
    sig_e5_q      <= sig_e5;
    negative_e5_q <= negative_e4_q;
    sticky_e5_q   <= sticky_e5 || below_e4_q;
    exp_e5_q      <= exp_top_e4_q - {2'd0, group_e4_q, zeros_e5};
    zero_e5_q     <= zero_e4_q;
    // Exact cancellation gives +0.
    sign_e5_q     <= sign_e4_q && !(zero_e4_q && subtract_e4_q && !inf_e4_q);
    nan_e5_q      <= nan_e4_q;
    invalid_e5_q  <= invalid_e4_q;
    inf_e5_q      <= inf_e4_q;
  end

  // ---- e6: round, pack, special results ----
  // Negative: complement, and add one at the very end if only zeros (ones of V) follow the round
  // bit. Where it also passes guard and round bit, the result is exact and one ulp above: that is
  // what fp_round makes of guard = round = 1, except for the flags. It cannot overflow there.
  logic [25:0] magnitude_e6;  // U(1.25)
  logic end_around_e6, exact_up_e6, guard_e6, round_e6;
  logic [31:0] result_e6;
  fp_pkg::flags_t flags_e6;

  assign magnitude_e6  = sig_e5_q ^ {26{negative_e5_q}};
  assign end_around_e6 = negative_e5_q && !sticky_e5_q;
  assign exact_up_e6   = end_around_e6 && (&magnitude_e6[1:0]);
  assign guard_e6      = exact_up_e6 || (magnitude_e6[1] ^ (end_around_e6 && magnitude_e6[0]));
  assign round_e6      = exact_up_e6 || (magnitude_e6[0] ^ end_around_e6);

  fp_pack u_pack (
      .sign_i   (sign_e5_q),
      .exp_i    (exp_e5_q),
      .sig_i    (magnitude_e6[25:2]),
      .guard_i  (guard_e6),
      .round_i  (round_e6),
      .sticky_i (sticky_e5_q),
      .exact_i  (exact_up_e6),
      .nan_i    (nan_e5_q),
      .invalid_i(invalid_e5_q),
      .inf_i    (inf_e5_q),
      .by_zero_i(1'b0),
      .zero_i   (zero_e5_q),
      .result_o (result_e6),
      .flags_o  (flags_e6)
  );

  always_ff @(posedge clk_i) begin
    result_o <= result_e6;
    flags_o  <= flags_e6;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_e1_q <= 1'b0;
      valid_e2_q <= 1'b0;
      valid_e3_q <= 1'b0;
      valid_e4_q <= 1'b0;
      valid_e5_q <= 1'b0;
      valid_o    <= 1'b0;
    end else begin
      valid_e1_q <= valid_i;
      valid_e2_q <= valid_e1_q;
      valid_e3_q <= valid_e2_q;
      valid_e4_q <= valid_e3_q;
      valid_e5_q <= valid_e4_q;
      valid_o    <= valid_e5_q;
    end
  end

endmodule
