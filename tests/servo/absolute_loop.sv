// SPDX-License-Identifier: Apache-2.0
// absolute_loop: a BiSS-C encoder without lines A and B on a drive axis, as docs/drive.md connects them.
module absolute_loop #(
    parameter int unsigned Width  = 26,
    parameter int unsigned Period = 1250
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic [drive_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic        read_i,
    input  logic        write_i,
    input  logic [31:0] writedata_i,
    output logic [31:0] readdata_o,
    output logic        waitrequest_o,
    input  logic        trigger_i,      // writes TRIGGER.sample of the port
    output logic [31:0] position_o,
    output logic [2:0]  low_o,
    output logic        ma_o,
    input  logic        slo_i
);

  logic request, busy, done, good, clear, jump, lost, unused;
  logic [Width-1:0] word;
  logic [31:0] count, core_writedata, port_data;
  logic [7:0] bad;
  logic [13:0] core_address;
  logic core_read, core_write, mclk, brake, chopper, port_wait;
  logic [2:0] high;

  biss_port #(
      .Width(Width)
  ) u_port (
      .clk_i,
      .rst_ni,
      .address_i    (absolute_regmap_pkg::REG_TRIGGER),
      .read_i       (1'b0),
      .write_i      (trigger_i),
      .writedata_i  (32'd1),
      .readdata_o   (port_data),
      .waitrequest_o(port_wait),
      .sample_i     (request),
      .busy_o       (busy),
      .done_o       (done),
      .good_o       (good),
      .position_o   (word),
      .ma_o,
      .slo_i
  );

  absolute_position #(
      .Width  (Width),
      .Period (Period),
      .Instant(6)
  ) u_position (
      .clk_i,
      .rst_ni,
      .request_o  (request),
      .busy_i     (busy),
      .done_i     (done),
      .good_i     (good),
      .position_i (word),
      .clear_i    (clear),
      .position_o (count),
      .jump_o     (jump),
      .lost_o     (lost),
      .bad_count_o(bad)
  );

  drive_front_end #(
      .Axes    (1),
      .External(1)
  ) u_front_end (
      .clk_i,
      .rst_ni,
      .address_i,
      .read_i,
      .write_i,
      .writedata_i,
      .readdata_o,
      .waitrequest_o,
      .core_address_o     (core_address),
      .core_read_o        (core_read),
      .core_write_o       (core_write),
      .core_writedata_o   (core_writedata),
      .core_readdata_i    ('0),
      .core_waitrequest_i (1'b0),
      .core_irq_i         (1'b0),
      .order_i            ('0),
      .stop_i             (1'b0),
      .position_o,
      .a_i                (1'b0),
      .b_i                (1'b0),
      .z_i                (1'b0),
      .external_position_i(count),
      .external_fault_i   (jump || lost),
      .external_count_i   (bad),
      .external_clear_o   (clear),
      .mclk_o             (mclk),
      .bit_a_i            (mclk),
      .bit_b_i            (mclk),
      .bit_c_i            (1'b0),
      .bus_i              ('0),
      .fault_i            (1'b0),
      .high_o             (high),
      .low_o,
      .release_o          (brake),
      .chopper_o          (chopper)
  );

  assign unused = ^{port_data, port_wait, core_address, core_read, core_write, core_writedata, brake, chopper, high};

endmodule
