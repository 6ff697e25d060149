// SPDX-License-Identifier: Apache-2.0
// asip_operands_multiple: asip_operands for several slots, each bank a memory of its own.
// Contract: that of asip_operands, cycle by cycle. Stage R2 is an OR of what each source gives, with a register for each
// select: a source that is not selected gives zero. Without Resilience a word of the host passes a register on its way to
// the banks, whose copies are far apart: the host's next read of a bank waits a cycle (asip_host). Bank K, which no
// result is written to, then shares the memories of bank A: a port reads one of the two, at the low bits of its source.
module asip_operands_multiple #(
    parameter int unsigned FmaPipes   = 2,
    parameter int unsigned Ports      = 9,
    parameter int unsigned Resilience = 0,
    parameter int unsigned StreamWords = 0
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

  localparam int unsigned HostPort = Ports - 3;

  // With redundancy a bank has four pages, of which three are used, and a word of bank K a parity bit.
  localparam int unsigned BankWidth = Resilience != 0 ? 8 : 6;
  localparam int unsigned WordWidth = Resilience != 0 ? 33 : 32;
  localparam bit SharedK = Resilience == 0;
  localparam int unsigned WidthA = SharedK ? 8 : BankWidth;

  logic [Ports-1:0][6:0] index_k;
  logic [Ports-1:0][BankWidth-1:0] index_bank;
  logic [Ports-1:0][WidthA-1:0] index_a;
  logic [WidthA-1:0] write_index_a;
  logic write_a;
  logic [2:0][BankWidth-1:0] bank_index;  // of a write
  logic [2:0][31:0] bank_word;
  logic [2:0] bank_write;
  logic [Ports-1:0][WordWidth-1:0] read_k_word;
  logic [Ports-1:0][2:0] bank_r1_q;
  logic [Ports-1:0][2:0] soon_r1_q, next_r1_q, now_r1_q, soon_r2_q;  // one of banks A, B, C, or none
  logic [Ports-1:0][3:0] take_r2_q;  // the word read from K, C, B, A
  logic sweep_r1;  // the sweep reads a word of bank K
  logic [Ports-1:0][31:0] read_a, read_b, read_c, read_k;
  logic [Ports-1:0][31:0] read_a_r2_q, read_b_r2_q, read_c_r2_q, read_k_r2_q, bypass_r2_q;
  logic [Ports-1:0][31:0] held_r2;  // early_r2 without the results of A and B
  logic [Ports-1:0][31:0] early_r2, operand_e1_q;
  logic [Ports-1:0][31:0] stream_r1;  // of the stream of the port's slot, or zero
  logic [2:0][31:0] last_data_q;
  logic [3:0] host_write, host_strobe;  // K, C, B, A
  logic [6:0] host_index;
  logic [31:0] host_word;

  assign host_write[0] = host_write_i && host_register_i[8:6] == asip_isa_pkg::BANK_A;
  assign host_write[1] = host_write_i && host_register_i[8:6] == asip_isa_pkg::BANK_B;
  assign host_write[2] = host_write_i && host_register_i[8:6] == asip_isa_pkg::BANK_C;
  assign host_write[3] = host_write_constant_i;

  generate
    if (Resilience != 0) begin : gen_host_at_once
      // A page may be copied from the next clock on.
      assign host_strobe = host_write;
      assign host_index  = host_register_i[6:0];
      assign host_word   = host_data_i;
    end else begin : gen_host_register
      logic [3:0] strobe_q;
      logic [6:0] index_q;
      logic [31:0] word_q;

      always_ff @(posedge clk_i) begin
        strobe_q <= host_write;
        index_q  <= host_register_i[6:0];
        word_q   <= host_data_i;
      end

      assign host_strobe = strobe_q;
      assign host_index  = index_q;
      assign host_word   = word_q;
    end
  endgenerate

  // Copying a page takes the words that the host's port reads.
  always_comb begin
    for (int unsigned b = 0; b < 3; b++) begin
      bank_write[b] = write_i[b] || host_strobe[b];
      bank_index[b] = BankWidth'({guard_i.page, write_i[b] ? write_index_i[b] : host_index[5:0]});
      bank_word[b]  = write_i[b] ? write_data_i[b] : host_word;
    end
    if (guard_i.copy) begin
      bank_write = {3{guard_i.copy_store}};
      bank_index = {3{BankWidth'({guard_i.copy_to, guard_i.copy_write})}};
      bank_word  = {read_c[HostPort], read_b[HostPort], read_a[HostPort]};
    end
  end

  genvar p, bank;
  generate
    for (p = 0; p < Ports; p++) begin : gen_port
      logic [8:0] source;
      logic [2:0] in_bank, soon, next, now;
      logic [3:0] take_r1;
      logic bypassed_r1, of_k_r1;
      logic [31:0] bypass_r1;

      if (p == HostPort) begin : gen_host
        assign source = host_read_i ? host_register_i : source_d_i[p];
      end else begin : gen_core
        assign source = source_d_i[p];
      end

      assign in_bank[0] = source[8:6] == asip_isa_pkg::BANK_A;
      assign in_bank[1] = source[8:6] == asip_isa_pkg::BANK_B;
      assign in_bank[2] = source[8:6] == asip_isa_pkg::BANK_C;
      for (bank = 0; bank < 3; bank++) begin : gen_bypass
        assign soon[bank] = in_bank[bank] && soon_i[bank] && soon_index_i[bank] == source[5:0];
        assign next[bank] = in_bank[bank] && next_i[bank] && next_index_i[bank] == source[5:0];
        assign now[bank]  = in_bank[bank] && write_i[bank] && write_index_i[bank] == source[5:0];
      end

      // R1: what was or is written back goes to the bypass register, as does a word of a stream. Nothing reads a word of
      // bank K during a sweep but the check of its parity.
      assign bypassed_r1 = (|soon_r1_q[p]) || (|next_r1_q[p]) || (|now_r1_q[p]);
      assign take_r1[0]  = (bank_r1_q[p] == asip_isa_pkg::BANK_A && !bypassed_r1) || (SharedK && of_k_r1);
      assign take_r1[1]  = bank_r1_q[p] == asip_isa_pkg::BANK_B && !bypassed_r1;
      assign take_r1[2]  = bank_r1_q[p] == asip_isa_pkg::BANK_C && !bypassed_r1;
      assign take_r1[3]  = !SharedK && (of_k_r1 || sweep_r1);
      assign of_k_r1     = bank_r1_q[p][2:1] == asip_isa_pkg::BANK_K[2:1];

      always_comb begin
        bypass_r1 = stream_r1[p];
        for (int unsigned b = 0; b < 3; b++) begin
          bypass_r1 = bypass_r1 | ({32{next_r1_q[p][b]}} & write_data_i[b]) | ({32{now_r1_q[p][b]}} & last_data_q[b]);
        end
      end

      always_ff @(posedge clk_i) begin
        bank_r1_q[p]   <= source[8:6];
        soon_r1_q[p]   <= soon;
        next_r1_q[p]   <= next;
        now_r1_q[p]    <= now;
        soon_r2_q[p]   <= soon_r1_q[p];
        take_r2_q[p]   <= take_r1;
        read_a_r2_q[p] <= read_a[p];
        read_b_r2_q[p] <= read_b[p];
        read_c_r2_q[p] <= read_c[p];
        read_k_r2_q[p] <= read_k[p];
        bypass_r2_q[p] <= bypass_r1;
        operand_e1_q[p] <= early_r2[p] | ({32{soon_r2_q[p][2]}} & write_data_i[2]);
      end

      assign held_r2[p]  = ({32{take_r2_q[p][0]}} & read_a_r2_q[p]) | ({32{take_r2_q[p][1]}} & read_b_r2_q[p]) |
                           ({32{take_r2_q[p][2]}} & read_c_r2_q[p]) | ({32{take_r2_q[p][3]}} & read_k_r2_q[p]) |
                           bypass_r2_q[p];
      assign early_r2[p] = held_r2[p] | ({32{soon_r2_q[p][0]}} & write_data_i[0]) |
                           ({32{soon_r2_q[p][1]}} & write_data_i[1]);

      assign late_r2_o[p] = soon_r2_q[p][2];

      if (p < 3) begin : gen_own_a
        assign own_r2_o[p]   = ({32{take_r2_q[p][0]}} & read_a_r2_q[p]) | bypass_r2_q[p];
        assign fresh_r2_o[p] = soon_r2_q[p][0];
      end else if (p < 3 * FmaPipes) begin : gen_own_b
        assign own_r2_o[p]   = ({32{take_r2_q[p][1]}} & read_b_r2_q[p]) | bypass_r2_q[p];
        assign fresh_r2_o[p] = soon_r2_q[p][1];
      end else begin : gen_own_c
        assign own_r2_o[p]   = ({32{take_r2_q[p][2]}} & read_c_r2_q[p]) | bypass_r2_q[p];
        assign fresh_r2_o[p] = soon_r2_q[p][2];
      end

      assign index_bank[p] = BankWidth'(guard_i.copy ? {guard_i.copy_from, guard_i.copy_read} :
                                      {guard_i.page, source[5:0]});
      assign index_k[p]    = guard_i.sweep ? guard_i.sweep_index : source[6:0];
      assign read_k[p]     = read_k_word[p][31:0];
    end
  endgenerate

  generate
    for (p = 0; p < Ports; p++) begin : gen_stream
      if (StreamWords != 0 && p < 3 * FmaPipes) begin : gen_word
        assign stream_r1[p] = bank_r1_q[p] == asip_isa_pkg::BANK_S ? stream_r1_i[p/3] : 32'd0;
      end else begin : gen_none
        assign stream_r1[p] = 32'd0;
      end
    end
    if (StreamWords == 0) begin : gen_no_streams
      logic unused_streams;
      assign unused_streams = ^stream_r1_i;
    end
  endgenerate

  always_ff @(posedge clk_i) last_data_q <= write_data_i;

  generate
    if (SharedK) begin : gen_shared
      // A source in bank A or K without the two bits in which their codes are alike.
      for (p = 0; p < Ports; p++) begin : gen_index
        assign index_a[p] = p == HostPort && host_read_i ? {host_register_i[8], host_register_i[6:0]} :
                            {source_d_i[p][8], source_d_i[p][6:0]};
      end
      assign write_a       = bank_write[0] || host_strobe[3];
      assign write_index_a = write_i[0] ? {2'b01, write_index_i[0]} :
                             {host_strobe[3], host_index[6] || !host_strobe[3], host_index[5:0]};
    end else begin : gen_apart
      assign index_a       = index_bank;
      assign write_a       = bank_write[0];
      assign write_index_a = bank_index[0];
    end
  endgenerate

  asip_regbank #(
      .IndexWidth(WidthA),
      .ReadPorts (Ports)
  ) u_bank_a (
      .clk_i,
      .write_i      (write_a),
      .write_index_i(write_index_a),
      .write_data_i (bank_word[0]),
      .read_index_i (index_a),
      .read_data_o  (read_a)
  );

  generate
    if (FmaPipes > 1) begin : gen_bank_b
      asip_regbank #(
          .IndexWidth(BankWidth),
          .ReadPorts (Ports)
      ) u_bank_b (
          .clk_i,
          .write_i      (bank_write[1]),
          .write_index_i(bank_index[1]),
          .write_data_i (bank_word[1]),
          .read_index_i (index_bank),
          .read_data_o  (read_b)
      );
    end else begin : gen_no_bank_b
      logic unused_b;
      assign read_b   = '0;
      assign unused_b = ^{bank_write[1], bank_index[1], bank_word[1]};
    end
  endgenerate

  asip_regbank #(
      .IndexWidth(BankWidth),
      .ReadPorts (Ports)
  ) u_bank_c (
      .clk_i,
      .write_i      (bank_write[2]),
      .write_index_i(bank_index[2]),
      .write_data_i (bank_word[2]),
      .read_index_i (index_bank),
      .read_data_o  (read_c)
  );

  generate
    if (SharedK) begin : gen_no_bank_k
      logic unused_k;
      assign read_k_word = '0;
      assign unused_k    = ^{index_k, bank_index[0]};
    end else begin : gen_bank_k
      asip_regbank #(
          .IndexWidth(7),
          .Width     (WordWidth),
          .ReadPorts (Ports)
      ) u_bank_k (
          .clk_i,
          .write_i      (host_strobe[3]),
          .write_index_i(host_index),
          .write_data_i (WordWidth'({^host_word, host_word})),
          .read_index_i (index_k),
          .read_data_o  (read_k_word)
      );
    end
    if (Resilience != 0) begin : gen_parity
      logic [Ports-1:0] parity_r2_q, bad_r2;
      logic bad_e1_q;
      logic sweep_q;
      logic unused_first;

      assign unused_first = guard_i.sweep_first;
      assign sweep_r1     = sweep_q;
      for (p = 0; p < Ports; p++) begin : gen_bad
        always_ff @(posedge clk_i) parity_r2_q[p] <= read_k_word[p][WordWidth-1];
        assign bad_r2[p] = take_r2_q[p][3] && (^{read_k_r2_q[p], parity_r2_q[p]});
      end

      always_ff @(posedge clk_i) begin
        sweep_q  <= guard_i.sweep_step;
        bad_e1_q <= |bad_r2;
      end

      assign bad_constant_e1_o = bad_e1_q;
    end else begin : gen_no_parity
      logic unused_guard;
      assign sweep_r1          = 1'b0;
      assign bad_constant_e1_o = 1'b0;
      assign unused_guard      = ^guard_i;
    end
  endgenerate

  assign early_r2_o   = early_r2;
  assign operand_e1_o = operand_e1_q;

endmodule
