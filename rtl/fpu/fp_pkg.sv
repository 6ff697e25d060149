// SPDX-License-Identifier: Apache-2.0
// fp_pkg: IEEE 754-2019 binary32 types, constants and the latencies of the arithmetic units.
// Contract of every unit: round to nearest even, subnormals in and out at full speed, tininess
// detected after rounding, canonical quiet NaN out, signalling NaN raises nv. A latency of L means:
// operands sampled at clock edge t give a registered result after edge t + L - 1 (L register ranks).
// The latencies are the only copy: asip_asm reads them from this file for its machine description.
package fp_pkg;

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
  localparam int unsigned FP_DIVSQRT_LATENCY = 15;
  localparam int unsigned FP_I2F_LATENCY = 3;
  localparam int unsigned FP_F2I_LATENCY = 2;
  localparam int unsigned FP_CMP_LATENCY = 1;
  localparam int unsigned FP_SINCOS_LATENCY = 48;

  // Operation of fp_fma. Field order: {negate product, negate addend, kind}.
  localparam logic [1:0] FMA_KIND_FMA = 2'b00;  // +-(a*b) +- c
  localparam logic [1:0] FMA_KIND_MUL = 2'b01;  // a*b, c ignored
  localparam logic [1:0] FMA_KIND_ADD = 2'b10;  // a +- c, b ignored

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

endpackage
