// SPDX-License-Identifier: Apache-2.0
// asip_de3: the ASIP on a Terasic DE3 (Stratix III EP3SL150), for area and timing of Table 4.
// Contract: OSC1_50 is the board's 50 MHz oscillator, BUTTON_N resets while low. The Avalon-MM agent
// runs on the 125 MHz core clock; its ports have no pins on the board and are virtual pins in Quartus.
// Reset asserts at once and is released two core clocks after the button is up and the PLL locked.
module asip_de3 #(
    parameter int unsigned FmaPipes = 2,
    parameter int unsigned Slots    = 3
) (
    input  logic                                      OSC1_50,
    input  logic                                      BUTTON_N,
    // Avalon-MM agent, virtual pins
    input  logic [asip_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic                                      read_i,
    input  logic                                      write_i,
    input  logic [31:0]                               writedata_i,
    output logic [31:0]                               readdata_o,
    output logic                                      waitrequest_o,
    output logic                                      irq_o
);

  logic clk, locked, reset_request, release_q, rst_nq;
  logic trace_issue;
  logic [15:0] trace_pc;
  logic [3:0] trace_write;
  logic [2:0][5:0] trace_index;
  logic [2:0][31:0] trace_data;
  asip_pkg::hook_out_t hook;

  board_pll u_pll (
      .osc_i   (OSC1_50),
      .clk_o   (clk),
      .locked_o(locked)
  );

  // Reset synchroniser; asip.sdc names both registers.
  assign reset_request = !BUTTON_N || !locked;
  always_ff @(posedge clk or posedge reset_request) begin
    if (reset_request) begin
      release_q <= 1'b0;
      rst_nq    <= 1'b0;
    end else begin
      release_q <= 1'b1;
      rst_nq    <= release_q;
    end
  end

  asip #(
      .FmaPipes(FmaPipes),
      .Slots   (Slots)
  ) u_asip (
      .clk_i        (clk),
      .rst_ni       (rst_nq),
      .address_i    (address_i),
      .read_i       (read_i),
      .write_i      (write_i),
      .writedata_i  (writedata_i),
      .readdata_o   (readdata_o),
      .waitrequest_o(waitrequest_o),
      .irq_o        (irq_o),
      .trace_issue_o(trace_issue),
      .trace_pc_o   (trace_pc),
      .trace_write_o(trace_write),
      .trace_index_o(trace_index),
      .trace_data_o (trace_data),
      .hook_i       ('0),
      .hook_o       (hook)
  );

  logic unused_trace;
  assign unused_trace = ^{trace_issue, trace_pc, trace_write, trace_index, trace_data, hook};

endmodule
