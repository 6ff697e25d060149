// SPDX-License-Identifier: Apache-2.0
// asip_decode: decode one operation word. Combinational.
// Contract: illegal is set for an unknown opcode and for a unit that this slot does not have; a seek is
// unknown without streams, a loop without loops, a vector
// without lanes. asip_check looks at registers and levels. A source field that an operation does not use is `zero` in every program of
// the assembler; another register there is waited for, and one that does not exist is illegal too.
module asip_decode #(
    parameter bit CanFma = 1'b1,
    parameter bit CanAux = 1'b1,
    parameter bit CanSeek = 1'b0,
    parameter bit CanLoop = 1'b0,
    parameter bit CanLane = 1'b0
) (
    input  logic [asip_isa_pkg::OP_WIDTH-1:0] word_i,
    output asip_pkg::decoded_t                op_o
);

  logic [5:0] opcode;
  logic [6:0] dst;
  logic [8:0] a, b, c;
  logic is_fma, is_aux, immediate, known;
  logic [asip_pkg::CONTROL_WIDTH-1:0] control, offered;
  asip_pkg::decoded_t op;

  // The control fields of each opcode are those of its record in asip_asm/isa.toml.
  assign control = asip_pkg::control_of(opcode) | (CanLane ? asip_pkg::lanes_control_of(opcode) : '0);
  assign offered = control & (CanSeek ? '1 : ~asip_pkg::CONTROL_SEEK) & (CanLoop ? '1 : ~asip_pkg::CONTROL_LOOP);
  assign opcode = word_i[asip_isa_pkg::FIELD_OP_MSB:asip_isa_pkg::FIELD_OP_LSB];
  assign dst    = word_i[asip_isa_pkg::FIELD_DST_MSB:asip_isa_pkg::FIELD_DST_LSB];
  assign a      = word_i[asip_isa_pkg::FIELD_A_MSB:asip_isa_pkg::FIELD_A_LSB];
  assign b      = word_i[asip_isa_pkg::FIELD_B_MSB:asip_isa_pkg::FIELD_B_LSB];
  assign c      = word_i[asip_isa_pkg::FIELD_C_MSB:asip_isa_pkg::FIELD_C_LSB];

  always_comb begin
    op = {offered, {(asip_pkg::DECODED_WIDTH - asip_pkg::CONTROL_WIDTH) {1'b0}}};
    if (CanLane) begin
      op.fma      = op.fma || op.lanes;
      op.fma_kind = op.fma_kind | op.lanes_kind;
    end
    known     = (|offered) || opcode == asip_isa_pkg::OP_NOP;
    op.dst    = dst[5:0];
    op.a      = a;
    op.b      = b;
    op.c      = c;
    op.imm    = {dst, c};

    is_fma    = op.fma;
    is_aux    = (|offered) && !op.fma;
    immediate = op.load || op.store || op.jump || op.branch_zero || op.branch_nonzero || op.seek || op.loop;
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
