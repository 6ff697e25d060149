// SPDX-License-Identifier: Apache-2.0
// ram_two_ports_sva: both ports never write the same word, and what was read is held.
module ram_two_ports_sva #(
    parameter int unsigned Words = 256,
    parameter int unsigned Width = 8
) (
    input logic                     clk_i,
    input logic                     a_en_i,
    input logic                     a_we_i,
    input logic [$clog2(Words)-1:0] a_address_i,
    input logic [Width-1:0]         a_rdata_o,
    input logic                     b_en_i,
    input logic                     b_we_i,
    input logic [$clog2(Words)-1:0] b_address_i,
    input logic [Width-1:0]         b_rdata_o
);

  OneWriter : assert property (@(posedge clk_i)
      a_en_i && b_en_i && a_we_i && b_we_i |-> a_address_i != b_address_i)
  else $error("both ports write one word");

  HeldA : assert property (@(posedge clk_i) !a_en_i |=> $stable(a_rdata_o))
  else $error("a word that was read changed at port a");

  HeldB : assert property (@(posedge clk_i) !b_en_i |=> $stable(b_rdata_o))
  else $error("a word that was read changed at port b");

endmodule

bind ram_two_ports ram_two_ports_sva #(
    .Words(Words),
    .Width(Width)
) u_sva (.*);
