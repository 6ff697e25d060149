// SPDX-License-Identifier: Apache-2.0
// asip_regbank: one bank of the register file, one write port, any number of read ports.
// Contract: a read takes one cycle; a read of the word being written in the same cycle may return
// anything (the bypass covers that cycle). One copy of the memory per read port, so that every
// copy is a simple dual-port RAM that any tool maps to memory blocks, with nothing around it.
module asip_regbank #(
    parameter int unsigned IndexWidth = 6,
    parameter int unsigned Width      = 32,
    parameter int unsigned ReadPorts  = 9
) (
    input  logic                                 clk_i,
    // from write-back or the host
    input  logic                                 write_i,
    input  logic [IndexWidth-1:0]                write_index_i,
    input  logic [Width-1:0]                     write_data_i,
    // from and to the operand stage
    input  logic [ReadPorts-1:0][IndexWidth-1:0] read_index_i,
    output logic [ReadPorts-1:0][Width-1:0]      read_data_o
);

  genvar p;
  generate
    for (p = 0; p < ReadPorts; p++) begin : gen_copy
      ram_block #(
          .Words(2 ** IndexWidth),
          .Width(Width)
      ) u_ram (
          .clk_i,
          .write_i,
          .write_address_i(write_index_i),
          .write_data_i,
          .read_i         (1'b1),
          .read_address_i (read_index_i[p]),
          .read_data_o    (read_data_o[p])
      );
    end
  endgenerate

endmodule
