// SPDX-License-Identifier: Apache-2.0
// n2_decode: instruction word to control signals. Combinational, stage D.
// Contract: the unconditional transfers br, call, jmpi are done by the fetch unit and leave
// only their link here. An interrupt or a debugger's break replaces the instruction by a fault. A call or jmpi whose target is
// outside the instruction memory is a fault with the cause of a bad target.
module n2_decode #(
    parameter logic [255:0] CiCombinational = 256'd0,
    parameter int unsigned HardwareMultiply = 1,
    parameter int unsigned HardwareDivide = 1
) (
    input  logic [26:0]     instruction_i,     // all but field a
    input  logic            interrupt_i,
    input  logic            break_i,           // a break instead of the instruction, before an interrupt
    input  logic            target_outside_i,  // of a call or jmpi
    output n2_pkg::decoded_t decoded_o
);

  logic [5:0] op, opx;
  logic [4:0] b, c;
  logic combinational, absolute;

  assign op  = instruction_i[5:0];
  assign opx = instruction_i[16:11];
  assign b   = instruction_i[26:22];
  assign c   = instruction_i[21:17];
  assign combinational = CiCombinational[instruction_i[13:6]];

  assign absolute = n2_pkg::is_absolute(op);

  logic legal, unimplemented, write;
  logic [4:0] dst;
  n2_pkg::decoded_t d;

  always_comb begin
    d = '0;
    d.immediate = n2_pkg::ImRegister;
    d.result = n2_pkg::RsAdd;
    d.logic_op = n2_pkg::LgAnd;
    legal = 1'b1;
    unimplemented = 1'b0;
    write = 1'b0;
    dst = b;

    case (op)
      n2_isa_pkg::OP_ADDI: begin
        d.read_a = 1'b1;
        write = 1'b1;
        d.immediate = n2_pkg::ImSigned;
      end
      n2_isa_pkg::OP_ANDI, n2_isa_pkg::OP_ORI, n2_isa_pkg::OP_XORI,
      n2_isa_pkg::OP_ANDHI, n2_isa_pkg::OP_ORHI, n2_isa_pkg::OP_XORHI: begin
        d.read_a = 1'b1;
        write = 1'b1;
        d.result = n2_pkg::RsLogic;
        // op[5] marks the high forms, op[4:3] the function.
        d.immediate = op[5] ? n2_pkg::ImHigh : n2_pkg::ImUnsigned;
        d.logic_op = op[4:3] == 2'b01 ? n2_pkg::LgAnd :
                     op[4:3] == 2'b10 ? n2_pkg::LgOr : n2_pkg::LgXor;
      end
      n2_isa_pkg::OP_CMPEQI, n2_isa_pkg::OP_CMPNEI, n2_isa_pkg::OP_CMPGEI, n2_isa_pkg::OP_CMPLTI: begin
        d.read_a = 1'b1;
        write = 1'b1;
        d.immediate = n2_pkg::ImSigned;
        d.result = n2_pkg::RsCompare;
      end
      n2_isa_pkg::OP_CMPGEUI, n2_isa_pkg::OP_CMPLTUI: begin
        d.read_a = 1'b1;
        write = 1'b1;
        d.immediate = n2_pkg::ImUnsigned;
        d.result = n2_pkg::RsCompare;
      end
      n2_isa_pkg::OP_MULI: begin
        d.read_a = 1'b1;
        write = 1'b1;
        d.immediate = n2_pkg::ImSigned;
        d.mul = 1'b1;
        d.late = 1'b1;
        unimplemented = HardwareMultiply == 0;
      end
      n2_isa_pkg::OP_LDW, n2_isa_pkg::OP_LDH, n2_isa_pkg::OP_LDHU, n2_isa_pkg::OP_LDB,
      n2_isa_pkg::OP_LDBU, n2_isa_pkg::OP_LDWIO, n2_isa_pkg::OP_LDHIO, n2_isa_pkg::OP_LDHUIO,
      n2_isa_pkg::OP_LDBIO, n2_isa_pkg::OP_LDBUIO: begin
        d.read_a = 1'b1;
        write = 1'b1;
        d.load = 1'b1;
        d.late = 1'b1;
        d.result = n2_pkg::RsNext;
      end
      n2_isa_pkg::OP_STW, n2_isa_pkg::OP_STH, n2_isa_pkg::OP_STB,
      n2_isa_pkg::OP_STWIO, n2_isa_pkg::OP_STHIO, n2_isa_pkg::OP_STBIO: begin
        d.read_a = 1'b1;
        d.read_b = 1'b1;
        d.store = 1'b1;
        d.result = n2_pkg::RsNext;
      end
      n2_isa_pkg::OP_BEQ, n2_isa_pkg::OP_BNE, n2_isa_pkg::OP_BGE,
      n2_isa_pkg::OP_BLT, n2_isa_pkg::OP_BGEU, n2_isa_pkg::OP_BLTU: begin
        d.read_a = 1'b1;
        d.read_b = 1'b1;
        d.branch = 1'b1;
      end
      n2_isa_pkg::OP_BR, n2_isa_pkg::OP_JMPI: d.result = n2_pkg::RsNext;
      n2_isa_pkg::OP_CALL: begin
        write = 1'b1; dst = n2_isa_pkg::REG_RA; d.result = n2_pkg::RsNext;
      end
      n2_isa_pkg::OP_INITD, n2_isa_pkg::OP_INITDA, n2_isa_pkg::OP_FLUSHD,
      n2_isa_pkg::OP_FLUSHDA: legal = 1'b1;
      n2_isa_pkg::OP_CUSTOM: begin
        dst = c;
        d.read_a = instruction_i[16]; d.read_b = instruction_i[15]; write = instruction_i[14];
        d.ci_multi = !combinational; d.late = !combinational;
        d.result = n2_pkg::RsCustom;
      end
      n2_isa_pkg::OP_R: begin
        dst = c;
        case (opx)
          n2_isa_pkg::OPX_ADD, n2_isa_pkg::OPX_SUB: begin
            d.read_a = 1'b1; d.read_b = 1'b1; write = 1'b1;
          end
          n2_isa_pkg::OPX_AND, n2_isa_pkg::OPX_OR, n2_isa_pkg::OPX_XOR, n2_isa_pkg::OPX_NOR: begin
            d.read_a = 1'b1; d.read_b = 1'b1; write = 1'b1; d.result = n2_pkg::RsLogic;
            d.logic_op = opx[4:3] == 2'b01 ? n2_pkg::LgAnd : opx[4:3] == 2'b10 ? n2_pkg::LgOr :
                         opx[4:3] == 2'b11 ? n2_pkg::LgXor : n2_pkg::LgNor;
          end
          n2_isa_pkg::OPX_CMPEQ, n2_isa_pkg::OPX_CMPNE, n2_isa_pkg::OPX_CMPGE,
          n2_isa_pkg::OPX_CMPLT, n2_isa_pkg::OPX_CMPGEU, n2_isa_pkg::OPX_CMPLTU: begin
            d.read_a = 1'b1; d.read_b = 1'b1; write = 1'b1; d.result = n2_pkg::RsCompare;
          end
          n2_isa_pkg::OPX_SLL, n2_isa_pkg::OPX_SRL, n2_isa_pkg::OPX_SRA,
          n2_isa_pkg::OPX_ROL, n2_isa_pkg::OPX_ROR: begin
            d.read_a = 1'b1; d.read_b = 1'b1; write = 1'b1; d.shift = 1'b1; d.late = 1'b1;
          end
          n2_isa_pkg::OPX_SLLI, n2_isa_pkg::OPX_SRLI, n2_isa_pkg::OPX_SRAI,
          n2_isa_pkg::OPX_ROLI: begin
            d.read_a = 1'b1; write = 1'b1; d.immediate = n2_pkg::ImShift;
            d.shift = 1'b1; d.late = 1'b1;
          end
          n2_isa_pkg::OPX_MUL, n2_isa_pkg::OPX_MULXSS, n2_isa_pkg::OPX_MULXSU,
          n2_isa_pkg::OPX_MULXUU: begin
            d.read_a = 1'b1; d.read_b = 1'b1; write = 1'b1; d.mul = 1'b1; d.late = 1'b1;
            d.mul_high = opx != n2_isa_pkg::OPX_MUL;
            d.mul_signed_a = opx != n2_isa_pkg::OPX_MULXUU;
            d.mul_signed_b = opx == n2_isa_pkg::OPX_MULXSS;
            unimplemented = HardwareMultiply == 0;
          end
          n2_isa_pkg::OPX_DIV, n2_isa_pkg::OPX_DIVU: begin
            d.read_a = 1'b1; d.read_b = 1'b1; write = 1'b1; d.div = 1'b1; d.late = 1'b1;
            d.div_signed = opx == n2_isa_pkg::OPX_DIV;
            d.result = n2_pkg::RsNext;
            unimplemented = HardwareDivide == 0;
          end
          n2_isa_pkg::OPX_CALLR: begin
            d.read_a = 1'b1; write = 1'b1; dst = n2_isa_pkg::REG_RA;
            d.jump = 1'b1; d.result = n2_pkg::RsNext;
          end
          n2_isa_pkg::OPX_JMP, n2_isa_pkg::OPX_RET: begin
            d.read_a = 1'b1; d.jump = 1'b1; d.result = n2_pkg::RsNext;
          end
          n2_isa_pkg::OPX_NEXTPC: begin
            write = 1'b1; d.result = n2_pkg::RsNext;
          end
          n2_isa_pkg::OPX_ERET, n2_isa_pkg::OPX_BRET: begin
            d.read_a = 1'b1; d.leave = 1'b1; d.leave_break = opx == n2_isa_pkg::OPX_BRET;
            d.result = n2_pkg::RsNext;
          end
          n2_isa_pkg::OPX_RDCTL: begin
            write = 1'b1; d.rdctl = 1'b1; d.late = 1'b1;
          end
          n2_isa_pkg::OPX_WRCTL: begin
            d.read_a = 1'b1; d.wrctl = 1'b1; d.flush = 1'b1;
          end
          n2_isa_pkg::OPX_FLUSHP: d.flush = 1'b1;
          n2_isa_pkg::OPX_FLUSHI, n2_isa_pkg::OPX_INITI, n2_isa_pkg::OPX_SYNC: legal = 1'b1;
          n2_isa_pkg::OPX_TRAP, n2_isa_pkg::OPX_BREAK: legal = 1'b1;
          default: legal = 1'b0;
        endcase
      end
      default: legal = 1'b0;
    endcase

    // Comparisons and branches share their code: bits 5:3 of the opcode or of its extension.
    case (op == n2_isa_pkg::OP_R ? opx[5:3] : op[5:3])
      3'b001: {d.compare_equal, d.compare_signed, d.compare_invert} = 3'b011;  // ge
      3'b010: {d.compare_equal, d.compare_signed, d.compare_invert} = 3'b010;  // lt
      3'b011: {d.compare_equal, d.compare_signed, d.compare_invert} = 3'b101;  // ne
      3'b100: {d.compare_equal, d.compare_signed, d.compare_invert} = 3'b100;  // eq
      3'b101: {d.compare_equal, d.compare_signed, d.compare_invert} = 3'b001;  // geu
      default: {d.compare_equal, d.compare_signed, d.compare_invert} = 3'b000; // ltu
    endcase
    d.subtract = d.branch || d.result == n2_pkg::RsCompare ||
                 (op == n2_isa_pkg::OP_R && opx == n2_isa_pkg::OPX_SUB);
    // Shifts: bit 3 of the extension is right, bits 5:4 are 00 rotate, 01 zeros, 11 sign.
    d.shift_right  = opx[3];
    d.shift_rotate = opx[5:4] == 2'b00;
    d.shift_sign   = opx[5];
    // Loads and stores: bits 4:3 are the size, bit 2 the sign of loads.
    d.size = {op[4], op[3]};
    d.load_signed = op[2];

    d.dst   = dst;
    d.write = write && dst != 5'd0;

    // An instruction that is a fault by itself has none of these effects, so that they need not wait
    // until that is known.
    if (break_i || interrupt_i || unimplemented) begin
      d.read_a = 1'b0;
      d.read_b = 1'b0;
      d.late   = 1'b0;
      d.branch = 1'b0;
      d.jump   = 1'b0;
      d.shift  = 1'b0;
      d.mul    = 1'b0;
      d.div    = 1'b0;
      d.load   = 1'b0;
      d.store  = 1'b0;
      d.ci_multi = 1'b0;
      d.leave  = 1'b0;
      d.flush  = 1'b0;
      d.rdctl  = 1'b0;
      d.wrctl  = 1'b0;
    end

    if (break_i || interrupt_i || !legal || unimplemented || (absolute && target_outside_i) ||
        (op == n2_isa_pkg::OP_R &&
         (opx == n2_isa_pkg::OPX_TRAP || opx == n2_isa_pkg::OPX_BREAK))) begin
      d.result = n2_pkg::RsNext;
      d.fault  = 1'b1;
      d.write  = 1'b1;
      d.dst    = n2_isa_pkg::REG_EA;
      if (break_i) begin
        d.breakpoint = 1'b1;
        d.dst = n2_isa_pkg::REG_BA;
      end else if (interrupt_i) d.cause = n2_isa_pkg::CAUSE_INTERRUPT;
      else if (!legal) d.cause = n2_isa_pkg::CAUSE_ILLEGAL;
      else if (unimplemented) d.cause = n2_isa_pkg::CAUSE_UNIMPLEMENTED;
      else if (absolute) d.cause = n2_isa_pkg::CAUSE_TARGET_ADDRESS;
      else if (opx == n2_isa_pkg::OPX_TRAP) d.cause = n2_isa_pkg::CAUSE_TRAP;
      else begin
        d.breakpoint = 1'b1;
        d.dst = n2_isa_pkg::REG_BA;
      end
    end
  end

  assign decoded_o = d;

endmodule
