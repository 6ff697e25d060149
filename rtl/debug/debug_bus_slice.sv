// SPDX-License-Identifier: Apache-2.0
// debug_bus_slice: registers between those who take turns on a bus and the agent, so that no path crosses both.
// Contract: one access at a time. It reaches the agent in the clock after it was requested and ends, with
// the agent's word, in the clock after the agent has done it: it takes two clocks more.
module debug_bus_slice #(
    parameter int unsigned AddressWidth = asip_regmap_pkg::ADDRESS_WIDTH
) (
    input  logic                    clk_i,
    input  logic                    rst_ni,
    // Avalon-MM agent
    input  logic                    read_i,
    input  logic                    write_i,
    input  logic [AddressWidth-1:0] address_i,
    input  logic [31:0]             writedata_i,
    output logic [31:0]             readdata_o,
    output logic                    waitrequest_o,
    // to the agent, Avalon-MM host
    output logic                    far_read_o,
    output logic                    far_write_o,
    output logic [AddressWidth-1:0] far_address_o,
    output logic [31:0]             far_writedata_o,
    input  logic [31:0]             far_readdata_i,
    input  logic                    far_wait_i
);

  logic read_q, write_q, done_q;
  logic [AddressWidth-1:0] address_q;
  logic [31:0] writedata_q, readdata_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      read_q  <= 1'b0;
      write_q <= 1'b0;
      done_q  <= 1'b0;
    end else begin
      done_q <= (read_q || write_q) && !far_wait_i;
      if (read_q || write_q) begin
        if (!far_wait_i) begin
          read_q  <= 1'b0;
          write_q <= 1'b0;
        end
      end else begin
        read_q  <= read_i && !done_q;
        write_q <= write_i && !done_q;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (!read_q && !write_q) begin
      address_q   <= address_i;
      writedata_q <= writedata_i;
    end
    readdata_q <= far_readdata_i;
  end

  assign far_read_o      = read_q;
  assign far_write_o     = write_q;
  assign far_address_o   = address_q;
  assign far_writedata_o = writedata_q;
  assign readdata_o       = readdata_q;
  assign waitrequest_o    = !done_q;

endmodule
