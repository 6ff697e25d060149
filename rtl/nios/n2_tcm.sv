// SPDX-License-Identifier: Apache-2.0
// n2_tcm: tightly coupled memory, 32-bit words with byte enables, two equal ports.
// Contract: read data are valid the cycle after en and held while en is low. Nobody may rely on what
// is read from a word that either port writes in the same cycle, or on a word that both write.
module n2_tcm #(
    parameter int unsigned Words = 16384
) (
    input  logic                     clk_i,
    input  logic                     a_en_i,
    input  logic [3:0]               a_we_i,     // per byte
    input  logic [$clog2(Words)-1:0] a_address_i,
    input  logic [31:0]              a_wdata_i,
    output logic [31:0]              a_rdata_o,
    input  logic                     b_en_i,
    input  logic [3:0]               b_we_i,     // per byte
    input  logic [$clog2(Words)-1:0] b_address_i,
    input  logic [31:0]              b_wdata_i,
    output logic [31:0]              b_rdata_o
);

  // A memory of its own per byte: every tool infers block RAM from that.
  genvar i;
  generate
    for (i = 0; i < 4; i++) begin : gen_byte
      ram_two_ports #(
          .Words(Words),
          .Width(8)
      ) u_ram (
          .clk_i,
          .a_en_i,
          .a_we_i   (a_we_i[i]),
          .a_address_i,
          .a_wdata_i(a_wdata_i[8*i+:8]),
          .a_rdata_o(a_rdata_o[8*i+:8]),
          .b_en_i,
          .b_we_i   (b_we_i[i]),
          .b_address_i,
          .b_wdata_i(b_wdata_i[8*i+:8]),
          .b_rdata_o(b_rdata_o[8*i+:8])
      );
    end
  endgenerate

endmodule
