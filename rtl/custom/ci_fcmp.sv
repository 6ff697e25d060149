// SPDX-License-Identifier: Apache-2.0
// ci_fcmp: custom instructions, comparisons, minimum, maximum, magnitude, negation. Combinational.
// Contract: n_i is the low part of the numbers of ci_pkg; values of n_i without an instruction give
// 0. Comparisons give the integers 1 and 0 and are false with a NaN, but != true. The minimum and
// the maximum prefer a number to a NaN, order -0 below +0, and give the canonical NaN for two NaN.
module ci_fcmp (
    input  logic [31:0] dataa_i,
    input  logic [31:0] datab_i,
    input  logic [3:0]  n_i,
    output logic [31:0] result_o
);

  localparam logic [3:0] Abs = ci_pkg::FPGA2_N_FABS[3:0];
  localparam logic [3:0] Neg = ci_pkg::FPGA2_N_FNEG[3:0];
  localparam logic [3:0] Ne = ci_pkg::FPGA2_N_FCMPNE[3:0];
  localparam logic [3:0] Eq = ci_pkg::FPGA2_N_FCMPEQ[3:0];
  localparam logic [3:0] Ge = ci_pkg::FPGA2_N_FCMPGE[3:0];
  localparam logic [3:0] Gt = ci_pkg::FPGA2_N_FCMPGT[3:0];
  localparam logic [3:0] Le = ci_pkg::FPGA2_N_FCMPLE[3:0];
  localparam logic [3:0] Lt = ci_pkg::FPGA2_N_FCMPLT[3:0];
  localparam logic [3:0] Max = ci_pkg::FPGA2_N_FMAX[3:0];
  localparam logic [3:0] Min = ci_pkg::FPGA2_N_FMIN[3:0];

  logic unused_below, less, equal, a_nan, b_nan, ordered, truth, take_b;
  ci_order u_order (
      .a_i    (dataa_i),
      .b_i    (datab_i),
      .below_o(unused_below),
      .less_o (less),
      .equal_o(equal)
  );
  assign a_nan   = fp_pkg::is_nan(dataa_i);
  assign b_nan   = fp_pkg::is_nan(datab_i);
  assign ordered = !a_nan && !b_nan;

  always_comb begin
    case (n_i)
      Ne:      truth = !ordered || !equal;
      Eq:      truth = ordered && equal;
      Ge:      truth = ordered && !less;
      Gt:      truth = ordered && !less && !equal;
      Le:      truth = ordered && (less || equal);
      Lt:      truth = ordered && less;
      default: truth = 1'b0;
    endcase
  end

  // A minimum or maximum of equal operands is either, so that it needs no comparison for equality.
  // `early` needs none at all.
  logic extreme, number, take_a, smaller, a_first;
  logic [31:0] early;
  assign extreme = n_i == Max || n_i == Min;
  assign number  = extreme && !(a_nan && b_nan);
  assign smaller = dataa_i[30:0] < datab_i[30:0];
  assign a_first = dataa_i[31] != datab_i[31] ? dataa_i[31] : smaller != dataa_i[31];
  assign take_b  = number && (a_nan || (!b_nan && (a_first == (n_i == Max))));
  assign take_a  = number && !a_nan && (b_nan || (a_first != (n_i == Max)));
  always_comb begin
    case (n_i)
      Abs:      early = {1'b0, dataa_i[30:0]};
      Neg:      early = {!dataa_i[31], dataa_i[30:0]};
      Max, Min: early = (a_nan && b_nan) ? fp_pkg::CANON_NAN : 32'd0;
      default:  early = 32'd0;
    endcase
    result_o = early | ({32{take_a}} & dataa_i) | ({32{take_b}} & datab_i) | {31'd0, truth};
  end

endmodule
