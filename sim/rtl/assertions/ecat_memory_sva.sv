// SPDX-License-Identifier: Apache-2.0
// ecat_memory_sva: no write beyond the memory.
module ecat_memory_sva #(
    parameter int unsigned Bytes = 12288
) (
    input logic        clk_i,
    input logic [1:0]  write_i,
    input logic [13:0] write_address_i
);

  WriteInside : assert property (@(posedge clk_i)
      write_i != 2'b00 |-> 32'(write_address_i) + 32'(write_i[1]) < Bytes)
  else $error("a write beyond the memory");

endmodule

bind ecat_memory ecat_memory_sva #(
    .Bytes(Bytes)
) u_sva (.*);
