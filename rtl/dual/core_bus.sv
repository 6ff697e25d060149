// SPDX-License-Identifier: Apache-2.0
// core_bus: lets the sequencer and the host use one core's Avalon-MM port in turn.
// Contract: the sequencer goes first; an access of the host that has begun is finished before.
module core_bus (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        host_read_i,
    input  logic        host_write_i,
    input  logic [13:0] host_address_i,
    input  logic [31:0] host_data_i,
    output logic        host_wait_o,
    input  logic        sequencer_read_i,
    input  logic        sequencer_write_i,
    input  logic [13:0] sequencer_address_i,
    input  logic [31:0] sequencer_data_i,
    output logic        sequencer_wait_o,
    output logic        read_o,
    output logic        write_o,
    output logic [13:0] address_o,
    output logic [31:0] data_o,
    input  logic        wait_i
);

  logic host, sequencer, begun_q;

  assign sequencer = (sequencer_read_i || sequencer_write_i) && !begun_q;
  assign host      = (host_read_i || host_write_i) && !sequencer;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begun_q <= 1'b0;
    else begun_q <= host && wait_i;
  end

  assign read_o           = sequencer ? sequencer_read_i : host_read_i;
  assign write_o          = sequencer ? sequencer_write_i : host_write_i;
  assign address_o        = sequencer ? sequencer_address_i : host_address_i;
  assign data_o           = sequencer ? sequencer_data_i : host_data_i;
  assign sequencer_wait_o = !sequencer || wait_i;
  assign host_wait_o      = !host || wait_i;

endmodule
