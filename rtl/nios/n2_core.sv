// SPDX-License-Identifier: Apache-2.0
// n2_core: Nios II R1 instruction-compatible processor, pipeline F D E M A W, no MMU, no caches.
// Contract: fetches from the instruction memory only; loads and stores inside the two tightly coupled
// memories take one synchronous RAM cycle (rdata valid the cycle after en, held while en is low), every
// other data address goes to the Avalon-MM master. Memory ports carry word addresses. A custom
// instruction n is combinational (ci_combo_*, stage E) where CiCombinational[n] is set, else multicycle
// (ci_multi_*, stage A): start in its first cycle, ended by done, at the earliest in that same cycle.
// Bases are multiples of the (power of two) sizes; vectors lie in the instruction memory.
module n2_core #(
    parameter logic [31:0] ItcmBase = 32'h1000_0000,
    parameter int unsigned ItcmBytes = 65536,
    parameter logic [31:0] DtcmBase = 32'h1004_0000,
    parameter int unsigned DtcmBytes = 65536,
    parameter logic [31:0] ResetVector = 32'h1000_0000,
    parameter logic [31:0] ExceptionVector = 32'h1000_0020,
    parameter logic [31:0] BreakVector = 32'h1000_0020,
    parameter logic [31:0] CpuId = 32'd0,
    parameter logic [255:0] CiCombinational = 256'd0,
    parameter int unsigned HardwareMultiply = 1,
    parameter int unsigned HardwareDivide = 1,
    parameter int unsigned DivisionError = 1,
    parameter int unsigned Trace = 0
) (
    input  logic                        clk_i,
    input  logic                        rst_ni,
    // to the instruction memory, first RAM port: fetch
    output logic                          itcm_en_o,
    output logic [$clog2(ItcmBytes)-3:0]  itcm_address_o,
    input  logic [31:0]                 itcm_rdata_i,
    // to the instruction memory, second RAM port: loads and stores
    output logic                          itcm_data_en_o,
    output logic [3:0]                    itcm_data_we_o,      // per byte
    output logic [$clog2(ItcmBytes)-3:0]  itcm_data_address_o,
    output logic [31:0]                   itcm_data_wdata_o,
    input  logic [31:0]                 itcm_data_rdata_i,
    // to the data memory
    output logic                          dtcm_en_o,
    output logic [3:0]                    dtcm_we_o,           // per byte
    output logic [$clog2(DtcmBytes)-3:0]  dtcm_address_o,
    output logic [31:0]                   dtcm_wdata_o,
    input  logic [31:0]                 dtcm_rdata_i,
    // Avalon-MM data master: readdata is taken in the cycle with read and no waitrequest
    output logic [31:0]                 avm_address_o,       // byte address, multiple of 4
    output logic                        avm_read_o,
    output logic                        avm_write_o,
    output logic [3:0]                  avm_byteenable_o,
    output logic [31:0]                 avm_writedata_o,
    input  logic [31:0]                 avm_readdata_i,
    input  logic                        avm_waitrequest_i,
    // interrupts, level
    input  logic [31:0]                 irq_i,
    // combinational custom instructions, stage E
    output logic [31:0]                 ci_combo_dataa_o,
    output logic [31:0]                 ci_combo_datab_o,
    output logic [7:0]                  ci_combo_n_o,
    output logic                        ci_combo_readra_o,
    output logic                        ci_combo_readrb_o,
    output logic                        ci_combo_writerc_o,
    output logic [4:0]                  ci_combo_a_o,
    output logic [4:0]                  ci_combo_b_o,
    output logic [4:0]                  ci_combo_c_o,
    output logic                        ci_combo_estatus_o,
    output logic [31:0]                 ci_combo_ipending_o,
    input  logic [31:0]                 ci_combo_result_i,
    // multicycle custom instructions, stage A; clock and reset are those of the core
    output logic                        ci_multi_clk_en_o,
    output logic                        ci_multi_start_o,
    output logic [31:0]                 ci_multi_dataa_o,
    output logic [31:0]                 ci_multi_datab_o,
    output logic [7:0]                  ci_multi_n_o,
    output logic                        ci_multi_readra_o,
    output logic                        ci_multi_readrb_o,
    output logic                        ci_multi_writerc_o,
    output logic [4:0]                  ci_multi_a_o,
    output logic [4:0]                  ci_multi_b_o,
    output logic [4:0]                  ci_multi_c_o,
    input  logic                        ci_multi_done_i,
    input  logic [31:0]                 ci_multi_result_i,
    // counters since reset, modulo 2**32: clock cycles, instructions completed without an exception
    output logic [31:0]                 cycles_o,
    output logic [31:0]                 retired_o,
    // trace (Trace = 1): one record per instruction that left stage A, else 0
    output logic                        trace_valid_o,
    output logic [31:0]                 trace_pc_o,
    output logic [31:0]                 trace_instruction_o,
    output logic                        trace_write_o,       // value goes to register dst
    output logic [4:0]                  trace_dst_o,
    output logic [31:0]                 trace_value_o,
    output logic                        trace_exception_o,   // taken instead of (or by) the instruction
    output logic [4:0]                  trace_cause_o
);

  assign {itcm_en_o, itcm_address_o, itcm_data_en_o, itcm_data_we_o, itcm_data_address_o} = '0;
  assign {itcm_data_wdata_o, dtcm_en_o, dtcm_we_o, dtcm_address_o, dtcm_wdata_o} = '0;
  assign {avm_address_o, avm_read_o, avm_write_o, avm_byteenable_o, avm_writedata_o} = '0;
  assign {ci_combo_dataa_o, ci_combo_datab_o, ci_combo_n_o, ci_combo_readra_o} = '0;
  assign {ci_combo_readrb_o, ci_combo_writerc_o, ci_combo_a_o, ci_combo_b_o, ci_combo_c_o} = '0;
  assign {ci_combo_estatus_o, ci_combo_ipending_o} = '0;
  assign {ci_multi_clk_en_o, ci_multi_start_o, ci_multi_dataa_o, ci_multi_datab_o} = '0;
  assign {ci_multi_n_o, ci_multi_readra_o, ci_multi_readrb_o, ci_multi_writerc_o} = '0;
  assign {ci_multi_a_o, ci_multi_b_o, ci_multi_c_o, cycles_o, retired_o} = '0;
  assign {trace_valid_o, trace_pc_o, trace_instruction_o, trace_write_o, trace_dst_o} = '0;
  assign {trace_value_o, trace_exception_o, trace_cause_o} = '0;

endmodule
