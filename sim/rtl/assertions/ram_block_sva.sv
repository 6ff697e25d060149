// SPDX-License-Identifier: Apache-2.0
// ram_block_sva: what was read stays until the next read.
module ram_block_sva #(
    parameter int unsigned Width = 32
) (
    input logic             clk_i,
    input logic             read_i,
    input logic [Width-1:0] read_data_o
);

  Held : assert property (@(posedge clk_i) !read_i |=> $stable(read_data_o))
  else $error("read data changed without a read");

endmodule

bind ram_block ram_block_sva #(
    .Width(Width)
) u_sva (
    .*
);
