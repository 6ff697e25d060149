// SPDX-License-Identifier: Apache-2.0
// external_axes: two drive axes without lines A and B: sine and cosine lines on axis 0, Hall lines on axis 1.
module external_axes (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic [drive_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic        read_i,
    input  logic        write_i,
    input  logic [31:0] writedata_i,
    output logic [31:0] readdata_o,
    output logic        waitrequest_o,
    input  logic        bit_sine_i,
    input  logic        bit_cosine_i,
    input  logic        u_i,
    input  logic        v_i,
    input  logic        w_i,
    output logic [63:0] position_o,
    output logic [5:0]  low_o
);

  logic [63:0] count;
  logic [15:0] bad;
  logic [1:0] clear, brake;
  logic [5:0] high;
  logic [31:0] core_writedata;
  logic [13:0] core_address;
  logic core_read, core_write, mclk, chopper, strobe, done, jump, lost, skipped, illegal, unused;

  sincos_loop u_sincos (
      .clk_i,
      .rst_ni,
      .strobe_o    (strobe),
      .bit_sine_i,
      .bit_cosine_i,
      .clear_i     (clear[0]),
      .position_o  (count[31:0]),
      .jump_o      (jump),
      .lost_o      (lost),
      .bad_count_o (bad[7:0]),
      .done_o      (done)
  );

  hall_decoder u_hall (
      .clk_i,
      .rst_ni,
      .u_i,
      .v_i,
      .w_i,
      .clear_i    (clear[1]),
      .position_o (count[63:32]),
      .jump_o     (skipped),
      .illegal_o  (illegal),
      .bad_count_o(bad[15:8])
  );

  drive_front_end #(
      .Axes    (2),
      .External(3)
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
      .a_i                ('0),
      .b_i                ('0),
      .z_i                ('0),
      .external_position_i(count),
      .external_fault_i   ({skipped || illegal, jump || lost}),
      .external_count_i   (bad),
      .external_clear_o   (clear),
      .mclk_o             (mclk),
      .bit_a_i            ({2{mclk}}),
      .bit_b_i            ({2{mclk}}),
      .bit_c_i            ('0),
      .bus_i              ('0),
      .fault_i            ('0),
      .high_o             (high),
      .low_o,
      .release_o          (brake),
      .chopper_o          (chopper)
  );

  assign unused = ^{core_address, core_read, core_write, core_writedata, brake, chopper, high, strobe, done};

endmodule
