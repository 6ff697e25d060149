// SPDX-License-Identifier: Apache-2.0
// asip_check: whether a decoded operation may issue. Combinational.
// Contract: illegal_o is set for what the decoder found illegal, a bank or index that does not exist, and
// an output as the destination of a multiply-add; the issue logic never starts an illegal operation.
// The register of a stream is there in the slot of its pipe alone, a loop of a level that the core has.
module asip_check #(
    parameter int unsigned FmaPipes = 2,
    parameter int unsigned Slot     = 0,
    parameter bit          Streams  = 1'b0,
    parameter int unsigned Loops    = 0,
    parameter int unsigned Lanes    = 0
) (
    input  asip_pkg::decoded_t op_i,
    output logic               illegal_o
);

  localparam int unsigned LastLevel = Loops == 0 ? 0 : Loops - 1;

  function automatic logic bad_source(input logic [8:0] source);
    case (source[8:6])
      asip_isa_pkg::BANK_ZERO: bad_source = |source[5:0];
      asip_isa_pkg::BANK_A, asip_isa_pkg::BANK_C: bad_source = 1'b0;
      asip_isa_pkg::BANK_B: bad_source = (FmaPipes < 2);
      asip_isa_pkg::BANK_K, asip_isa_pkg::BANK_K | 3'd1: bad_source = 1'b0;
      asip_isa_pkg::BANK_S: bad_source = !Streams || Slot >= FmaPipes || 32'(source[5:0]) != Slot;
      default: bad_source = 1'b1;
    endcase
  endfunction

  // A vector operation multiplies words of its stream, and adds registers of its own bank, unless it takes every
  // operand there is; of these a limit applies to a vector, as does the power of two. Field b of one that takes a lane is
  // the lane.
  localparam logic [2:0] Own = Slot == 0 ? asip_isa_pkg::BANK_A : asip_isa_pkg::BANK_B;
  logic bad_b, bad_vector;

  generate
    if (Lanes != 0) begin : gen_vector
      logic foreign, streams, unlimited, unscaled, bad_lane;
      assign foreign    = op_i.c[8:6] != Own && op_i.c[8:6] != asip_isa_pkg::BANK_ZERO;
      assign streams    = op_i.a[8:6] == asip_isa_pkg::BANK_S;
      assign unlimited  = (op_i.below || op_i.above) && !streams && op_i.a[8:6] != Own;
      assign unscaled   = op_i.power && op_i.b[8:6] != Own;
      assign bad_vector = op_i.lanes && (op_i.every ? unlimited || unscaled : foreign || (!op_i.pick && !streams));
      assign bad_lane   = op_i.b[8:6] != asip_isa_pkg::BANK_ZERO || 32'(op_i.b[5:0]) > Lanes;
      assign bad_b      = op_i.pick ? bad_lane : bad_source(op_i.b);
    end else begin : gen_no_vector
      assign bad_vector = 1'b0;
      assign bad_b      = bad_source(op_i.b);
    end
  endgenerate

  // verilog_format: off - it breaks calls inside their parentheses
  assign illegal_o = op_i.illegal || bad_source(op_i.a) || bad_b || bad_vector ||
                     bad_source(op_i.c) || (op_i.to_output && (op_i.fma || op_i.dst[5])) ||
                     (op_i.loop && 32'(op_i.imm[15:asip_isa_pkg::LOOP_COUNT_WIDTH]) > LastLevel);
  // verilog_format: on

  logic unused_op;
  assign unused_op = ^op_i;

endmodule
