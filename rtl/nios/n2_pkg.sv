// SPDX-License-Identifier: Apache-2.0
// n2_pkg: the decoded instruction that travels down the pipeline of n2_core.
package n2_pkg;

  // What stage E hands to M as result.
  typedef enum logic [2:0] {
    RsAdd     = 3'd0,  // adder, also every instruction whose result comes later
    RsLogic   = 3'd1,
    RsCompare = 3'd2,
    RsNext    = 3'd3,  // address of the next instruction; also everything that can raise an exception
    RsCustom  = 3'd4
  } result_e;

  typedef enum logic [1:0] {
    LgAnd = 2'd0,
    LgOr  = 2'd1,
    LgXor = 2'd2,
    LgNor = 2'd3
  } logic_e;

  // Where the second operand comes from.
  typedef enum logic [2:0] {
    ImRegister = 3'd0,
    ImSigned   = 3'd1,
    ImUnsigned = 3'd2,
    ImHigh     = 3'd3,
    ImShift    = 3'd4   // i5
  } immediate_e;

  // Conditional branches.
  function automatic logic is_branch(input logic [5:0] op);
    is_branch = op == n2_isa_pkg::OP_BEQ || op == n2_isa_pkg::OP_BNE || op == n2_isa_pkg::OP_BGE ||
                op == n2_isa_pkg::OP_BLT || op == n2_isa_pkg::OP_BGEU || op == n2_isa_pkg::OP_BLTU;
  endfunction

  // Transfers to a region of the memory map.
  function automatic logic is_absolute(input logic [5:0] op);
    is_absolute = op == n2_isa_pkg::OP_CALL || op == n2_isa_pkg::OP_JMPI;
  endfunction

  // Transfers without a condition or register.
  function automatic logic is_direct(input logic [5:0] op);
    is_direct = is_absolute(op) || op == n2_isa_pkg::OP_BR;
  endfunction

  typedef struct packed {
    // registers
    logic       read_a;
    logic       read_b;
    logic       write;       // dst is not r0
    logic [4:0] dst;
    logic       late;        // result in stage A, not E
    // E
    immediate_e immediate;
    result_e    result;
    logic       subtract;
    logic_e     logic_op;
    logic       compare_equal;   // else less than
    logic       compare_signed;
    logic       compare_invert;
    logic       branch;      // conditional
    logic       jump;        // to a register
    logic       shift;
    logic       shift_right;
    logic       shift_rotate;
    logic       shift_sign;
    // M and A
    logic       mul;
    logic       mul_high;
    logic       mul_signed_a;
    logic       mul_signed_b;
    logic       div;
    logic       div_signed;
    logic       load;
    logic       store;
    logic [1:0] size;        // 0 byte, 1 half word, 2 word
    logic       load_signed;
    logic       ci_multi;
    // control
    logic       fault;       // exception known in D
    logic [4:0] cause;
    logic       breakpoint;  // break: a fault without a cause
    logic       leave;       // eret, bret
    logic       leave_break; // bret
    logic       flush;       // fetch the next instruction again
    logic       rdctl;
    logic       wrctl;
  } decoded_t;

  // Number of the control register through which a halted core and its debugger exchange a word.
  localparam logic [4:0] CTL_DEBUG = 5'd31;

  // From n2_debug: the next instruction of a halted core is `word` when it is valid.
  typedef struct packed {
    logic        halted;
    logic        valid;
    logic        mask;       // no interrupt now
    logic [31:0] word;
    logic [31:0] data;       // of CTL_DEBUG
  } debug_state_t;

  // To n2_debug: what its comparators look at, word addresses.
  typedef struct packed {
    logic [29:0] next_d;     // after the instruction in D
    logic        access_e;   // a load or store is in E and will complete
    logic        store_e;
    logic [3:0]  lanes_e;
    logic [29:0] data_e;
  } debug_address_t;

  // To n2_debug: what happens in this clock.
  typedef struct packed {
    logic        en;         // the pipeline moves
    logic        issue_d;    // an instruction goes from D to E
    logic        break_m;
    logic        return_m;   // bret
    logic        write_m;    // wrctl of CTL_DEBUG
    logic [31:0] value_m;
  } debug_event_t;

endpackage
