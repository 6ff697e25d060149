// SPDX-License-Identifier: Apache-2.0
// n2_alu: adder, logic and comparison of stage E. Combinational.
// Contract: condition_o is the comparison selected by equal_i, signed_i, invert_i, for compare
// instructions and branches; it needs subtract_i. The adder is apart from the other results
// because it is the slowest of them: one selection after it.
module n2_alu (
    input  logic [31:0]     a_i,
    input  logic [31:0]     b_i,
    input  logic            subtract_i,
    input  n2_pkg::logic_e  logic_op_i,
    input  logic            equal_i,
    input  logic            signed_i,
    input  logic            invert_i,
    output logic [31:0]     sum_o,
    output logic [31:0]     logic_o,
    output logic            condition_o
);

  logic [31:0] addend;
  logic carry, equal, less;

  assign addend = b_i ^ {32{subtract_i}};
  assign {carry, sum_o} = {1'b0, a_i} + {1'b0, addend} + {32'd0, subtract_i};

  assign equal = a_i == b_i;
  assign less  = signed_i && a_i[31] != b_i[31] ? a_i[31] : !carry;
  assign condition_o = (equal_i ? equal : less) != invert_i;

  always_comb begin
    case (logic_op_i)
      n2_pkg::LgAnd: logic_o = a_i & b_i;
      n2_pkg::LgOr:  logic_o = a_i | b_i;
      n2_pkg::LgXor: logic_o = a_i ^ b_i;
      default:       logic_o = ~(a_i | b_i);
    endcase
  end

endmodule
