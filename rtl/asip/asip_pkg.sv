// SPDX-License-Identifier: Apache-2.0
// asip_pkg: types shared by the blocks of the ASIP.
package asip_pkg;

  // One operation after decoding. Exactly one unit bit is set unless it is a nop or illegal.
  typedef struct packed {
    logic        fma;             // multiply-add pipe
    logic [1:0]  fma_kind;
    logic        neg_product;
    logic        neg_addend;
    logic        cmp;             // compare, select, saturate, move, integer add
    logic [3:0]  cmp_op;
    logic        divsqrt;
    logic        sqrt;
    logic        i2f;
    logic        f2i;
    logic        truncate;
    logic        sincos;
    logic        cos;
    logic        load;
    logic        store;
    logic        jump;
    logic        branch_zero;
    logic        branch_nonzero;
    logic        writes;          // a register or an output
    logic        to_output;
    logic [5:0]  dst;
    logic [8:0]  a;               // {bank, index}
    logic [8:0]  b;
    logic [8:0]  c;
    logic [15:0] imm;
    logic        illegal;
  } decoded_t;
  localparam int unsigned DECODED_WIDTH = 74;  // of decoded_t, as a test checks: Yosys knows no $bits

  // Destination that travels to the write-back stage.
  typedef struct packed {
    logic       to_output;
    logic [5:0] index;
  } tag_t;
  localparam int unsigned TAG_WIDTH = 7;

  // Selection of an operand in stage R2.
  localparam logic [2:0] SELECT_A = 3'd0;
  localparam logic [2:0] SELECT_B = 3'd1;
  localparam logic [2:0] SELECT_C = 3'd2;
  localparam logic [2:0] SELECT_K = 3'd3;
  localparam logic [2:0] SELECT_RESULT_A = 3'd4;
  localparam logic [2:0] SELECT_RESULT_B = 3'd5;
  localparam logic [2:0] SELECT_RESULT_C = 3'd6;
  localparam logic [2:0] SELECT_BYPASS = 3'd7;

endpackage
