// SPDX-License-Identifier: Apache-2.0
// ci_faddsub: custom instruction, a + b (n 0) or a - b (n 1), in few long stages for a 100 MHz CPU.
// Contract: fixed latency, ci_pkg::FPGA2_FADD_CYCLES cycles: two register ranks run freely on the
// operands, which the CPU holds, and the third stage ends in the CPU. The result holds from then
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
  logic a_normal, b_normal, b_above, a_larger, swap, far;
  logic [7:0] exp_a, exp_b;
  logic [7:2] distance;  // the lower two bits are used before it is known
  logic [8:0] a_minus_b;  // S(8.0)
  logic [23:0] sig_a, sig_b;  // U(1.23)
  assign exp_a     = dataa_i[30:23];
  assign exp_b     = datab_i[30:23];
  assign a_normal  = |exp_a;
  assign b_normal  = |exp_b;
  assign sig_a     = a_normal ? {1'b1, dataa_i[22:0]} : {dataa_i[22:0], 1'b0};
  assign sig_b     = b_normal ? {1'b1, datab_i[22:0]} : {datab_i[22:0], 1'b0};
  assign a_minus_b = {1'b0, exp_a} - {1'b0, exp_b};
  // If b is above, the complement is one less than the distance: sig_a has moved by that one.
  assign b_above   = a_minus_b[8];
  assign distance  = a_minus_b[7:2] ^ {6{b_above}};
  assign a_larger  = dataa_i[30:0] >= datab_i[30:0];
  // At equal exponents the larger significand goes first, so that no difference is negative.
  assign swap      = !a_larger && !b_above;
  assign far       = |distance[7:5];

  // Whether a significand, U(1.24), loses a one when it moves right by `places` and 26 bits are left.
  function automatic logic loses(input logic [24:0] value, input logic [7:0] places);
    logic [27:0] bits;  // bit i is lost from i places on
    logic some, part;
    bits = {1'b0, value, 2'b00};
    loses = 1'b0;
    for (int g = 0; g < 7; g++) begin
      some = |bits[4*g+:4];
      part = bits[4*g] || (bits[4*g+1] && places[1:0] != 2'd0) ||
             (bits[4*g+2] && places[1]) || (bits[4*g+3] && places[1:0] == 2'd3);
      loses = loses || (some && places[7:2] > 6'(g)) || (part && places[7:2] == 6'(g));
    end
  endfunction

  // The sign of the difference comes last: both ways are ready as far as they do not depend on it.
  logic [25:0] near_a, near_b, near, aligned;  // U(1.25)
  logic lost;
  logic [26:0] minor;  // |24 bits|guard|round|sticky|, U(1.26)
  assign near_b  = {sig_b, 2'b00} >> a_minus_b[1:0];
  assign near_a  = {1'b0, sig_a, 1'b0} >> ~a_minus_b[1:0];
  assign near    = b_above ? near_a : near_b;
  assign aligned = near >> {distance[4:2], 2'b00};
  assign lost    = b_above ? loses({1'b0, sig_a}, ~a_minus_b[7:0]) : loses({sig_b, 1'b0}, a_minus_b[7:0]);
  always_comb begin
    minor = {aligned & {26{!far}}, lost};
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
  logic zero;
  assign sum = {1'b0, large_s1_q, 3'd0} + {subtract_s1_q, minor_s1_q} + {27'd0, subtract_s1_q};
  // The bit that would be the leading one at the least exponent: left shifts stop there.
  always_comb begin
    for (int i = 0; i < 28; i++) room[27-i] = exp_s1_q == 8'(i);
  end
  // The leading one is in the first of seven groups of four bits that is not empty. Groups 6 to 3 are
  // the upper half. Every group counts its own zeros meanwhile.
  logic [6:1] filled;
  logic [6:0][1:0] leading;  // zeros of a group before its first one
  logic upper;
  logic [1:0] skip_upper, skip_lower, bits_upper, bits_lower;  // empty groups; zeros of the next one
  logic [4:0] zeros;
  always_comb begin
    for (int g = 0; g < 7; g++) begin
      if (g != 0) filled[g] = (|sum[4*g+:4]) || exp_s1_q[7:2] == 6'(6 - g);
      casez (sum[4*g+:4] | room[4*g+:4])
        4'b1???: leading[g] = 2'd0;
        4'b01??: leading[g] = 2'd1;
        4'b001?: leading[g] = 2'd2;
        default: leading[g] = 2'd3;
      endcase
    end
    upper = |filled[6:3];
    casez (filled[6:4])
      3'b1??:  {skip_upper, bits_upper} = {2'd0, leading[6]};
      3'b01?:  {skip_upper, bits_upper} = {2'd1, leading[5]};
      3'b001:  {skip_upper, bits_upper} = {2'd2, leading[4]};
      default: {skip_upper, bits_upper} = {2'd3, leading[3]};
    endcase
    casez (filled[2:1])
      2'b1?:   {skip_lower, bits_lower} = {2'd0, leading[2]};
      2'b01:   {skip_lower, bits_lower} = {2'd1, leading[1]};
      default: {skip_lower, bits_lower} = {2'd2, leading[0]};
    endcase
    zeros = upper ? {1'b0, skip_upper, bits_upper} : {1'b1, skip_lower, bits_lower};
    coarse = upper ? sum << {skip_upper, 2'b00} : {sum[11:0], 16'd0} << {skip_lower, 2'b00};
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
