// SPDX-License-Identifier: Apache-2.0
// ram_lut_sva: a word that was written is there in the next clock.
module ram_lut_sva #(
    parameter int unsigned Words = 32,
    parameter int unsigned Width = 32
) (
    input logic                     clk_i,
    input logic                     write_i,
    input logic [$clog2(Words)-1:0] write_address_i,
    input logic [Width-1:0]         write_data_i,
    input logic [$clog2(Words)-1:0] read_address_i,
    input logic [Width-1:0]         read_data_o
);

  Written : assert property (@(posedge clk_i) write_i |=>
      read_address_i != $past(write_address_i) || read_data_o == $past(write_data_i))
  else $error("a written word was not read");

endmodule

bind ram_lut ram_lut_sva #(
    .Words(Words),
    .Width(Width)
) u_sva (
    .*
);
