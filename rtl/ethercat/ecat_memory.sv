// SPDX-License-Identifier: Apache-2.0
// ecat_memory: the bytes of the controller, two neighbours at a time: one read and one write port.
// Contract: data of a read come a clock after its address. Byte 0 of a
// port is that at its address, byte 1 the one after. A read sees writes of earlier clocks.
module ecat_memory #(
    parameter int unsigned Bytes = 12288
) (
    input  logic        clk_i,
    input  logic [13:0] read_address_i,
    output logic [15:0] read_data_o,
    input  logic [1:0]  write_i,
    input  logic [13:0] write_address_i,
    input  logic [15:0] write_data_i
);

  localparam int unsigned Rows = Bytes / 2;

  logic [7:0] even_q[0:Rows-1];
  logic [7:0] odd_q[0:Rows-1];
  logic [7:0] even_data_q, odd_data_q;
  logic [12:0] read_even, read_odd, write_even, write_odd;
  logic swap_q;

  // At an odd address the byte after is the even one of the next row.
  assign read_odd   = read_address_i[13:1];
  assign read_even  = read_address_i[13:1] + {12'd0, read_address_i[0]};
  assign write_odd  = write_address_i[13:1];
  assign write_even = write_address_i[13:1] + {12'd0, write_address_i[0]};

  always_ff @(posedge clk_i) begin
    even_data_q <= even_q[read_even];
    if (write_i[write_address_i[0]]) even_q[write_even] <= write_address_i[0] ? write_data_i[15:8] : write_data_i[7:0];
  end
  always_ff @(posedge clk_i) begin
    odd_data_q <= odd_q[read_odd];
    if (write_i[!write_address_i[0]]) odd_q[write_odd] <= write_address_i[0] ? write_data_i[7:0] : write_data_i[15:8];
  end
  always_ff @(posedge clk_i) swap_q <= read_address_i[0];

  assign read_data_o = swap_q ? {even_data_q, odd_data_q} : {odd_data_q, even_data_q};

endmodule
