// SPDX-License-Identifier: Apache-2.0
// asip_lane: a further lane of a multiply-add pipe: bank of registers, operands, arithmetic.
// Contract: a vector operation of the pipe does here what it does in the pipe, in the same cycles: the first
// operand is this lane's word of the stream, the second the pipe's own, the addend the register of the same
// index here. Writes are those of the pipe's bank that a vector operation makes. addend_e1_o is the
// register that the bundle names as addend, whatever its operation.
module asip_lane (
    input  logic                 clk_i,
    input  logic                 rst_ni,
    // from stage D: field c of the pipe's operation
    input  logic [8:0]           source_c_d_i,
    // from the write schedule of the pipe's bank: write-back in two cycles, in the next cycle, now
    input  logic                 soon_i,
    input  logic [5:0]           soon_index_i,
    input  logic                 next_i,
    input  logic [5:0]           next_index_i,
    input  logic                 write_i,
    input  logic [5:0]           write_index_i,
    // from the stream, R1
    input  logic [31:0]          word_r1_i,
    // from the operand stage, E1
    input  logic                 start_e1_i,
    input  logic [1:0]           kind_e1_i,
    input  logic [31:0]          factor_e1_i,
    output logic [31:0]          addend_e1_o,
    output fp_pkg::flags_t       flags_o
);

  localparam int unsigned Latency = fp_pkg::FP_FMA_LATENCY;

  logic [Latency-1:0] vector_q;  // operations of the lane on their way
  logic here, soon, next, now, write, valid;
  logic soon_r1_q, next_r1_q, now_r1_q, zero_r1_q, soon_r2_q, bypassed_r2_q;
  logic [31:0] read_r1, read_r2_q, bypass_r2_q, last_q, word_r2_q, word_e1_q, addend_e1_q, result;
  fp_pkg::flags_t flags;

  // A write by another operation of the pipe leaves this lane as it is.
  assign here  = source_c_d_i[8:6] != asip_isa_pkg::BANK_ZERO;
  assign soon  = here && soon_i && vector_q[Latency-3] && soon_index_i == source_c_d_i[5:0];
  assign next  = here && next_i && vector_q[Latency-2] && next_index_i == source_c_d_i[5:0];
  assign write = write_i && vector_q[Latency-1];
  assign now   = here && write && write_index_i == source_c_d_i[5:0];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) vector_q <= '0;
    else vector_q <= {vector_q[Latency-2:0], start_e1_i};
  end

  asip_regbank #(
      .ReadPorts(1)
  ) u_bank (
      .clk_i,
      .write_i      (write),
      .write_index_i(write_index_i),
      .write_data_i (result),
      .read_index_i (source_c_d_i[5:0]),
      .read_data_o  (read_r1)
  );

  // As in asip_operands_multiple: what was or is written back takes the place of what was read.
  always_ff @(posedge clk_i) begin
    soon_r1_q     <= soon;
    next_r1_q     <= next;
    now_r1_q      <= now;
    zero_r1_q     <= !here;
    last_q        <= result;
    soon_r2_q     <= soon_r1_q;
    bypassed_r2_q <= next_r1_q || now_r1_q || zero_r1_q;
    bypass_r2_q   <= ({32{next_r1_q}} & result) | ({32{now_r1_q}} & last_q);
    read_r2_q     <= read_r1;
    word_r2_q     <= word_r1_i;
    word_e1_q     <= word_r2_q;
    if (soon_r2_q) addend_e1_q <= result;
    else if (bypassed_r2_q) addend_e1_q <= bypass_r2_q;
    else addend_e1_q <= read_r2_q;
  end

  fp_fma u_fma (
      .clk_i,
      .rst_ni,
      .valid_i      (start_e1_i),
      .kind_i       (kind_e1_i),
      .neg_product_i(1'b0),
      .neg_addend_i (1'b0),
      .a_i          (word_e1_q),
      .b_i          (factor_e1_i),
      .c_i          (addend_e1_q),
      .valid_o      (valid),
      .result_o     (result),
      .flags_o      (flags)
  );

  assign addend_e1_o = addend_e1_q;
  assign flags_o     = valid ? flags : '0;

endmodule
