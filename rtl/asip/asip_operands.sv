// SPDX-License-Identifier: Apache-2.0
// asip_operands: register banks, constant bank, bypass and operand registers (stage R).
// Contract: the source fields of stage D, two cycles later, are values in the operand registers (E1).
// A result in write-back in the cycle of stage R is taken from the bypass, decided one cycle ahead
// from place 1 of the write schedules. While idle the host reads a register through the first source
// of the last slot, and writes through the write ports.
module asip_operands #(
    parameter int unsigned FmaPipes = 2,
    parameter int unsigned Ports    = 9
) (
    input  logic                       clk_i,
    // from issue, stage D
    input  logic [Ports-1:0][8:0]      source_d_i,
    // from the write schedules of A, B, C: write-back in the next cycle
    input  logic [2:0]                 next_valid_i,
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
    // to the units, stage E1
    output logic [Ports-1:0][31:0]     operand_e1_o
);

  localparam int unsigned HostPort = Ports - 3;

  logic [Ports-1:0][6:0]  index_r_q;
  logic [Ports-1:0][5:0]  index_bank;
  logic [Ports-1:0][2:0]  from_r_q;
  logic [Ports-1:0][31:0] read_a, read_b, read_c, read_k;
  logic [Ports-1:0][31:0] operand_e1_q;
  logic [2:0]             host_write;

  assign host_write[0] = host_write_i && host_register_i[8:6] == asip_isa_pkg::BANK_A;
  assign host_write[1] = host_write_i && host_register_i[8:6] == asip_isa_pkg::BANK_B;
  assign host_write[2] = host_write_i && host_register_i[8:6] == asip_isa_pkg::BANK_C;

  for (genvar p = 0; p < Ports; p++) begin : gen_port
    logic [8:0] source;
    logic [2:0] from_d;

    if (p == HostPort) begin : gen_host
      assign source = host_read_i ? host_register_i : source_d_i[p];
    end else begin : gen_core
      assign source = source_d_i[p];
    end

    always_comb begin
      case (source[8:6])
        asip_isa_pkg::BANK_A:
        from_d = next_valid_i[0] && next_index_i[0] == source[5:0] ? asip_pkg::BYPASS_A :
                 asip_pkg::FROM_A;
        asip_isa_pkg::BANK_B:
        from_d = next_valid_i[1] && next_index_i[1] == source[5:0] ? asip_pkg::BYPASS_B :
                 asip_pkg::FROM_B;
        asip_isa_pkg::BANK_C:
        from_d = next_valid_i[2] && next_index_i[2] == source[5:0] ? asip_pkg::BYPASS_C :
                 asip_pkg::FROM_C;
        asip_isa_pkg::BANK_ZERO: from_d = asip_pkg::FROM_ZERO;
        default: from_d = asip_pkg::FROM_K;
      endcase
    end

    always_ff @(posedge clk_i) begin
      index_r_q[p] <= source[6:0];
      from_r_q[p]  <= from_d;
      case (from_r_q[p])
        asip_pkg::FROM_A: operand_e1_q[p] <= read_a[p];
        asip_pkg::FROM_B: operand_e1_q[p] <= read_b[p];
        asip_pkg::FROM_C: operand_e1_q[p] <= read_c[p];
        asip_pkg::FROM_K: operand_e1_q[p] <= read_k[p];
        asip_pkg::BYPASS_A: operand_e1_q[p] <= write_data_i[0];
        asip_pkg::BYPASS_B: operand_e1_q[p] <= write_data_i[1];
        asip_pkg::BYPASS_C: operand_e1_q[p] <= write_data_i[2];
        default: operand_e1_q[p] <= 32'd0;
      endcase
    end

    assign index_bank[p] = index_r_q[p][5:0];
  end

  asip_regbank #(
      .IndexWidth(6),
      .ReadPorts (Ports)
  ) u_bank_a (
      .clk_i,
      .write_i      (write_i[0] || host_write[0]),
      .write_index_i(write_i[0] ? write_index_i[0] : host_register_i[5:0]),
      .write_data_i (write_i[0] ? write_data_i[0] : host_data_i),
      .read_index_i (index_bank),
      .read_data_o  (read_a)
  );

  if (FmaPipes > 1) begin : gen_bank_b
    asip_regbank #(
        .IndexWidth(6),
        .ReadPorts (Ports)
    ) u_bank_b (
        .clk_i,
        .write_i      (write_i[1] || host_write[1]),
        .write_index_i(write_i[1] ? write_index_i[1] : host_register_i[5:0]),
        .write_data_i (write_i[1] ? write_data_i[1] : host_data_i),
        .read_index_i (index_bank),
        .read_data_o  (read_b)
    );
  end else begin : gen_no_bank_b
    logic unused_b;
    assign read_b   = '0;
    assign unused_b = ^{write_i[1], write_index_i[1], host_write[1]};
  end

  asip_regbank #(
      .IndexWidth(6),
      .ReadPorts (Ports)
  ) u_bank_c (
      .clk_i,
      .write_i      (write_i[2] || host_write[2]),
      .write_index_i(write_i[2] ? write_index_i[2] : host_register_i[5:0]),
      .write_data_i (write_i[2] ? write_data_i[2] : host_data_i),
      .read_index_i (index_bank),
      .read_data_o  (read_c)
  );

  asip_regbank #(
      .IndexWidth(7),
      .ReadPorts (Ports)
  ) u_bank_k (
      .clk_i,
      .write_i      (host_write_constant_i),
      .write_index_i(host_register_i[6:0]),
      .write_data_i (host_data_i),
      .read_index_i (index_r_q),
      .read_data_o  (read_k)
  );

  assign operand_e1_o = operand_e1_q;

endmodule
