// SPDX-License-Identifier: Apache-2.0
// asip_ecp5: what every ECP5 board carries: the ASIP with its debug block on a serial line, the motion
// front-end's step and direction, incremental encoders.
// Contract: osc_i is the board's oscillator, button_ni resets while low. The serial port (docs/debug_block.md)
// reaches the core, the debug block, and from word 0x6000 on the machine: 0x6000 the motion front-end
// (docs/motion_regmap.md), 0x7000 the encoders (encoder_registers). Reset asserts at once and is released two
// core clocks after the button is up and the PLL locked. alive_o changes every 2^25 clocks.
module asip_ecp5 #(
    parameter int unsigned FmaPipes    = 1,
    parameter int unsigned Slots       = 1,
    parameter int unsigned Axes        = 5,
    parameter int unsigned Clock       = 100,  // MHz, after the PLL
    parameter int unsigned UartDivider = 33,   // clocks a bit after reset
    parameter int unsigned PllInput    = 1,
    parameter int unsigned PllFeedback = 4,
    parameter int unsigned PllOutput   = 6
) (
    input  logic            osc_i,
    input  logic            button_ni,
    // serial line
    input  logic            rx_i,
    output logic            tx_o,
    // drives
    output logic [Axes-1:0] step_o,
    output logic [Axes-1:0] direction_o,
    // encoders, asynchronous
    input  logic [Axes-1:0] a_i,
    input  logic [Axes-1:0] b_i,
    input  logic [Axes-1:0] z_i,
    // lamps
    output logic            alive_o,
    output logic            held_o,   // the core is held by the debug block
    output logic            irq_o     // done or a fault, as far as enabled
);

  localparam int unsigned MotionWidth = motion_regmap_pkg::ADDRESS_WIDTH;

  logic clk, locked, reset_request, release_q, rst_nq;
  logic [25:0] alive_q;
  logic machine_read, machine_write, machine_wait, at_encoders;
  logic [12:0] machine_address;
  logic [31:0] machine_writedata, motion_readdata, encoder_readdata;
  logic motion_wait, encoder_wait, motion_irq;
  logic unused_wait;
  logic [31:0] unused_readdata;
  logic trace_issue;
  logic [15:0] trace_pc;
  logic [3:0] trace_write;
  logic [2:0][5:0] trace_index;
  logic [2:0][31:0] trace_data;

  ecp5_pll #(
      .Input   (PllInput),
      .Feedback(PllFeedback),
      .Output  (PllOutput)
  ) u_pll (
      .osc_i,
      .clk_o   (clk),
      .locked_o(locked)
  );

  // Reset synchroniser.
  assign reset_request = !button_ni || !locked;
  always_ff @(posedge clk or posedge reset_request) begin
    if (reset_request) begin
      release_q <= 1'b0;
      rst_nq    <= 1'b0;
    end else begin
      release_q <= 1'b1;
      rst_nq    <= release_q;
    end
  end

  always_ff @(posedge clk or negedge rst_nq) begin
    if (!rst_nq) alive_q <= '0;
    else alive_q <= alive_q + 26'd1;
  end
  assign alive_o = alive_q[25];

  debug_asip #(
      .FmaPipes   (FmaPipes),
      .Slots      (Slots),
      .UartDivider(UartDivider)
  ) u_asip (
      .clk_i               (clk),
      .rst_ni              (rst_nq),
      .address_i           ('0),
      .read_i              (1'b0),
      .write_i             (1'b0),
      .writedata_i         ('0),
      .readdata_o          (unused_readdata),
      .waitrequest_o       (unused_wait),
      .irq_o               (irq_o),
      .rx_i,
      .tx_o,
      .debug_active_o      (held_o),
      .machine_address_o   (machine_address),
      .machine_read_o      (machine_read),
      .machine_write_o     (machine_write),
      .machine_writedata_o (machine_writedata),
      .machine_readdata_i  (at_encoders ? encoder_readdata : motion_readdata),
      .machine_waitrequest_i(machine_wait),
      .trace_issue_o       (trace_issue),
      .trace_pc_o          (trace_pc),
      .trace_write_o       (trace_write),
      .trace_index_o       (trace_index),
      .trace_data_o        (trace_data)
  );

  assign at_encoders  = machine_address[12];
  assign machine_wait = at_encoders ? encoder_wait : motion_wait;

  motion_front_end #(
      .Axes         (Axes),
      .ClocksPerTick(Clock),
      .Interpolators(0)
  ) u_motion (
      .clk_i        (clk),
      .rst_ni       (rst_nq),
      .address_i    (machine_address[MotionWidth-1:0]),
      .read_i       (machine_read && !at_encoders),
      .write_i      (machine_write && !at_encoders),
      .writedata_i  (machine_writedata),
      .readdata_o   (motion_readdata),
      .waitrequest_o(motion_wait),
      .irq_o        (motion_irq),
      .step_o,
      .direction_o
  );

  encoder_registers #(
      .Axes(Axes)
  ) u_encoders (
      .clk_i        (clk),
      .rst_ni       (rst_nq),
      .address_i    (machine_address[4:0]),
      .read_i       (machine_read && at_encoders),
      .write_i      (machine_write && at_encoders),
      .readdata_o   (encoder_readdata),
      .waitrequest_o(encoder_wait),
      .a_i,
      .b_i,
      .z_i
  );

  logic unused_rest;
  assign unused_rest = ^{trace_issue, trace_pc, trace_write, trace_index, trace_data, motion_irq,
                         machine_address[11:MotionWidth]};

endmodule
