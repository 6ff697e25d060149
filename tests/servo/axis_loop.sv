// SPDX-License-Identifier: Apache-2.0
// axis_loop: one axis' front-end and the processor of its current loop, for tests/servo/axis_latency.py.
// Contract: a write_i goes to the front-end with front_i, else to the processor, and takes a clock while
// wait_o is low. instant_o: the samples are taken; in_force_o: the compare values made of them are in the
// bridge, all of one clock; fault_o: a run ended with a fault.
module axis_loop #(
    parameter int unsigned FmaPipes = 2,
    parameter int unsigned Slots    = 3
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        write_i,
    input  logic        front_i,
    input  logic [asip_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic [31:0] writedata_i,
    input  logic        bits_i,
    output logic        wait_o,
    output logic        instant_o,
    output logic        in_force_o,
    output logic        fault_o
);

  logic [13:0] link_address, address;
  logic [31:0] link_data, data, readdata, unused_readdata, unused_position;
  logic link_read, link_write, link_wait, read, write, core_wait, core_irq;
  logic front_wait, host_wait, unused_mclk, unused_release, unused_chopper;
  logic [2:0] unused_high, unused_low;

  core_bus u_bus (
      .clk_i,
      .rst_ni,
      .host_read_i        (1'b0),
      .host_write_i       (write_i && !front_i),
      .host_address_i     (address_i),
      .host_data_i        (writedata_i),
      .host_wait_o        (host_wait),
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
      .FmaPipes(FmaPipes),
      .Slots   (Slots)
  ) u_core (
      .clk_i,
      .rst_ni,
      .address_i    (address),
      .read_i       (read),
      .write_i      (write),
      .writedata_i  (data),
      .readdata_o   (readdata),
      .waitrequest_o(core_wait),
      .irq_o        (core_irq),
      .trace_issue_o(),
      .trace_pc_o   (),
      .trace_write_o(),
      .trace_index_o(),
      .trace_data_o (),
      .hook_i       ('0),
      .hook_o       ()
  );

  drive_front_end #(
      .Axes(1)
  ) u_front_end (
      .clk_i,
      .rst_ni,
      .address_i         (address_i[drive_regmap_pkg::ADDRESS_WIDTH-1:0]),
      .read_i            (1'b0),
      .write_i           (write_i && front_i),
      .writedata_i,
      .readdata_o        (unused_readdata),
      .waitrequest_o     (front_wait),
      .core_address_o    (link_address),
      .core_read_o       (link_read),
      .core_write_o      (link_write),
      .core_writedata_o  (link_data),
      .core_readdata_i   (readdata),
      .core_waitrequest_i(link_wait),
      .core_irq_i        (core_irq),
      .order_i           ('0),
      .stop_i            (1'b0),
      .position_o        (unused_position),
      .a_i               (1'b0),
      .b_i               (1'b0),
      .z_i               (1'b0),
      .mclk_o            (unused_mclk),
      .bit_a_i           (bits_i),
      .bit_b_i           (bits_i),
      .bit_c_i           (1'b0),
      .bus_i             (16'd11200),
      .fault_i           (1'b0),
      .high_o            (unused_high),
      .low_o             (unused_low),
      .release_o         (unused_release),
      .chopper_o         (unused_chopper)
  );

  assign wait_o     = front_i ? front_wait : host_wait;
  assign instant_o  = u_front_end.done;
  assign in_force_o = u_front_end.gen_axis[0].u_axis.commit_i;
  assign fault_o    = u_front_end.link_fault;

endmodule
