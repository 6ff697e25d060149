// SPDX-License-Identifier: Apache-2.0
// ram_block: simple dual-port RAM with a registered read port, for memory blocks.
// Contract: a read takes one cycle, and read_data_o keeps its value while read_i is low. What is read from
// the word that is written in the same cycle is not defined. Contents are not defined before they are written.
// It is the template of the Quartus handbook ("Recommended HDL Coding Styles", simple dual-port, single clock).
// Attributes: no_rw_check for Yosys, ramstyle for Quartus; without them a tool adds logic that gives the old
// word in a collision.
module ram_block #(
    parameter int unsigned Words = 256,
    parameter int unsigned Width = 32
) (
    input  logic                     clk_i,
    input  logic                     write_i,
    input  logic [$clog2(Words)-1:0] write_address_i,
    input  logic [Width-1:0]         write_data_i,
    input  logic                     read_i,
    input  logic [$clog2(Words)-1:0] read_address_i,
    output logic [Width-1:0]         read_data_o
);

  (* ramstyle = "no_rw_check", no_rw_check *) logic [Width-1:0] memory[0:Words-1];
  logic [Width-1:0] read_q;

  always_ff @(posedge clk_i) begin
    if (write_i) memory[write_address_i] <= write_data_i;
    if (read_i) read_q <= memory[read_address_i];
  end

  assign read_data_o = read_q;

endmodule
