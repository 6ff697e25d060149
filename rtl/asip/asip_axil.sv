// SPDX-License-Identifier: Apache-2.0
// asip_axil: the ASIP with an AXI4-Lite subordinate port.
// Contract: that of axil_bridge, with the word addresses of docs/regmap.md. The core holds an access while
// a program runs; its own accesses take the cycles that asip_host states (write 1).
module asip_axil #(
    parameter int unsigned FmaPipes    = 2,
    parameter int unsigned Slots       = 3,
    parameter int unsigned Bundles     = asip_isa_pkg::PROGRAM_BUNDLES,
    parameter int unsigned DataWords   = asip_isa_pkg::DATA_WORDS,
    parameter int unsigned StreamWords = 0,
    parameter int unsigned Loops       = 0,
    parameter int unsigned Lanes       = 0
) (
    input  logic                                      clk_i,
    input  logic                                      rst_ni,
    // write address, write data, write response
    input  logic [asip_regmap_pkg::ADDRESS_WIDTH+1:0] awaddr_i,
    input  logic [2:0]                                awprot_i,
    input  logic                                      awvalid_i,
    output logic                                      awready_o,
    input  logic [31:0]                               wdata_i,
    input  logic [3:0]                                wstrb_i,
    input  logic                                      wvalid_i,
    output logic                                      wready_o,
    output logic [1:0]                                bresp_o,
    output logic                                      bvalid_o,
    input  logic                                      bready_i,
    // read address, read data
    input  logic [asip_regmap_pkg::ADDRESS_WIDTH+1:0] araddr_i,
    input  logic [2:0]                                arprot_i,
    input  logic                                      arvalid_i,
    output logic                                      arready_o,
    output logic [31:0]                               rdata_o,
    output logic [1:0]                                rresp_o,
    output logic                                      rvalid_o,
    input  logic                                      rready_i,
    output logic                                      irq_o
);

  localparam int unsigned Width = asip_regmap_pkg::ADDRESS_WIDTH;

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

  logic trace_issue;
  logic [15:0] trace_pc;
  logic [3:0] trace_write;
  logic [2:0][5:0] trace_index;
  logic [2:0][31:0] trace_data;
  asip_pkg::hook_out_t hook;

  asip #(
      .FmaPipes   (FmaPipes),
      .Slots      (Slots),
      .Bundles    (Bundles),
      .DataWords  (DataWords),
      .StreamWords(StreamWords),
      .Loops      (Loops),
      .Lanes      (Lanes)
  ) u_asip (
      .clk_i,
      .rst_ni,
      .address_i    (address),
      .read_i       (read),
      .write_i      (write),
      .writedata_i  (writedata),
      .readdata_o   (readdata),
      .waitrequest_o(waitrequest),
      .irq_o,
      .trace_issue_o(trace_issue),
      .trace_pc_o   (trace_pc),
      .trace_write_o(trace_write),
      .trace_index_o(trace_index),
      .trace_data_o (trace_data),
      .hook_i       ('0),
      .hook_o       (hook)
  );

  logic unused;
  assign unused = ^{trace_issue, trace_pc, trace_write, trace_index, trace_data, hook};

endmodule
