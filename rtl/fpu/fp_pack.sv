// SPDX-License-Identifier: Apache-2.0
// fp_pack: the last step of a unit, round and pack a magnitude or give its special result. Combinational.
// Contract: magnitude and exponent as for fp_round, meaningful unless a special result is wanted. NaN
// goes before infinity before zero; a NaN raises nv if invalid_i, an infinity dz if by_zero_i, and else
// special results raise nothing. exact_i: the rounded result is exact, whatever its low bits are.
module fp_pack (
    input  logic           sign_i,
    input  logic [8:0]     exp_i,
    input  logic [23:0]    sig_i,
    input  logic           guard_i,
    input  logic           round_i,
    input  logic           sticky_i,
    input  logic           exact_i,
    // special results
    input  logic           nan_i,
    input  logic           invalid_i,
    input  logic           inf_i,
    input  logic           by_zero_i,
    input  logic           zero_i,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  logic [31:0] rounded;
  fp_pkg::flags_t rounded_flags;

  fp_round u_round (
      .sign_i,
      .exp_i,
      .sig_i,
      .guard_i,
      .round_i,
      .sticky_i,
      .result_o(rounded),
      .flags_o (rounded_flags)
  );

  always_comb begin
    result_o = rounded;
    flags_o  = rounded_flags & {5{!exact_i}};
    if (nan_i) begin
      result_o = fp_pkg::CANON_NAN;
      flags_o  = {invalid_i, 4'b0000};
    end else if (inf_i) begin
      result_o = {sign_i, fp_pkg::PLUS_INF[30:0]};
      flags_o  = {1'b0, by_zero_i, 3'b000};
    end else if (zero_i) begin
      result_o = {sign_i, 31'd0};
      flags_o  = 5'b00000;
    end
  end

endmodule
