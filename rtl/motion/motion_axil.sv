// SPDX-License-Identifier: Apache-2.0
// motion_axil: the motion front-end with an AXI4-Lite subordinate port.
// Contract: that of axil_bridge, with the word addresses of docs/motion_regmap.md; the front-end's own
// accesses take 1 cycle for a write and 2 for a read.
module motion_axil #(
    parameter int unsigned Axes          = 5,
    parameter int unsigned ClocksPerTick = 100,
    parameter int unsigned Interpolators = 1,
    parameter logic [31:0] Modulus       = 32'd16_000_000 * ClocksPerTick
) (
    input  logic                                        clk_i,
    input  logic                                        rst_ni,
    // write address, write data, write response
    input  logic [motion_regmap_pkg::ADDRESS_WIDTH+1:0] awaddr_i,
    input  logic [2:0]                                  awprot_i,
    input  logic                                        awvalid_i,
    output logic                                        awready_o,
    input  logic [31:0]                                 wdata_i,
    input  logic [3:0]                                  wstrb_i,
    input  logic                                        wvalid_i,
    output logic                                        wready_o,
    output logic [1:0]                                  bresp_o,
    output logic                                        bvalid_o,
    input  logic                                        bready_i,
    // read address, read data
    input  logic [motion_regmap_pkg::ADDRESS_WIDTH+1:0] araddr_i,
    input  logic [2:0]                                  arprot_i,
    input  logic                                        arvalid_i,
    output logic                                        arready_o,
    output logic [31:0]                                 rdata_o,
    output logic [1:0]                                  rresp_o,
    output logic                                        rvalid_o,
    input  logic                                        rready_i,
    output logic                                        irq_o,
    // drives
    output logic [Axes-1:0]                             step_o,
    output logic [Axes-1:0]                             direction_o
);

  localparam int unsigned Width = motion_regmap_pkg::ADDRESS_WIDTH;

  logic [Width-1:0] address;
  logic read, write, waitrequest;
  logic [31:0] writedata, readdata;

  axil_bridge #(
      .AddressWidth(Width)
  ) u_bridge (
      .clk_i,
      .rst_ni,
      .awaddr_i,
      .awprot_i,
      .awvalid_i,
      .awready_o,
      .wdata_i,
      .wstrb_i,
      .wvalid_i,
      .wready_o,
      .bresp_o,
      .bvalid_o,
      .bready_i,
      .araddr_i,
      .arprot_i,
      .arvalid_i,
      .arready_o,
      .rdata_o,
      .rresp_o,
      .rvalid_o,
      .rready_i,
      .address_o    (address),
      .read_o       (read),
      .write_o      (write),
      .writedata_o  (writedata),
      .readdata_i   (readdata),
      .waitrequest_i(waitrequest)
  );

  motion_front_end #(
      .Axes         (Axes),
      .ClocksPerTick(ClocksPerTick),
      .Interpolators(Interpolators),
      .Modulus      (Modulus)
  ) u_motion (
      .clk_i,
      .rst_ni,
      .address_i    (address),
      .read_i       (read),
      .write_i      (write),
      .writedata_i  (writedata),
      .readdata_o   (readdata),
      .waitrequest_o(waitrequest),
      .irq_o,
      .step_o,
      .direction_o
  );

endmodule
