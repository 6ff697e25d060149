// SPDX-License-Identifier: Apache-2.0
// fp_cmp: comparisons, selections, sign operations and 32-bit integer add/subtract, one per clock.
// Contract: latency fp_pkg::FP_CMP_LATENCY register ranks, no stall; op_i is one of fp_pkg::FP_CMP_*,
// where each operation, its NaN rule and its flags are stated. Unlisted op_i values act as MOV.
// Values are compared as IEEE 754-2019 numbers (subnormals count, -0 equals +0); only nv can be set.
module fp_cmp (
    input  logic           clk_i,
    input  logic           rst_ni,
    input  logic           valid_i,
    input  logic [3:0]     op_i,
    input  logic [31:0]    a_i,
    input  logic [31:0]    b_i,
    input  logic [31:0]    c_i,
    output logic           valid_o,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  // Total order of numbers, -0 below +0: a below b, from the signs and the magnitudes.
  function automatic logic orders_below(input logic [31:0] a, input logic [31:0] b);
    if (a[31] != b[31]) orders_below = a[31];
    else orders_below = (a[30:0] != b[30:0]) && ((a[30:0] < b[30:0]) != a[31]);
  endfunction

  logic a_nan, b_nan, c_nan, ab_nan, any_nan, a_snan, ab_snan, any_snan;
  logic a_zero, b_zero, c_zero, ab_zero;
  logic a_first, ab_less, ab_equal, above, exchanged;

  assign a_nan    = fp_pkg::is_nan(a_i);
  assign b_nan    = fp_pkg::is_nan(b_i);
  assign c_nan    = fp_pkg::is_nan(c_i);
  assign ab_nan   = a_nan || b_nan;
  assign any_nan  = ab_nan || c_nan;
  assign a_snan   = fp_pkg::is_snan(a_i);
  assign ab_snan  = a_snan || fp_pkg::is_snan(b_i);
  assign any_snan = ab_snan || fp_pkg::is_snan(c_i);
  assign a_zero   = fp_pkg::is_zero(a_i);
  assign b_zero   = fp_pkg::is_zero(b_i);
  assign c_zero   = fp_pkg::is_zero(c_i);

  assign ab_zero   = a_zero && b_zero;
  assign a_first   = orders_below(a_i, b_i);
  assign ab_less   = a_first && !ab_zero;
  assign ab_equal  = (a_i == b_i) || ab_zero;
  assign above     = orders_below(c_i, a_i) && !(a_zero && c_zero);   // SAT: a > c
  assign exchanged = orders_below(c_i, b_i) && !(b_zero && c_zero);   // SAT: c < b

  logic        subtract;
  logic [31:0] integer_sum;
  assign subtract    = op_i[1];          // tells ISUB from IADD
  assign integer_sum = a_i + (b_i ^ {32{subtract}}) + {31'd0, subtract};

  // The result is `other`, known without any comparison, unless one of the conditions replaces it.
  logic [31:0] other, result;
  logic        take_b, take_c, take_one, take_nan, invalid;

  always_comb begin
    other    = a_i;
    take_b   = 1'b0;
    take_c   = 1'b0;
    take_one = 1'b0;
    take_nan = 1'b0;
    invalid  = 1'b0;
    case (op_i)
      fp_pkg::FP_CMP_EQ: begin
        other    = 32'd0;
        take_one = !ab_nan && ab_equal;
        invalid  = ab_snan;
      end
      fp_pkg::FP_CMP_LT: begin
        other    = 32'd0;
        take_one = !ab_nan && ab_less;
        invalid  = ab_nan;
      end
      fp_pkg::FP_CMP_LE: begin
        other    = 32'd0;
        take_one = !ab_nan && (ab_less || ab_equal);
        invalid  = ab_nan;
      end
      fp_pkg::FP_CMP_MIN: begin
        take_b   = a_nan || (!a_first && !b_nan);
        take_nan = a_nan && b_nan;
        invalid  = ab_snan;
      end
      fp_pkg::FP_CMP_MAX: begin
        take_b   = a_nan || (a_first && !b_nan);
        take_nan = a_nan && b_nan;
        invalid  = ab_snan;
      end
      fp_pkg::FP_CMP_ABS: other[31] = 1'b0;
      fp_pkg::FP_CMP_NEG: other[31] = !a_i[31];
      fp_pkg::FP_CMP_SGN: begin
        other    = a_zero ? 32'd0 : {a_i[31], fp_pkg::ONE[30:0]};
        take_nan = a_nan;
        invalid  = a_snan;
      end
      fp_pkg::FP_CMP_SAT: begin
        take_b   = ab_less;
        take_c   = above;
        take_nan = any_nan || exchanged;
        invalid  = any_snan || (exchanged && !any_nan);
      end
      fp_pkg::FP_CMP_SEL:   other = (!a_nan && !a_zero) ? b_i : c_i;
      fp_pkg::FP_CMP_SELGE: other = (!a_nan && (!a_i[31] || a_zero)) ? b_i : c_i;
      fp_pkg::FP_CMP_SELGT: other = (!a_nan && !a_i[31] && !a_zero) ? b_i : c_i;
      fp_pkg::FP_CMP_IADD, fp_pkg::FP_CMP_ISUB: other = integer_sum;
      default: ;  // MOV
    endcase
    result = take_b ? b_i : take_c ? c_i : other;
    if (take_one) result = fp_pkg::ONE;
    if (take_nan) result = fp_pkg::CANON_NAN;
  end

  always_ff @(posedge clk_i) begin
    result_o <= result;
    flags_o  <= {invalid, 4'b0000};
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) valid_o <= 1'b0;
    else valid_o <= valid_i;
  end

endmodule
