// SPDX-License-Identifier: Apache-2.0
// ssi_port: one absolute encoder on SSI (ssi_master) as an Avalon-MM agent (absolute_registers).
// Contract: register map docs/absolute_regmap.md, where ID is 'SSI ', 32-bit word accesses, writes one cycle, reads two.
// A frame is requested by CONTROL.start or, with TRIGGER.sample, by sample_i; clock_o falls in the next clock, the instant of
// the position. STATUS.crc is a wrong parity or a second word that differs; without Parity and Repeat it is never set.
// STATUS.error is the alarm bit, STATUS.warning is 0, DELAY is the encoder's monoflop time and 2 clocks. The frame ends when
// that time is over; a request before that is dropped and flagged. Positions are the encoder's counts, unsigned.
module ssi_port #(
    parameter int unsigned Width        = 25,   // 1..64
    parameter int unsigned ClocksPerBit = 100,  // 6..254, even
    parameter int unsigned Limit        = 60,   // bits from the last rising edge to the line's rise, below 65536
    parameter bit          Gray         = 1'b0,
    parameter bit          Alarm        = 1'b0,
    parameter int unsigned Parity       = 0,    // 0 none, 1 even, 2 odd
    parameter bit          Repeat       = 1'b0
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    // Avalon-MM agent
    input  logic [absolute_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic        read_i,
    input  logic        write_i,
    input  logic [31:0] writedata_i,
    output logic [31:0] readdata_o,
    output logic        waitrequest_o,
    // sampling instant of all encoders, a clock
    input  logic        sample_i,
    // absolute_position: end of a frame, and whether it brought a right position
    output logic        busy_o,
    output logic        done_o,
    output logic        good_o,
    output logic [Width-1:0] position_o,
    // encoder
    output logic        clock_o,
    input  logic        data_i          // asynchronous
);

  logic request, busy, done, error, crc_error, lost;
  logic [15:0] delay;
  logic [Width-1:0] position;

  assign busy_o     = busy;
  assign done_o     = done;
  assign good_o     = !crc_error && !lost && !error;
  assign position_o = position;

  absolute_registers #(
      .Id          (32'h53534920),  // 'SSI '
      .Width       (Width),
      .ClocksPerBit(ClocksPerBit),
      .Limit       (Limit)
  ) u_registers (
      .clk_i,
      .rst_ni,
      .address_i,
      .read_i,
      .write_i,
      .writedata_i,
      .readdata_o,
      .waitrequest_o,
      .sample_i,
      .request_o  (request),
      .busy_i     (busy),
      .done_i     (done),
      .position_i (position),
      .error_i    (error),
      .warning_i  (1'b0),
      .crc_error_i(crc_error),
      .lost_i     (lost),
      .delay_i    (delay)
  );

  ssi_master #(
      .Width       (Width),
      .ClocksPerBit(ClocksPerBit),
      .Limit       (Limit),
      .Gray        (Gray),
      .Alarm       (Alarm),
      .Parity      (Parity),
      .Repeat      (Repeat)
  ) u_master (
      .clk_i,
      .rst_ni,
      .start_i    (request),
      .clock_o,
      .data_i,
      .busy_o     (busy),
      .done_o     (done),
      .position_o (position),
      .error_o    (error),
      .crc_error_o(crc_error),
      .lost_o     (lost),
      .delay_o    (delay)
  );

`ifndef SYNTHESIS
  generate
    if (Width < 1 || Width > 64) begin : gen_check_width
      $error("ssi_port: Width=%0d, must be 1..64", Width);
    end
    if (ClocksPerBit < 6 || ClocksPerBit > 254 || ClocksPerBit % 2 != 0) begin : gen_check_bit
      $error("ssi_port: ClocksPerBit=%0d, must be even, 6..254", ClocksPerBit);
    end
    if (Limit > 65535) begin : gen_check_limit
      $error("ssi_port: Limit=%0d, must be below 65536", Limit);
    end
    if (Parity > 2) begin : gen_check_parity
      $error("ssi_port: Parity=%0d, must be 0 (none), 1 (even) or 2 (odd)", Parity);
    end
  endgenerate
`endif

endmodule
