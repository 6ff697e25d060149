// SPDX-License-Identifier: Apache-2.0
// asip_operands_single: asip_operands for one slot and one multiply-add pipe.
// Contract: that of asip_operands, cycle by cycle. Banks C and K share a memory, because the host writes
// K only while no result of C can come; the word that the host writes must come as C's result, too.
// Whatever is not the operand is zero when it leaves stage R1, so stage R2 is an OR: of the two
// memories, of what was written back before, and of what is just then.
module asip_operands_single (
    input  logic             clk_i,
    // from issue, stage D
    input  logic [2:0][8:0]  source_d_i,
    // from the write schedules of A, B, C: write-back in two cycles, in the next cycle
    input  logic [2:0]       soon_i,
    input  logic [2:0][5:0]  soon_index_i,
    input  logic [2:0]       next_i,
    input  logic [2:0][5:0]  next_index_i,
    // from write-back of A, B, C
    input  logic [2:0]       write_i,
    input  logic [2:0][5:0]  write_index_i,
    input  logic [2:0][31:0] write_data_i,
    // from the host, idle only
    input  logic             host_read_i,
    input  logic             host_write_i,
    input  logic             host_write_constant_i,
    input  logic [8:0]       host_register_i,
    input  logic [31:0]      host_data_i,
    input  logic [1:0][31:0]     stream_r1_i,  // streams are for several slots
    input  asip_pkg::guard_t     guard_i,
    output logic                 bad_constant_e1_o,
    // to the units, stages R2 and E1
    output logic [2:0][31:0] early_r2_o,
    output logic [2:0]       late_r2_o,
    output logic [2:0][31:0] own_r2_o,
    output logic [2:0]       fresh_r2_o,
    output logic [2:0][31:0] operand_e1_o
);

  localparam int unsigned HostPort = 0;

  logic [2:0][5:0] index_a;
  logic [2:0][7:0] index_ck;
  logic [2:0][31:0] read_a, read_ck, read_a_r2_q, read_ck_r2_q, operand_r2, operand_e1_q;
  logic [2:0][31:0] next_a_r2_q, next_c_r2_q, now_a_r2_q, now_c_r2_q;
  logic [2:0] in_a_r1_q, in_ck_r1_q;
  logic [2:0][1:0] soon_r1_q, next_r1_q, now_r1_q, soon_r2_q;  // of {C, A}
  logic [1:0] host_write;
  logic [31:0] last_a_q, last_c_q;

  assign host_write[0] = host_write_i && host_register_i[8:6] == asip_isa_pkg::BANK_A;
  assign host_write[1] = (host_write_i && host_register_i[8:6] == asip_isa_pkg::BANK_C) ||
                         host_write_constant_i;

  // Words 0 to 63 of the shared memory are unused, then C; the upper half is K.
  genvar p, b;
  generate
    for (p = 0; p < 3; p++) begin : gen_port
      logic [8:0] source;
      logic [1:0] in_bank, soon, next, now;
      logic bypassed;

      if (p == HostPort) begin : gen_host
        assign source = host_read_i ? host_register_i : source_d_i[p];
      end else begin : gen_core
        assign source = source_d_i[p];
      end

      assign in_bank[0]  = source[8:6] == asip_isa_pkg::BANK_A;
      assign in_bank[1]  = source[8:6] == asip_isa_pkg::BANK_C;
      assign index_a[p]  = source[5:0];
      assign index_ck[p] = {source[8], source[6:0]};
      for (b = 0; b < 2; b++) begin : gen_bypass
        assign soon[b] = in_bank[b] && soon_i[2*b] && soon_index_i[2*b] == source[5:0];
        assign next[b] = in_bank[b] && next_i[2*b] && next_index_i[2*b] == source[5:0];
        assign now[b]  = in_bank[b] && write_i[2*b] && write_index_i[2*b] == source[5:0];
      end

      assign bypassed = (|soon_r1_q[p]) || (|next_r1_q[p]) || (|now_r1_q[p]);

      always_ff @(posedge clk_i) begin
        in_a_r1_q[p]    <= in_bank[0];
        in_ck_r1_q[p]   <= in_bank[1] || source[8];
        soon_r1_q[p]    <= soon;
        next_r1_q[p]    <= next;
        now_r1_q[p]     <= now;
        soon_r2_q[p]    <= soon_r1_q[p];
        read_a_r2_q[p]  <= in_a_r1_q[p] && !bypassed ? read_a[p] : 32'd0;
        read_ck_r2_q[p] <= in_ck_r1_q[p] && !bypassed ? read_ck[p] : 32'd0;
        next_a_r2_q[p]  <= next_r1_q[p][0] ? write_data_i[0] : 32'd0;
        next_c_r2_q[p]  <= next_r1_q[p][1] ? write_data_i[2] : 32'd0;
        now_a_r2_q[p]   <= now_r1_q[p][0] ? last_a_q : 32'd0;
        now_c_r2_q[p]   <= now_r1_q[p][1] ? last_c_q : 32'd0;
        operand_e1_q[p] <= operand_r2[p];
      end

      assign operand_r2[p] = read_a_r2_q[p] | read_ck_r2_q[p] |
                             next_a_r2_q[p] | next_c_r2_q[p] | now_a_r2_q[p] | now_c_r2_q[p] |
                             ({32{soon_r2_q[p][0]}} & write_data_i[0]) |
                             ({32{soon_r2_q[p][1]}} & write_data_i[2]);
    end
  endgenerate

  always_ff @(posedge clk_i) begin
    last_a_q <= write_data_i[0];
    last_c_q <= write_data_i[2];
  end

  asip_regbank #(
      .IndexWidth(6),
      .ReadPorts (3)
  ) u_bank_a (
      .clk_i,
      .write_i      (write_i[0] || host_write[0]),
      .write_index_i(write_i[0] ? write_index_i[0] : host_register_i[5:0]),
      .write_data_i (write_i[0] ? write_data_i[0] : host_data_i),
      .read_index_i (index_a),
      .read_data_o  (read_a)
  );

  asip_regbank #(
      .IndexWidth(8),
      .ReadPorts (3)
  ) u_bank_ck (
      .clk_i,
      .write_i      (write_i[2] || host_write[1]),
      .write_index_i(write_i[2] ? {2'b01, write_index_i[2]} :
                     {host_write_constant_i, host_register_i[6:0]}),
      .write_data_i (write_data_i[2]),
      .read_index_i (index_ck),
      .read_data_o  (read_ck)
  );

  assign early_r2_o   = operand_r2;
  assign late_r2_o    = '0;
  assign own_r2_o     = '0;  // for lanes, which this core has not
  assign fresh_r2_o   = '0;
  assign operand_e1_o = operand_e1_q;

  logic unused_b;
  assign unused_b = ^{soon_i[1], soon_index_i[1], next_i[1], next_index_i[1], write_i[1],
                      write_index_i[1], write_data_i[1]};

  // Redundancy is for several slots.
  logic unused_guard;
  assign bad_constant_e1_o = 1'b0;
  assign unused_guard      = ^{guard_i, stream_r1_i};

endmodule
