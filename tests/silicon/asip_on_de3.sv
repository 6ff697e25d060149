// SPDX-License-Identifier: Apache-2.0
// asip_on_de3: asip_de3 with the ports of the core, so that the core's bench runs programs on it. The board has
// no trace.
module asip_on_de3 #(
    parameter int unsigned FmaPipes = 2,
    parameter int unsigned Slots    = 3
) (
    input  logic                                      clk_i,
    input  logic                                      rst_ni,
    input  logic [asip_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic                                      read_i,
    input  logic                                      write_i,
    input  logic [31:0]                               writedata_i,
    output logic [31:0]                               readdata_o,
    output logic                                      waitrequest_o,
    output logic                                      irq_o,
    output logic                                      trace_issue_o,
    output logic [15:0]                               trace_pc_o,
    output logic [3:0]                                trace_write_o,
    output logic [2:0][5:0]                           trace_index_o,
    output logic [2:0][31:0]                          trace_data_o
);

  asip_de3 #(
      .FmaPipes(FmaPipes),
      .Slots   (Slots)
  ) u_de3 (
      .OSC1_50 (clk_i),
      .BUTTON_N(rst_ni),
      .address_i,
      .read_i,
      .write_i,
      .writedata_i,
      .readdata_o,
      .waitrequest_o,
      .irq_o
  );

  assign trace_issue_o = 1'b0;
  assign trace_pc_o    = '0;
  assign trace_write_o = '0;
  assign trace_index_o = '0;
  assign trace_data_o  = '0;

endmodule
