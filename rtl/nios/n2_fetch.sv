// SPDX-License-Identifier: Apache-2.0
// n2_fetch: program counter, branch prediction and the stages F (memory read) and D (word register).
// Contract: addresses are word indices of the instruction memory and wrap at its end. A redirect from D
// (predicted transfer), E (jump) or M (everything else) costs 1, 2 or 3 cycles; the later stage wins. The
// table holds 2-bit counters, indexed by the address, upper half = taken; a counter travels with its
// branch and comes back updated. Its contents survive reset: they decide cycles, never results.
module n2_fetch #(
    parameter int unsigned AddressWidth = 14,
    parameter int unsigned Region = 0,         // upper address bits of the instruction memory
    parameter int unsigned TableBits = 8,
    parameter logic [31:0] ResetVector = 32'd0
) (
    input  logic                    clk_i,
    input  logic                    rst_ni,
    // pipeline control
    input  logic                    en_i,      // no stage is frozen
    input  logic                    hold_i,    // D waits for an operand
    // to the instruction memory
    output logic                    itcm_en_o,
    output logic [AddressWidth-1:0] itcm_address_o,
    input  logic [31:0]             itcm_rdata_i,
    // from E and M
    input  logic                    jump_e_i,
    input  logic [AddressWidth-1:0] target_e_i,
    input  logic                    redirect_m_i,
    input  logic [AddressWidth-1:0] target_m_i,
    input  logic                    update_m_i,
    input  logic [TableBits-1:0]    index_m_i,
    input  logic [1:0]              counter_m_i,
    // to D
    output logic                    valid_d_o,
    output logic [31:0]             word_d_o,
    output logic [AddressWidth-1:0] next_d_o,        // address after the instruction
    output logic [AddressWidth-1:0] other_d_o,       // the way that prediction did not take
    output logic                    taken_d_o,
    output logic [TableBits-1:0]    index_d_o,
    output logic [1:0]              counter_d_o,
    output logic                    outside_d_o      // target of a call or jmpi
);

  logic [AddressWidth-1:0] pc_f_q, next_f, next_d_q, target_d, next_pc, relative_d, absolute_d;
  logic valid_f_q, valid_d_q, take_f, take_d, older, relative, absolute, sequential;
  logic taken_f, taken_d_q, absolute_d_q;
  logic [31:0] word_d_q;
  logic [TableBits-1:0] index_d_q;
  logic [1:0] counter_f_q, counter_d_q;
  logic [1:0] table_q[0:2**TableBits-1];

  // The upper bits of imm26, as wide as the memory leaves them.
  localparam logic [25:0] RegionBits = 26'(Region);
  assign outside_d_o = (word_d_q[31:6] >> AddressWidth) != RegionBits;

  assign next_f     = pc_f_q + 1'b1;
  assign relative_d = next_d_q + AddressWidth'($signed(word_d_q[21:8]));
  assign absolute_d = word_d_q[6+:AddressWidth];
  assign target_d   = absolute_d_q ? absolute_d : relative_d;
  assign taken_d_o  = taken_d_q;
  assign other_d_o  = counter_d_q[1] ? next_d_q : target_d;

  always_comb begin
    older      = redirect_m_i || jump_e_i;
    relative   = valid_d_q && taken_d_q && !absolute_d_q && !older;
    absolute   = valid_d_q && absolute_d_q && !older;
    sequential = !(valid_d_q && taken_d_q) && !older;
    // The sum comes last, so that one gate follows it.
    next_pc = ({AddressWidth{relative}} & relative_d) | ({AddressWidth{sequential}} & next_f) |
              ({AddressWidth{absolute}} & absolute_d) | ({AddressWidth{redirect_m_i}} & target_m_i) |
              ({AddressWidth{jump_e_i && !redirect_m_i}} & target_e_i);
  end

  assign take_d = en_i && (!hold_i || redirect_m_i || jump_e_i);
  assign take_f = take_d;
  assign itcm_en_o = take_f;
  assign itcm_address_o = next_pc;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_f_q <= 1'b0;
      valid_d_q <= 1'b0;
      pc_f_q    <= ResetVector[2+:AddressWidth];
    end else if (take_d) begin
      valid_f_q <= 1'b1;
      valid_d_q <= valid_f_q && !redirect_m_i && !jump_e_i && !(valid_d_q && taken_d_q);
      pc_f_q    <= next_pc;
    end
  end

  always_ff @(posedge clk_i) begin
    if (take_d) begin
      word_d_q     <= itcm_rdata_i;
      taken_d_q    <= taken_f;
      absolute_d_q <= n2_pkg::is_absolute(itcm_rdata_i[5:0]);
      next_d_q     <= next_f;
      index_d_q    <= pc_f_q[TableBits-1:0];
      counter_d_q  <= counter_f_q;
    end
  end

  initial begin
    for (int unsigned i = 0; i < 2 ** TableBits; i++) table_q[i] = 2'b01;
  end

  // Not always_ff, which lets no `initial` write the table.
  always @(posedge clk_i) begin
    if (update_m_i) table_q[index_m_i] <= counter_m_i;
    if (take_f) counter_f_q <= table_q[next_pc[TableBits-1:0]];
  end

  // Transfers are recognised before the word is in D, where they decide the next address.
  assign taken_f = n2_pkg::is_direct(itcm_rdata_i[5:0]) ||
                   (n2_pkg::is_branch(itcm_rdata_i[5:0]) && counter_f_q[1]);

  assign valid_d_o   = valid_d_q;
  assign word_d_o    = word_d_q;
  assign next_d_o    = next_d_q;
  assign index_d_o   = index_d_q;
  assign counter_d_o = counter_d_q;

endmodule
