// SPDX-License-Identifier: Apache-2.0
// ram_lut: simple dual-port RAM with an asynchronous read port, for distributed memory.
// Contract: write at the clock edge; a read of the word being written returns the old value. Contents are not
// defined before they are written.
// ECP5 and Xilinx build it of LUT memory. Macro QUARTUS asks for MLABs of Stratix III: without the attribute Quartus
// may make registers of it. Other tools do not know this style, so they do not see the attribute.
module ram_lut #(
    parameter int unsigned Words = 32,
    parameter int unsigned Width = 32
) (
    input  logic                     clk_i,
    input  logic                     write_i,
    input  logic [$clog2(Words)-1:0] write_address_i,
    input  logic [Width-1:0]         write_data_i,
    input  logic [$clog2(Words)-1:0] read_address_i,
    output logic [Width-1:0]         read_data_o
);

`ifdef QUARTUS
  (* ramstyle = "MLAB" *)
`endif
  logic [Width-1:0] memory[0:Words-1];

  always_ff @(posedge clk_i) if (write_i) memory[write_address_i] <= write_data_i;

  assign read_data_o = memory[read_address_i];

endmodule
