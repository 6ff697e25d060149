// SPDX-License-Identifier: Apache-2.0
// asip_lane: a further lane of a multiply-add pipe: bank of registers, operands, arithmetic.
// Contract: a vector operation of the pipe does here what it does in the pipe, in the same cycles. own_r2_i selects, by
// operand, this lane's own word: the register of the same index, `zero` among them, or for the first operand the lane's
// word of the stream. The other operands are the pipe's, with registers in each lane: the wires from the pipe take a
// part of R2 and a part of E1. Writes are those of the pipe's bank that a vector operation makes. addend_r2_o is the
// register that the bundle names as addend. flags_o come a clock after their result, which is before the end of a run.
module asip_lane (
    input  logic                 clk_i,
    input  logic                 rst_ni,
    // from stage D: fields c, b, a of the pipe's operation
    input  logic [2:0][8:0]      source_d_i,
    // from the write schedule of the pipe's bank: write-back in two cycles, in the next cycle
    input  logic                 soon_i,
    input  logic [5:0]           soon_index_i,
    input  logic                 next_i,
    input  logic [5:0]           next_index_i,
    // from the stream, R1
    input  logic [31:0]          word_r1_i,
    // from the pipe, R2: its operation
    input  logic [1:0]           kind_r2_i,
    input  logic                 power_r2_i,
    input  logic                 below_r2_i,
    input  logic                 above_r2_i,
    input  logic [2:0]           own_r2_i,
    // .. its operands c, b, a
    input  logic [2:0][31:0]     operand_r2_i,
    // to the pipe, R2
    output logic [31:0]          addend_r2_o,
    // from the pipe, E1
    input  logic                 start_e1_i,
    output fp_pkg::flags_t       flags_o
);

  localparam int unsigned Latency = fp_pkg::FP_FMA_LATENCY;

  logic [Latency-1:0] vector_q;  // operations of the lane on their way
  logic write_q, valid;
  logic [5:0] write_index_q;
  logic [2:0] here, soon, next, now;  // by operand
  logic [2:0] soon_r1_q, next_r1_q, now_r1_q, here_r1_q, soon_r2_q, take_r2_q;
  logic [2:0][5:0] index_d;
  logic [2:0][31:0] read_r1, read_r2_q, bypass_r1, bypass_r2_q, word_r2, word_e1_q;  // by operand
  logic stream_d, stream_r1_q;  // operand a is a word of the stream
  logic keep_r2, least_r2, keep_e1_q, least_e1_q;
  logic [1:0] nan_r2;
  logic [2:0][31:0] pipe_e1_q;  // the pipe's operands
  logic [2:0] own_e1_q;  // by operand
  logic [1:0] kind_e1_q;
  logic [31:0] last_q, result, a_e1, b_e1, c_e1;
  fp_pkg::flags_t flags, flags_q;

  assign stream_d = source_d_i[0][8:6] == asip_isa_pkg::BANK_S;

  always_comb begin
    for (int unsigned i = 0; i < 3; i++) begin
      index_d[i] = source_d_i[i][5:0];
      here[i]    = source_d_i[i][8:6] != asip_isa_pkg::BANK_ZERO && !(i == 0 && stream_d);
      soon[i]    = here[i] && soon_i && vector_q[Latency-3] && soon_index_i == index_d[i];
      next[i]    = here[i] && next_i && vector_q[Latency-2] && next_index_i == index_d[i];
      now[i]     = here[i] && write_q && write_index_q == index_d[i];
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      vector_q <= '0;
      write_q  <= 1'b0;
      flags_q  <= '0;
    end else begin
      vector_q <= {vector_q[Latency-2:0], start_e1_i};
      // A write by another operation of the pipe leaves this lane as it is.
      write_q  <= next_i && vector_q[Latency-2];
      flags_q  <= valid ? flags : '0;
    end
  end

  asip_regbank #(
      .ReadPorts(3)
  ) u_bank (
      .clk_i,
      .write_i      (write_q),
      .write_index_i(write_index_q),
      .write_data_i (result),
      .read_index_i (index_d),
      .read_data_o  (read_r1)
  );

  // As in asip_operands_multiple, a source that is not selected gives zero.
  always_comb begin
    for (int unsigned i = 0; i < 3; i++) begin
      bypass_r1[i] = ({32{next_r1_q[i]}} & result) | ({32{now_r1_q[i]}} & last_q);
      word_r2[i]   = ({32{take_r2_q[i]}} & read_r2_q[i]) | ({32{soon_r2_q[i]}} & result) | bypass_r2_q[i];
    end
    if (stream_r1_q) bypass_r1[0] = word_r1_i;
  end

  asip_limit u_limit (
      .below_i(below_r2_i),
      .above_i(above_r2_i),
      .facts_i(asip_pkg::facts_of(word_r2[0])),
      .keep_o (keep_r2),
      .nan_o  (nan_r2),
      .least_o(least_r2)
  );

  always_ff @(posedge clk_i) begin
    write_index_q <= next_index_i;
    soon_r1_q     <= soon;
    next_r1_q     <= next;
    now_r1_q      <= now;
    here_r1_q     <= here;
    stream_r1_q   <= stream_d;
    last_q        <= result;
    soon_r2_q     <= soon_r1_q;
    take_r2_q     <= here_r1_q & ~(soon_r1_q | next_r1_q | now_r1_q);
    read_r2_q     <= read_r1;
    bypass_r2_q   <= bypass_r1;
  end

  always_ff @(posedge clk_i) begin
    kind_e1_q  <= kind_r2_i;
    own_e1_q   <= own_r2_i;
    keep_e1_q  <= own_r2_i[0] && (keep_r2 || (&nan_r2));
    least_e1_q <= own_r2_i[0] && least_r2;
    word_e1_q  <= word_r2;
    if (power_r2_i) word_e1_q[1] <= asip_pkg::power_of_two(word_r2[1][7:0]);
    pipe_e1_q <= operand_r2_i;
  end

  always_comb begin
    a_e1 = asip_pkg::limited(word_e1_q[0], keep_e1_q, 2'b00, least_e1_q);  // one of the two is zero
    a_e1 = a_e1 | ({32{!own_e1_q[0]}} & pipe_e1_q[0]);
  end

  assign b_e1 = own_e1_q[1] ? word_e1_q[1] : pipe_e1_q[1];
  assign c_e1 = own_e1_q[2] ? word_e1_q[2] : pipe_e1_q[2];

  fp_fma u_fma (
      .clk_i,
      .rst_ni,
      .valid_i      (start_e1_i),
      .kind_i       (kind_e1_q),
      .neg_product_i(1'b0),
      .neg_addend_i (1'b0),
      .a_i          (a_e1),
      .b_i          (b_e1),
      .c_i          (c_e1),
      .valid_o      (valid),
      .result_o     (result),
      .flags_o      (flags)
  );

  assign addend_r2_o = word_r2[2];
  assign flags_o     = flags_q;

endmodule
