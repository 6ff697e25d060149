// SPDX-License-Identifier: Apache-2.0
// ci_fmul: custom instruction, a * b, in few long stages for a 100 MHz CPU.
// Contract: fixed latency, ci_pkg::FPGA2_FMUL_CYCLES cycles: two register ranks run freely on the
// operands, which the CPU holds, and the third stage ends in the CPU. The result holds from then
// on, however long clk_en stalls. IEEE 754: to nearest even, subnormal numbers, canonical NaN; no
// flags. Stages: s1 product, exponent, zeros | s2 shift | s3 round, pack.
module ci_fmul (
    input  logic        clk_i,
    input  logic        reset_i,
    input  logic        clk_en_i,
    input  logic        start_i,
    input  logic [31:0] dataa_i,
    input  logic [31:0] datab_i,
    output logic [31:0] result_o
);

  logic unused_control;
  assign unused_control = reset_i || clk_en_i || start_i;

  // ---- s1: product U(2.46) and what decides the shift to its final exponent ----
  // A subnormal operand enters without hidden bit. {product, 10 zeros} >> shift leaves U(2.25), and
  // 31 keeps the place; less restores the zeros that a subnormal operand brought, as far as the
  // exponent has room; more denormalises; from 58 on only the sticky bit is left.
  logic a_normal, b_normal;
  logic [23:0] sig_a, sig_b;
  logic [9:0] exp;  // S(10.0): biased exponent of the product, minus one
  logic [4:0] zeros, zeros_a, zeros_b;
  assign a_normal  = |dataa_i[30:23];
  assign b_normal  = |datab_i[30:23];
  assign sig_a     = {a_normal, dataa_i[22:0]};
  assign sig_b     = {b_normal, datab_i[22:0]};
  assign exp = {2'b00, dataa_i[30:24], dataa_i[23] || !a_normal}
             + {2'b00, datab_i[30:24], datab_i[23] || !b_normal} - 10'd128;

  // Zeros before the first one of a subnormal operand, at most what the exponent of the other has
  // above that of the least product. Groups of four places: the first that is not empty counts.
  function automatic logic [4:0] restored(input logic [22:0] fraction, input logic [7:0] other);
    logic [23:0] stop;
    logic [5:0] filled;
    logic [5:0][1:0] leading;
    stop = {1'b0, fraction};
    for (int i = 0; i < 24; i++) if (other == 8'(127 + i)) stop[23-i] = 1'b1;
    for (int g = 0; g < 6; g++) begin
      filled[g] = |stop[4*g+:4];
      casez (stop[4*g+:4])
        4'b1???: leading[g] = 2'd0;
        4'b01??: leading[g] = 2'd1;
        4'b001?: leading[g] = 2'd2;
        default: leading[g] = 2'd3;
      endcase
    end
    casez (filled)
      6'b1?????: restored = {3'd0, leading[5]};
      6'b01????: restored = {3'd1, leading[4]};
      6'b001???: restored = {3'd2, leading[3]};
      6'b0001??: restored = {3'd3, leading[2]};
      6'b00001?: restored = {3'd4, leading[1]};
      default:   restored = {3'd5, leading[0]};
    endcase
  endfunction
  assign zeros_a = restored(dataa_i[22:0], datab_i[30:23]);
  assign zeros_b = restored(datab_i[22:0], dataa_i[30:23]);
  // Of two subnormal operands the product is denormal, and the zeros do not matter.
  assign zeros = (zeros_a & {5{!a_normal}}) | (zeros_b & {5{!b_normal}});

  logic [47:0] outer, outer_s1_q;  // product = outer + (cross_low + cross_high) * 2^17
  logic [23:0] cross_low, cross_high, cross_low_s1_q, cross_high_s1_q;
  fp_product u_multiply (
      .a_i         (sig_a),
      .b_i         (sig_b),
      .outer_o     (outer),
      .cross_low_o (cross_low),
      .cross_high_o(cross_high)
  );

  logic [4:0] zeros_s1_q;
  logic [9:0] exp_s1_q;  // S(10.0), before zeros are restored; negative: denormalised
  logic sign_s1_q, nan_s1_q, inf_s1_q, zero_s1_q;
  always_ff @(posedge clk_i) begin
    outer_s1_q      <= outer;
    cross_low_s1_q  <= cross_low;
    cross_high_s1_q <= cross_high;
    zeros_s1_q <= zeros;
    exp_s1_q   <= exp;
    sign_s1_q  <= dataa_i[31] ^ datab_i[31];
    nan_s1_q   <= fp_pkg::is_nan(dataa_i) || fp_pkg::is_nan(datab_i)
               || (fp_pkg::is_inf(dataa_i) && fp_pkg::is_zero(datab_i))
               || (fp_pkg::is_zero(dataa_i) && fp_pkg::is_inf(datab_i));
    inf_s1_q   <= fp_pkg::is_inf(dataa_i) || fp_pkg::is_inf(datab_i);
    zero_s1_q  <= fp_pkg::is_zero(dataa_i) || fp_pkg::is_zero(datab_i);
  end

  // ---- s2: shift, then at most one place to the right ----
  logic [47:0] product;  // U(2.46)
  logic [30:0] unused_shifted;  // zeros, since the product is below 4 after the shift
  logic [26:0] shifted;  // U(2.25)
  logic lost, high, denormal, far;
  logic [5:0] shift;
  logic [8:0] exp_low, exp_high;  // U(9.0), biased, if the product is below two, and if it is not
  // Carry-save, so that one carry chain is left.
  logic [30:0] partial;  // in units of 2^17
  logic [23:0] carries;
  assign partial = outer_s1_q[47:17] ^ {7'd0, cross_low_s1_q} ^ {7'd0, cross_high_s1_q};
  assign carries = (outer_s1_q[40:17] & (cross_low_s1_q | cross_high_s1_q))
                 | (cross_low_s1_q & cross_high_s1_q);
  assign product = {partial + {6'd0, carries, 1'b0}, outer_s1_q[16:0]};
  assign denormal = exp_s1_q[9];
  assign far      = !(&exp_s1_q[8:5]);
  assign shift    = denormal ? {1'b1, ~exp_s1_q[4:0] | {5{far}}} : {1'b0, ~zeros_s1_q};
  fp_shift_right #(
      .Width(58),
      .AmountWidth(6)
  ) u_normalise (
      .value_i ({product, 10'd0}),
      .amount_i(shift),
      .value_o ({unused_shifted, shifted}),
      .sticky_o(lost)
  );
  assign high     = shifted[26];
  assign exp_low  = denormal ? 9'd1 : exp_s1_q[8:0] + 9'd1 - {4'd0, zeros_s1_q};
  assign exp_high = denormal ? 9'd2 : exp_s1_q[8:0] + 9'd2 - {4'd0, zeros_s1_q};

  logic [25:0] sig_s2_q;  // U(1.25)
  logic sticky_s2_q;
  logic [8:0] exp_s2_q;  // U(9.0), biased
  logic sign_s2_q, nan_s2_q, inf_s2_q, zero_s2_q;
  always_ff @(posedge clk_i) begin
    sig_s2_q    <= high ? shifted[26:1] : shifted[25:0];
    sticky_s2_q <= lost || (high && shifted[0]);
    exp_s2_q    <= high ? exp_high : exp_low;
    sign_s2_q   <= sign_s1_q;
    nan_s2_q    <= nan_s1_q;
    inf_s2_q    <= inf_s1_q;
    zero_s2_q   <= zero_s1_q;
  end

  // ---- s3: round, pack, special results ----
  logic [31:0] rounded;
  fp_pkg::flags_t unused_flags;
  fp_round u_round (
      .sign_i  (sign_s2_q),
      .exp_i   (exp_s2_q),
      .sig_i   (sig_s2_q[25:2]),
      .guard_i (sig_s2_q[1]),
      .round_i (sig_s2_q[0]),
      .sticky_i(sticky_s2_q),
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
