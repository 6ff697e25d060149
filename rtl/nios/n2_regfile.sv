// SPDX-License-Identifier: Apache-2.0
// n2_regfile: 32 registers, two read ports, one write port.
// Contract: asynchronous read, write at the clock edge; a read of the word being written returns the old
// value (the core forwards that one). One copy per read port, so that each is a simple dual-port RAM that
// tools map to distributed memory: LUT memory of ECP5 and Xilinx, MLABs of Stratix III, which macro QUARTUS asks
// for (without the attribute Quartus makes 2 048 registers of them). Never written at 0; the reader takes r0 as 0.
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

`ifdef QUARTUS
  (* ramstyle = "MLAB" *)
`endif
  logic [31:0] copy_a[0:31];
`ifdef QUARTUS
  (* ramstyle = "MLAB" *)
`endif
  logic [31:0] copy_b[0:31];

  always_ff @(posedge clk_i) begin
    if (write_i) copy_a[dst_i] <= value_i;
  end

  always_ff @(posedge clk_i) begin
    if (write_i) copy_b[dst_i] <= value_i;
  end

  assign a_o = copy_a[a_i];
  assign b_o = copy_b[b_i];

endmodule
