// SPDX-License-Identifier: Apache-2.0
// n2_trace: one record per instruction that leaves stage A of n2_core, completed or by an exception.
// Contract: the record represents one cycle, the one after the instruction has left A.
module n2_trace #(
    parameter int unsigned AddressWidth = 14,
    parameter logic [31:0] PcBase = 32'd0       // upper bits of a program counter
) (
    input  logic                    clk_i,
    input  logic                    rst_ni,
    input  logic                    en_i,       // the pipeline moves
    // from E, M and A
    input  logic [AddressWidth-1:0] next_e_i,   // word address after the instruction
    input  logic [31:0]             word_m_i,
    input  logic [4:0]              cause_m_i,
    input  logic                    valid_a_i,
    input  logic                    write_a_i,
    input  logic                    fault_a_i,
    input  logic [4:0]              dst_a_i,
    input  logic [31:0]             value_a_i,
    // the record
    output logic                    trace_valid_o,
    output logic [31:0]             trace_pc_o,
    output logic [31:0]             trace_instruction_o,
    output logic                    trace_write_o,
    output logic [4:0]              trace_dst_o,
    output logic [31:0]             trace_value_o,
    output logic                    trace_exception_o,
    output logic [4:0]              trace_cause_o
);

  logic [AddressWidth-1:0] next_m_q, next_a_q;
  logic [31:0] word_a_q, pc_w_q, word_w_q, value_w_q;
  logic [4:0] cause_a_q, cause_w_q, dst_w_q;
  logic valid_w_q, write_w_q, fault_w_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) valid_w_q <= 1'b0;
    else valid_w_q <= en_i && valid_a_i;
  end

  always_ff @(posedge clk_i) begin
    if (en_i) begin
      next_m_q  <= next_e_i;
      next_a_q  <= next_m_q;
      word_a_q  <= word_m_i;
      cause_a_q <= cause_m_i;
    end
    pc_w_q    <= PcBase | 32'({next_a_q - 1'b1, 2'b00});
    word_w_q  <= word_a_q;
    write_w_q <= write_a_i;
    dst_w_q   <= dst_a_i;
    value_w_q <= value_a_i;
    fault_w_q <= fault_a_i;
    cause_w_q <= cause_a_q;
  end

  assign trace_valid_o       = valid_w_q;
  assign trace_pc_o          = pc_w_q;
  assign trace_instruction_o = word_w_q;
  assign trace_write_o       = write_w_q;
  assign trace_dst_o         = dst_w_q;
  assign trace_value_o       = value_w_q;
  assign trace_exception_o   = fault_w_q;
  assign trace_cause_o       = cause_w_q;

endmodule
