// SPDX-License-Identifier: Apache-2.0
// asip_operands: register banks, constant bank, bypass and operand registers (stages R1, R2).
// Contract: the source fields of stage D, three cycles later, are values in the operand registers (E1);
// early_r2_o are the same values a cycle before, apart from those that late_r2_o marks: these are C's result, which
// comes later in the cycle, and early_r2_o is zero. For a source in its slot's own bank, or the word of its stream,
// own_r2_o is early_r2_o without a result that is in write-back, and fresh_r2_o marks that there is one.
// The banks are read at the end of D, R1 takes what they answer, R2 selects. A result in write-back
// during D, R1 or R2 comes from the bypass instead, decided in D from places 0, 1 and 2 of the write
// schedules. While idle the host reads a register through the first source of the last slot, and
// writes through the write ports; with several slots, without Resilience, it reads two cycles after a write
// at the earliest. Ports = 3 is one slot, with one multiply-add pipe.
module asip_operands #(
    parameter int unsigned FmaPipes   = 2,
    parameter int unsigned Ports      = 9,
    parameter int unsigned Resilience = 0,  // 1: pages of the banks, parity of bank K
    parameter int unsigned StreamWords = 0  // of each stream; 0: there is none
) (
    input  logic                       clk_i,
    // from issue, stage D
    input  logic [Ports-1:0][8:0]      source_d_i,
    // from the write schedules of A, B, C: write-back in two cycles, in the next cycle
    input  logic [2:0]                 soon_i,
    input  logic [2:0][5:0]            soon_index_i,
    input  logic [2:0]                 next_i,
    input  logic [2:0][5:0]            next_index_i,
    // from write-back of A, B, C
    input  logic [2:0]                 write_i,
    input  logic [2:0][5:0]            write_index_i,
    input  logic [2:0][31:0]           write_data_i,
    // from the host, idle only
    input  logic                       host_read_i,
    input  logic                       host_write_i,
    input  logic                       host_write_constant_i,
    input  logic [8:0]                 host_register_i,
    input  logic [31:0]                host_data_i,
    // from the streams of the multiply-add pipes, R1
    input  logic [1:0][31:0]           stream_r1_i,
    // from redundancy; a word of bank K is wrong, with the operands
    input  asip_pkg::guard_t           guard_i,
    output logic                       bad_constant_e1_o,
    // to the units, stages R2 and E1
    output logic [Ports-1:0][31:0]     early_r2_o,
    output logic [Ports-1:0]           late_r2_o,
    output logic [Ports-1:0][31:0]     own_r2_o,
    output logic [Ports-1:0]           fresh_r2_o,
    output logic [Ports-1:0][31:0]     operand_e1_o
);

  // The ports are the same, name by name.
  generate
    if (Ports == 3) begin : gen_single
      asip_operands_single u_operands (.*);
    end else begin : gen_multiple
      asip_operands_multiple #(
          .FmaPipes  (FmaPipes),
          .Ports     (Ports),
          .Resilience(Resilience),
          .StreamWords(StreamWords)
      ) u_operands (
          .*
      );
    end
  endgenerate

endmodule
