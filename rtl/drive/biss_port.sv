// SPDX-License-Identifier: Apache-2.0
// biss_port: one absolute encoder on BiSS-C (biss_master) as an Avalon-MM agent (absolute_registers).
// Contract: register map docs/absolute_regmap.md, 32-bit word accesses, writes one cycle, reads two. A frame
// is requested by CONTROL.start or, with TRIGGER.sample, by sample_i; ma_o falls in the next clock and
// rises, the instant of the position, ClocksPerBit / 2 clocks later. So ports with one sample_i and one
// ClocksPerBit read at one instant. A request while a frame is on its way is dropped and flagged; one before
// the encoder's time-out has passed ends at once, lost. Positions are the encoder's counts, unsigned.
// Frame, CRC and line: biss_master, by the BiSS C protocol description (iC-Haus); no access to the encoder's registers.
module biss_port #(
    parameter int unsigned Width        = 26,  // 1..64
    parameter int unsigned ClocksPerBit = 10,  // 6..62, even
    parameter int unsigned Limit        = 400  // bits from the request to the start bit, below 65536
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
    output logic        ma_o,
    input  logic        slo_i           // asynchronous
);

  logic request, busy, done, error, warning, crc_error, lost;
  logic [15:0] delay;
  logic [Width-1:0] position;

  assign busy_o     = busy;
  assign done_o     = done;
  assign good_o     = !crc_error && !lost && !error;
  assign position_o = position;

  absolute_registers #(
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
      .warning_i  (warning),
      .crc_error_i(crc_error),
      .lost_i     (lost),
      .delay_i    (delay)
  );

  biss_master #(
      .Width       (Width),
      .ClocksPerBit(ClocksPerBit),
      .Limit       (Limit)
  ) u_master (
      .clk_i,
      .rst_ni,
      .start_i    (request),
      .ma_o,
      .slo_i,
      .busy_o     (busy),
      .done_o     (done),
      .position_o (position),
      .error_o    (error),
      .warning_o  (warning),
      .crc_error_o(crc_error),
      .lost_o     (lost),
      .delay_o    (delay)
  );

`ifndef SYNTHESIS
  generate
    if (Width < 1 || Width > 64) begin : gen_check_width
      $error("biss_port: Width=%0d, must be 1..64", Width);
    end
    if (ClocksPerBit < 6 || ClocksPerBit > 62 || ClocksPerBit % 2 != 0) begin : gen_check_bit
      $error("biss_port: ClocksPerBit=%0d, must be even, 6..62", ClocksPerBit);
    end
    if (Limit > 65535) begin : gen_check_limit
      $error("biss_port: Limit=%0d, must be below 65536", Limit);
    end
  endgenerate
`endif

endmodule
