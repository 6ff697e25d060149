// SPDX-License-Identifier: Apache-2.0
// ram_two_ports: true dual-port RAM with one clock, for memory blocks.
// Contract: a read takes one cycle, and the data keep their value while the port's enable is low. What is
// read from a word that either port writes in the same cycle, and a word that both write, are not defined.
// It is the template of the Quartus handbook ("Recommended HDL Coding Styles", true dual-port, single clock), with the
// attributes of ram_block.
module ram_two_ports #(
    parameter int unsigned Words = 256,
    parameter int unsigned Width = 8
) (
    input  logic                     clk_i,
    input  logic                     a_en_i,
    input  logic                     a_we_i,
    input  logic [$clog2(Words)-1:0] a_address_i,
    input  logic [Width-1:0]         a_wdata_i,
    output logic [Width-1:0]         a_rdata_o,
    input  logic                     b_en_i,
    input  logic                     b_we_i,
    input  logic [$clog2(Words)-1:0] b_address_i,
    input  logic [Width-1:0]         b_wdata_i,
    output logic [Width-1:0]         b_rdata_o
);

  (* ramstyle = "no_rw_check", no_rw_check *) logic [Width-1:0] memory[0:Words-1];

  always @(posedge clk_i) begin
    if (a_en_i) begin
      a_rdata_o <= memory[a_address_i];
      if (a_we_i) memory[a_address_i] <= a_wdata_i;
    end
  end

  always @(posedge clk_i) begin
    if (b_en_i) begin
      b_rdata_o <= memory[b_address_i];
      if (b_we_i) memory[b_address_i] <= b_wdata_i;
    end
  end

endmodule
