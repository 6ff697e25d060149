// SPDX-License-Identifier: Apache-2.0
// n2_regfile: 32 registers, two read ports, one write port.
// Contract: asynchronous read, write at the clock edge; a read of the word being written returns the old
// value (the core forwards that one). One copy per read port, so that each is a simple dual-port RAM that
// tools map to distributed memory. Never written at 0; the reader takes r0 as 0.
module n2_regfile (
    input  logic        clk_i,
    input  logic        write_i,
    input  logic [4:0]  dst_i,
    input  logic [31:0] value_i,
    input  logic [4:0]  a_i,
    input  logic [4:0]  b_i,
    output logic [31:0] a_o,
    output logic [31:0] b_o
);

  ram_lut u_copy_a (
      .clk_i,
      .write_i,
      .write_address_i(dst_i),
      .write_data_i   (value_i),
      .read_address_i (a_i),
      .read_data_o    (a_o)
  );

  ram_lut u_copy_b (
      .clk_i,
      .write_i,
      .write_address_i(dst_i),
      .write_data_i   (value_i),
      .read_address_i (b_i),
      .read_data_o    (b_o)
  );

endmodule
