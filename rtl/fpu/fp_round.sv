// SPDX-License-Identifier: Apache-2.0
// fp_round: round a non-zero magnitude to nearest even and pack it as binary32. Combinational.
// Contract: {sig_i, guard_i, round_i, sticky_i} is the magnitude, U(1.23) plus two bits and a sticky
// bit for all lower ones. Normal numbers have sig_i[23] = 1; a subnormal has sig_i[23] = 0 and
// exp_i = 1. exp_i is the biased exponent, 1..511; 255 and above overflows. NaN, infinity and exact
// zero are the caller's business. Tininess is detected after rounding: with unbounded exponent the
// subnormal 0.11..1|1|1 rounds up to the smallest normal number and is not tiny.
module fp_round (
    input  logic           sign_i,
    input  logic [8:0]     exp_i,
    input  logic [23:0]    sig_i,
    input  logic           guard_i,
    input  logic           round_i,
    input  logic           sticky_i,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  logic inexact, increment, subnormal, tiny, huge, overflow;
  logic [7:0] exp_field;
  logic [30:0] packed_up;

  assign inexact   = guard_i || round_i || sticky_i;
  assign increment = guard_i && (round_i || sticky_i || sig_i[0]);
  assign subnormal = !sig_i[23];
  assign tiny      = subnormal && !((&sig_i[22:0]) && guard_i && round_i);

  // A carry out of the fraction moves into the exponent field: subnormal to normal, 1.11..1 to 10.0.
  assign exp_field = exp_i[7:0] & {8{!subnormal}};
  assign packed_up = {exp_field, sig_i[22:0]} + {30'd0, increment};

  // A carry out of the largest finite number packs infinity by itself, so that neither the result nor
  // its flag waits for the sum.
  assign huge     = exp_i[8] || (&exp_i[7:0]);
  assign overflow = huge || ((&exp_i[7:1]) && (&sig_i[22:0]) && increment);

  assign result_o = huge ? {sign_i, fp_pkg::PLUS_INF[30:0]} : {sign_i, packed_up};

  always_comb begin
    flags_o    = '0;
    flags_o.of = overflow;
    flags_o.uf = tiny && inexact;
    flags_o.nx = inexact || overflow;
  end

endmodule
