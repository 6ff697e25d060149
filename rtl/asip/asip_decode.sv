// SPDX-License-Identifier: Apache-2.0
// asip_decode: decode one operation word. Combinational.
// Contract: illegal is set for an unknown opcode and for a unit that this slot does not have; asip_check
// looks at the registers. A source field that an operation does not use is `zero` in every program of
// the assembler; another register there is waited for, and one that does not exist is illegal too.
module asip_decode #(
    parameter bit CanFma = 1'b1,
    parameter bit CanAux = 1'b1
) (
    input  logic [asip_isa_pkg::OP_WIDTH-1:0] word_i,
    output asip_pkg::decoded_t                op_o
);

  logic [5:0]  opcode;
  logic [6:0]  dst;
  logic [8:0]  a, b, c;
  logic        is_fma, is_aux, immediate, known;
  asip_pkg::decoded_t op;

  assign opcode = word_i[asip_isa_pkg::FIELD_OP_MSB:asip_isa_pkg::FIELD_OP_LSB];
  assign dst    = word_i[asip_isa_pkg::FIELD_DST_MSB:asip_isa_pkg::FIELD_DST_LSB];
  assign a      = word_i[asip_isa_pkg::FIELD_A_MSB:asip_isa_pkg::FIELD_A_LSB];
  assign b      = word_i[asip_isa_pkg::FIELD_B_MSB:asip_isa_pkg::FIELD_B_LSB];
  assign c      = word_i[asip_isa_pkg::FIELD_C_MSB:asip_isa_pkg::FIELD_C_LSB];

  always_comb begin
    op        = '0;
    known     = 1'b1;
    immediate = 1'b0;
    op.dst    = dst[5:0];
    op.a      = a;
    op.b      = b;
    op.c      = c;
    op.imm    = {dst, c};
    case (opcode)
      asip_isa_pkg::OP_NOP: op.illegal = 1'b0;
      asip_isa_pkg::OP_JMP: op.jump = 1'b1;
      asip_isa_pkg::OP_BZ: op.branch_zero = 1'b1;
      asip_isa_pkg::OP_BNZ: op.branch_nonzero = 1'b1;
      asip_isa_pkg::OP_ST: op.store = 1'b1;
      asip_isa_pkg::OP_LD: op.load = 1'b1;
      asip_isa_pkg::OP_FMADD, asip_isa_pkg::OP_FMSUB,
      asip_isa_pkg::OP_FNMSUB, asip_isa_pkg::OP_FNMADD: begin
        op.fma         = 1'b1;
        op.fma_kind    = fp_pkg::FMA_KIND_FMA;
        op.neg_addend  = opcode[1];
        op.neg_product = opcode[0];
      end
      asip_isa_pkg::OP_FMUL, asip_isa_pkg::OP_FNMUL: begin
        op.fma         = 1'b1;
        op.fma_kind    = fp_pkg::FMA_KIND_MUL;
        op.neg_product = opcode[0];
      end
      asip_isa_pkg::OP_FADD, asip_isa_pkg::OP_FSUB: begin
        op.fma        = 1'b1;
        op.fma_kind   = fp_pkg::FMA_KIND_ADD;
        op.neg_addend = opcode[1];
      end
      asip_isa_pkg::OP_FEQ: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_EQ; end
      asip_isa_pkg::OP_FLT: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_LT; end
      asip_isa_pkg::OP_FLE: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_LE; end
      asip_isa_pkg::OP_FMIN: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_MIN; end
      asip_isa_pkg::OP_FMAX: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_MAX; end
      asip_isa_pkg::OP_FABS: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_ABS; end
      asip_isa_pkg::OP_FNEG: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_NEG; end
      asip_isa_pkg::OP_MOV: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_MOV; end
      asip_isa_pkg::OP_FSGN: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_SGN; end
      asip_isa_pkg::OP_FSAT: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_SAT; end
      asip_isa_pkg::OP_SEL: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_SEL; end
      asip_isa_pkg::OP_SELGE: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_SELGE; end
      asip_isa_pkg::OP_SELGT: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_SELGT; end
      asip_isa_pkg::OP_IADD: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_IADD; end
      asip_isa_pkg::OP_ISUB: begin op.cmp = 1'b1; op.cmp_op = fp_pkg::FP_CMP_ISUB; end
      asip_isa_pkg::OP_FDIV: op.divsqrt = 1'b1;
      asip_isa_pkg::OP_FSQRT: begin op.divsqrt = 1'b1; op.sqrt = 1'b1; end
      asip_isa_pkg::OP_FSIN: op.sincos = 1'b1;
      asip_isa_pkg::OP_FCOS: begin op.sincos = 1'b1; op.cos = 1'b1; end
      asip_isa_pkg::OP_I2F: op.i2f = 1'b1;
      asip_isa_pkg::OP_F2I: op.f2i = 1'b1;
      asip_isa_pkg::OP_F2IT: begin op.f2i = 1'b1; op.truncate = 1'b1; end
      default: known = 1'b0;
    endcase

    is_fma    = op.fma;
    is_aux    = op.cmp || op.divsqrt || op.sincos || op.i2f || op.f2i || op.load || op.store ||
                op.jump || op.branch_zero || op.branch_nonzero;
    immediate = op.load || op.store || op.jump || op.branch_zero || op.branch_nonzero;
    op.writes = is_fma || (is_aux && !(immediate && !op.load));
    op.to_output = op.writes && dst[6];
    if (op.load) begin
      op.imm = {a[6:0], c};
      op.a   = '0;
    end
    if (immediate) op.c = '0;

    op.illegal = !known || (is_fma && !CanFma) || (is_aux && !CanAux);
  end

  assign op_o = op;

endmodule
