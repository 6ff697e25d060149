// SPDX-License-Identifier: Apache-2.0
// fp_pkg: IEEE 754-2019 binary32 types, constants and the latencies of the arithmetic units.
// Contract of every unit: round to nearest even, subnormals in and out at full speed, tininess
// detected after rounding, canonical quiet NaN out, signalling NaN raises nv. A latency of L means:
// operands sampled at clock edge t give a registered result after edge t + L - 1 (L register ranks).
// The latencies are the only copy: asip_asm reads them from this file for its machine description.
package fp_pkg;

  // These are the constants of all units, and each unit uses a few of them.
  // verilator lint_off UNUSEDPARAM

  // Exception flags, same order everywhere.
  typedef struct packed {
    logic nv;  // invalid operation
    logic dz;  // division by zero
    logic of;  // overflow
    logic uf;  // underflow (tiny after rounding and inexact)
    logic nx;  // inexact
  } flags_t;

  localparam logic [31:0] CANON_NAN = 32'h7fc0_0000;
  localparam logic [31:0] PLUS_INF = 32'h7f80_0000;
  localparam logic [31:0] ONE = 32'h3f80_0000;

  localparam int unsigned FP_ADD_LATENCY = 4;
  localparam int unsigned FP_MUL_LATENCY = 4;
  localparam int unsigned FP_FMA_LATENCY = 6;
  localparam int unsigned FP_DIVSQRT_LATENCY = 16;
  localparam int unsigned FP_I2F_LATENCY = 3;
  localparam int unsigned FP_F2I_LATENCY = 2;
  localparam int unsigned FP_CMP_LATENCY = 2;
  localparam int unsigned FP_SINCOS_LATENCY = 36;

  // kind_i of fp_fma.
  localparam logic [1:0] FMA_KIND_FMA = 2'b00;  // +-(a*b) +- c
  localparam logic [1:0] FMA_KIND_MUL = 2'b01;  // +-(a*b); ignores c_i and neg_addend_i
  localparam logic [1:0] FMA_KIND_ADD = 2'b10;  // +-a +- c; ignores b_i

  // Operation of fp_cmp: result from operands a, b, c. "sNaN": a signalling NaN among the compared.
  localparam logic [3:0] FP_CMP_EQ = 4'd0;      // a = b ? 1.0 : 0.0; nv on sNaN
  localparam logic [3:0] FP_CMP_LT = 4'd1;      // a < b ? 1.0 : 0.0; nv on any NaN
  localparam logic [3:0] FP_CMP_LE = 4'd2;      // a <= b ? 1.0 : 0.0; nv on any NaN
  localparam logic [3:0] FP_CMP_MIN = 4'd3;     // minimumNumber(a, b), -0 < +0; nv on sNaN
  localparam logic [3:0] FP_CMP_MAX = 4'd4;     // maximumNumber(a, b), -0 < +0; nv on sNaN
  localparam logic [3:0] FP_CMP_ABS = 4'd5;     // a with sign 0, NaN payload kept; never nv
  localparam logic [3:0] FP_CMP_NEG = 4'd6;     // a with sign inverted, NaN payload kept; never nv
  localparam logic [3:0] FP_CMP_MOV = 4'd7;     // a, bit for bit; never nv
  localparam logic [3:0] FP_CMP_SGN = 4'd8;     // -1.0, +0.0 (for either zero), 1.0; nv on sNaN
  // a < b ? b : a > c ? c : a. A NaN operand gives NaN, nv on sNaN; limits b > c give NaN and nv.
  localparam logic [3:0] FP_CMP_SAT = 4'd9;
  // Selections of b or c bit for bit, never nv; a NaN condition selects c.
  localparam logic [3:0] FP_CMP_SEL = 4'd10;    // a != 0 ? b : c
  localparam logic [3:0] FP_CMP_SELGE = 4'd11;  // a >= 0 ? b : c
  localparam logic [3:0] FP_CMP_SELGT = 4'd12;  // a > 0 ? b : c
  // 32-bit integers modulo 2^32; never nv.
  localparam logic [3:0] FP_CMP_IADD = 4'd13;   // a + b
  localparam logic [3:0] FP_CMP_ISUB = 4'd14;   // a - b

  // verilator lint_on UNUSEDPARAM
  // The class of a number does not depend on its sign.
  // verilator lint_off UNUSEDSIGNAL

  function automatic logic is_nan(input logic [31:0] x);
    is_nan = (&x[30:23]) && (|x[22:0]);
  endfunction

  function automatic logic is_snan(input logic [31:0] x);
    is_snan = (&x[30:23]) && !x[22] && (|x[21:0]);
  endfunction

  function automatic logic is_inf(input logic [31:0] x);
    is_inf = (&x[30:23]) && !(|x[22:0]);
  endfunction

  function automatic logic is_zero(input logic [31:0] x);
    is_zero = !(|x[30:0]);
  endfunction

  // verilator lint_on UNUSEDSIGNAL

endpackage
