// SPDX-License-Identifier: Apache-2.0
// fp_cmp: comparisons, selections, sign operations and 32-bit integer add/subtract, one per clock.
// Contract: latency fp_pkg::FP_CMP_LATENCY register ranks, no stall; op_i is one of
// fp_pkg::FP_CMP_*, where each operation, its NaN rule and its flag are stated; 15 acts as MOV. An
// operation ignores the operands that its line there does not name.
// Values are compared as IEEE 754-2019 numbers (subnormals count, -0 equals +0); no flag but nv.
// Stages: e1 compare, add | e2 select.
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

  // ---- e1: classes, comparisons, and `other`, the result that needs no comparison ----
  logic a_nan_e1, b_nan_e1, c_nan_e1, a_snan_e1, b_snan_e1, c_snan_e1;
  logic a_zero_e1, b_zero_e1, c_zero_e1, ab_zero_e1, a_first_e1;

  assign a_nan_e1   = fp_pkg::is_nan(a_i);
  assign b_nan_e1   = fp_pkg::is_nan(b_i);
  assign c_nan_e1   = fp_pkg::is_nan(c_i);
  assign a_snan_e1  = fp_pkg::is_snan(a_i);
  assign b_snan_e1  = fp_pkg::is_snan(b_i);
  assign c_snan_e1  = fp_pkg::is_snan(c_i);
  assign a_zero_e1  = fp_pkg::is_zero(a_i);
  assign b_zero_e1  = fp_pkg::is_zero(b_i);
  assign c_zero_e1  = fp_pkg::is_zero(c_i);
  assign ab_zero_e1 = a_zero_e1 && b_zero_e1;
  assign a_first_e1 = orders_below(a_i, b_i);

  logic subtract_e1;
  logic [31:0] sum_e1, other_e1;

  assign subtract_e1 = op_i[1];          // ISUB, not IADD
  assign sum_e1      = a_i + (b_i ^ {32{subtract_e1}}) + {31'd0, subtract_e1};

  always_comb begin
    other_e1 = a_i;  // MOV; MIN, MAX, SAT, SEL* unless b or c takes its place
    case (op_i)
      fp_pkg::FP_CMP_EQ, fp_pkg::FP_CMP_LT, fp_pkg::FP_CMP_LE: other_e1 = 32'd0;
      fp_pkg::FP_CMP_ABS:   other_e1[31] = 1'b0;
      fp_pkg::FP_CMP_NEG:   other_e1[31] = !a_i[31];
      fp_pkg::FP_CMP_SGN:   other_e1[30:0] = fp_pkg::ONE[30:0];
      fp_pkg::FP_CMP_IADD, fp_pkg::FP_CMP_ISUB: other_e1 = sum_e1;
      default: ;
    endcase
  end

  logic valid_e1_q;
  logic [3:0] op_e1_q;
  logic [31:0] other_e1_q, b_e1_q, c_e1_q;
  logic a_zero_e1_q, a_negative_e1_q;
  logic a_nan_e1_q, b_nan_e1_q, c_nan_e1_q, a_snan_e1_q, b_snan_e1_q, c_snan_e1_q;
  logic a_first_e1_q, ab_less_e1_q, ab_equal_e1_q;
  logic above_e1_q, exchanged_e1_q;  // SAT: a > c, c < b

  always_ff @(posedge clk_i) begin
    op_e1_q        <= op_i;
    other_e1_q     <= other_e1;
    b_e1_q         <= b_i;
    c_e1_q         <= c_i;
    a_zero_e1_q    <= a_zero_e1;
    a_negative_e1_q <= a_i[31];
    a_nan_e1_q     <= a_nan_e1;
    b_nan_e1_q     <= b_nan_e1;
    c_nan_e1_q     <= c_nan_e1;
    a_snan_e1_q    <= a_snan_e1;
    b_snan_e1_q    <= b_snan_e1;
    c_snan_e1_q    <= c_snan_e1;
    a_first_e1_q   <= a_first_e1;
    ab_less_e1_q   <= a_first_e1 && !ab_zero_e1;
    ab_equal_e1_q  <= (a_i == b_i) || ab_zero_e1;
    above_e1_q     <= orders_below(c_i, a_i) && !(a_zero_e1 && c_zero_e1);
    exchanged_e1_q <= orders_below(c_i, b_i) && !(b_zero_e1 && c_zero_e1);
  end

  // ---- e2: which value, which flag ----
  logic ab_nan_e2, any_nan_e2, ab_snan_e2;
  logic take_b_e2, take_c_e2, take_zero_e2, take_one_e2, take_nan_e2, invalid_e2;
  logic [31:0] result_e2;

  assign ab_nan_e2  = a_nan_e1_q || b_nan_e1_q;
  assign any_nan_e2 = ab_nan_e2 || c_nan_e1_q;
  assign ab_snan_e2 = a_snan_e1_q || b_snan_e1_q;

  always_comb begin
    take_b_e2   = 1'b0;
    take_c_e2   = 1'b0;
    take_zero_e2 = 1'b0;
    take_one_e2 = 1'b0;
    take_nan_e2 = 1'b0;
    invalid_e2  = 1'b0;
    case (op_e1_q)
      fp_pkg::FP_CMP_EQ: begin
        take_one_e2 = !ab_nan_e2 && ab_equal_e1_q;
        invalid_e2  = ab_snan_e2;
      end
      fp_pkg::FP_CMP_LT: begin
        take_one_e2 = !ab_nan_e2 && ab_less_e1_q;
        invalid_e2  = ab_nan_e2;
      end
      fp_pkg::FP_CMP_LE: begin
        take_one_e2 = !ab_nan_e2 && (ab_less_e1_q || ab_equal_e1_q);
        invalid_e2  = ab_nan_e2;
      end
      fp_pkg::FP_CMP_MIN: begin
        take_b_e2   = a_nan_e1_q || (!a_first_e1_q && !b_nan_e1_q);
        take_nan_e2 = a_nan_e1_q && b_nan_e1_q;
        invalid_e2  = ab_snan_e2;
      end
      fp_pkg::FP_CMP_MAX: begin
        take_b_e2   = a_nan_e1_q || (a_first_e1_q && !b_nan_e1_q);
        take_nan_e2 = a_nan_e1_q && b_nan_e1_q;
        invalid_e2  = ab_snan_e2;
      end
      fp_pkg::FP_CMP_SGN: begin
        take_zero_e2 = a_zero_e1_q;
        take_nan_e2 = a_nan_e1_q;
        invalid_e2  = a_snan_e1_q;
      end
      fp_pkg::FP_CMP_SAT: begin
        take_b_e2   = ab_less_e1_q;
        take_c_e2   = above_e1_q;
        take_nan_e2 = any_nan_e2 || exchanged_e1_q;
        invalid_e2  = ab_snan_e2 || c_snan_e1_q || (exchanged_e1_q && !any_nan_e2);
      end
      fp_pkg::FP_CMP_SEL:   take_b_e2 = !a_nan_e1_q && !a_zero_e1_q;
      fp_pkg::FP_CMP_SELGE: take_b_e2 = !a_nan_e1_q && (!a_negative_e1_q || a_zero_e1_q);
      fp_pkg::FP_CMP_SELGT: take_b_e2 = !a_nan_e1_q && !a_negative_e1_q && !a_zero_e1_q;
      default: ;
    endcase
    case (op_e1_q)
      fp_pkg::FP_CMP_SEL, fp_pkg::FP_CMP_SELGE, fp_pkg::FP_CMP_SELGT: take_c_e2 = !take_b_e2;
      default: ;
    endcase
    result_e2 = take_b_e2 ? b_e1_q : take_c_e2 ? c_e1_q : other_e1_q;
    if (take_zero_e2) result_e2 = 32'd0;
    if (take_one_e2) result_e2 = fp_pkg::ONE;
    if (take_nan_e2) result_e2 = fp_pkg::CANON_NAN;
  end

  always_ff @(posedge clk_i) begin
    result_o <= result_e2;
    flags_o  <= {invalid_e2, 4'b0000};
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_e1_q <= 1'b0;
      valid_o    <= 1'b0;
    end else begin
      valid_e1_q <= valid_i;
      valid_o    <= valid_e1_q;
    end
  end

endmodule
