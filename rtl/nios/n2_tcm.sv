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
      (* ramstyle = "no_rw_check", no_rw_check *) logic [7:0] memory[0:Words-1];

      always @(posedge clk_i) begin
        if (a_en_i) begin
          a_rdata_o[8*i+:8] <= memory[a_address_i];
          if (a_we_i[i]) memory[a_address_i] <= a_wdata_i[8*i+:8];
        end
      end

      always @(posedge clk_i) begin
        if (b_en_i) begin
          b_rdata_o[8*i+:8] <= memory[b_address_i];
          if (b_we_i[i]) memory[b_address_i] <= b_wdata_i[8*i+:8];
        end
      end
    end
  endgenerate

endmodule
