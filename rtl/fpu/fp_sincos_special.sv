// SPDX-License-Identifier: Apache-2.0
// fp_sincos_special: the sine or cosine of operands outside the approximation. Combinational.
// Contract: special_o for |a| above 256, infinities and NaN, whose result is the canonical NaN, and for |a|
// below 2^-12, where the results rounded to nearest are a and 1. Zero gives +-0 or 1 exactly.
module fp_sincos_special (
    input  logic           cos_i,
    input  logic [31:0]    a_i,
    output logic           special_o,
    output logic [31:0]    result_o,   // both valid if special_o
    output fp_pkg::flags_t flags_o
);

  localparam logic [7:0] EXP_MAX = 8'd135;  // of 256
  localparam logic [7:0] EXP_MIN = 8'd115;  // of 2^-12

  logic out_of_range, below_min, invalid, underflow, inexact;

  assign out_of_range = a_i[30:0] > {EXP_MAX, 23'd0};     // NaN and infinity as well
  assign below_min    = a_i[30:23] < EXP_MIN;
  assign invalid      = !fp_pkg::is_nan(a_i) || fp_pkg::is_snan(a_i);
  assign underflow    = !cos_i && !(|a_i[30:23]) && (|a_i[22:0]);
  assign inexact      = |a_i[30:0];

  assign special_o = out_of_range || below_min;

  always_comb begin
    if (out_of_range) begin
      result_o = fp_pkg::CANON_NAN;
      flags_o  = {invalid, 4'b0000};
    end else begin
      result_o = cos_i ? fp_pkg::ONE : a_i;
      flags_o  = {3'b000, underflow, inexact};
    end
  end

endmodule
