// SPDX-License-Identifier: Apache-2.0
// drive_chain: five motors from encoder edges to gate edges: two processors plan and track, one closes the
// current loops.
// Contract: one clock, asynchronous active-low reset. Address bits 17:16 choose the block: 0 dual_asip
// (docs/dual_regmap.md), 1 the processor of the current loops (docs/regmap.md), 2 drive_front_end
// (docs/drive_regmap.md). The tracking processor sees the counted positions; its commands are the
// orders of the current loops from the next sample on. The front-end goes before the host on the bus
// of the current loops' processor.
module drive_chain #(
    parameter int unsigned TrajectoryFmaPipes = 1,
    parameter int unsigned TrajectorySlots    = 1,
    parameter int unsigned TrackingFmaPipes   = 2,
    parameter int unsigned TrackingSlots      = 3,
    parameter int unsigned CurrentFmaPipes    = 1,
    parameter int unsigned CurrentSlots       = 1,
    parameter int unsigned ThirdSensor        = 0,
    parameter int unsigned EdgeStamps         = 0
) (
    input  logic               clk_i,
    input  logic               rst_ni,
    // Avalon-MM agent
    input  logic [17:0]        address_i,
    input  logic               read_i,
    input  logic               write_i,
    input  logic [31:0]        writedata_i,
    output logic [31:0]        readdata_o,
    output logic               waitrequest_o,
    output logic               irq_o,
    // motors
    input  logic [4:0]         a_i,
    input  logic [4:0]         b_i,
    input  logic [4:0]         z_i,
    output logic               mclk_o,
    input  logic [4:0]         bit_a_i,
    input  logic [4:0]         bit_b_i,
    input  logic [4:0]         bit_c_i,
    input  logic signed [15:0] bus_i,
    input  logic [4:0]         fault_i,
    output logic [14:0]        high_o,
    output logic [14:0]        low_o,
    output logic [4:0]         release_o,
    output logic               chopper_o,
    // of dual_asip
    output logic [159:0]       measured_o,
    output logic [159:0]       command_o,
    output logic               command_valid_o,
    output logic               period_o,
    output logic               finished_o,
    output logic               stop_o,
    output logic               trace_store_o,
    output logic [1:0]         trace_cycles_o,
    output logic [4:0]         trace_index_o,
    output logic [31:0]        trace_data_o
);

  localparam int unsigned Axes = 5;
  localparam int unsigned BlockBits = dual_regmap_pkg::ADDRESS_WIDTH;  // the largest block's

  logic [2:0] at, wait_block;
  logic [95:0] data_block;
  logic [13:0] link_address, address;
  logic [31:0] link_data, data;
  logic link_read, link_write, link_wait, read, write, core_wait, core_irq;
  logic trace_issue, unused_trace;
  logic [4:0] unused_clear;
  logic [15:0] trace_pc;
  logic [3:0] trace_write;
  logic [17:0] trace_index;
  logic [95:0] trace_data;
  asip_pkg::hook_out_t hook;

  genvar n;
  generate
    for (n = 0; n < 3; n++) begin : gen_at
      assign at[n] = address_i[17:BlockBits] == 2'(n);
    end
  endgenerate

  dual_asip #(
      .TrajectoryFmaPipes(TrajectoryFmaPipes),
      .TrajectorySlots   (TrajectorySlots),
      .TrackingFmaPipes  (TrackingFmaPipes),
      .TrackingSlots     (TrackingSlots)
  ) u_dual (
      .clk_i,
      .rst_ni,
      .address_i    (address_i[dual_regmap_pkg::ADDRESS_WIDTH-1:0]),
      .read_i       (read_i && at[0]),
      .write_i      (write_i && at[0]),
      .writedata_i,
      .readdata_o   (data_block[31:0]),
      .waitrequest_o(wait_block[0]),
      .irq_o,
      .measured_i   (measured_o),
      .command_o,
      .command_valid_o,
      .period_o,
      .finished_o,
      .stop_o,
      .trace_store_o,
      .trace_cycles_o,
      .trace_index_o,
      .trace_data_o
  );

  core_bus u_bus (
      .clk_i,
      .rst_ni,
      .host_read_i        (read_i && at[1]),
      .host_write_i       (write_i && at[1]),
      .host_address_i     (address_i[asip_regmap_pkg::ADDRESS_WIDTH-1:0]),
      .host_data_i        (writedata_i),
      .host_wait_o        (wait_block[1]),
      .sequencer_read_i   (link_read),
      .sequencer_write_i  (link_write),
      .sequencer_address_i(link_address),
      .sequencer_data_i   (link_data),
      .sequencer_wait_o   (link_wait),
      .read_o             (read),
      .write_o            (write),
      .address_o          (address),
      .data_o             (data),
      .wait_i             (core_wait)
  );

  asip #(
      .FmaPipes(CurrentFmaPipes),
      .Slots   (CurrentSlots)
  ) u_current (
      .clk_i,
      .rst_ni,
      .address_i    (address),
      .read_i       (read),
      .write_i      (write),
      .writedata_i  (data),
      .readdata_o   (data_block[63:32]),
      .waitrequest_o(core_wait),
      .irq_o        (core_irq),
      .trace_issue_o(trace_issue),
      .trace_pc_o   (trace_pc),
      .trace_write_o(trace_write),
      .trace_index_o(trace_index),
      .trace_data_o (trace_data),
      .hook_i       ('0),
      .hook_o       (hook)
  );

  drive_front_end #(
      .Axes       (Axes),
      .ThirdSensor(ThirdSensor),
      .EdgeStamps (EdgeStamps)
  ) u_front_end (
      .clk_i,
      .rst_ni,
      .address_i         (address_i[drive_regmap_pkg::ADDRESS_WIDTH-1:0]),
      .read_i            (read_i && at[2]),
      .write_i           (write_i && at[2]),
      .writedata_i,
      .readdata_o        (data_block[95:64]),
      .waitrequest_o     (wait_block[2]),
      .core_address_o    (link_address),
      .core_read_o       (link_read),
      .core_write_o      (link_write),
      .core_writedata_o  (link_data),
      .core_readdata_i   (data_block[63:32]),
      .core_waitrequest_i(link_wait),
      .core_irq_i        (core_irq),
      .order_i           (command_o),
      .stop_i            (stop_o),
      .position_o        (measured_o),
      .a_i,
      .b_i,
      .z_i,
      .external_position_i('0),
      .external_fault_i  ('0),
      .external_count_i  ('0),
      .external_clear_o  (unused_clear),
      .mclk_o,
      .bit_a_i,
      .bit_b_i,
      .bit_c_i,
      .bus_i,
      .fault_i,
      .high_o,
      .low_o,
      .release_o,
      .chopper_o
  );

  assign unused_trace  = ^{trace_issue, trace_pc, trace_write, trace_index, trace_data, hook};
  assign waitrequest_o = |(wait_block & at);
  assign readdata_o    = (data_block[31:0] & {32{at[0]}}) | (data_block[63:32] & {32{at[1]}})
                         | (data_block[95:64] & {32{at[2]}});

endmodule
