// SPDX-License-Identifier: Apache-2.0
// endat_port: one absolute encoder on EnDat (endat_master) as an Avalon-MM agent (absolute_registers).
// Contract: register map docs/absolute_regmap.md, where ID is 'ENDT', 32-bit word accesses, writes one cycle, reads two.
// A frame is requested by CONTROL.start or, with TRIGGER.sample, by sample_i; clock_o falls in the next clock, the instant of
// the position. STATUS.error is F1 or, with Endat22, F2; STATUS.warning is 0. A frame ends with its last bit; STATUS.busy stays
// set for the encoder's recovery time, and a request before that is dropped and flagged. The first frame after a reset and
// each frame after a lost one is slow (MeasureClocks a bit) and measures DELAY. Positions are the encoder's counts,
// unsigned. No access to the encoder's memory, no additional data.
module endat_port #(
    parameter int unsigned Width          = 25,    // 1..48
    parameter int unsigned ClocksPerBit   = 14,    // 6..254, even
    parameter int unsigned Limit          = 400,   // bits from the request to the start bit, 13..65535
    parameter bit          Endat22        = 1'b1,
    parameter int unsigned StartClocks    = 200,   // more of the first low phase
    parameter int unsigned RecoveryClocks = 3000,  // longest recovery time of the encoder
    parameter int unsigned MeasureClocks  = 400    // even, ClocksPerBit to (Width + 5) * ClocksPerBit, below 32768
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
    output logic        data_o,
    output logic        data_en_o,      // direction: 1 to the encoder
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
      .Id          (32'h454E4454),  // 'ENDT'
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

  endat_master #(
      .Width         (Width),
      .ClocksPerBit  (ClocksPerBit),
      .Limit         (Limit),
      .Endat22       (Endat22),
      .StartClocks   (StartClocks),
      .RecoveryClocks(RecoveryClocks),
      .MeasureClocks (MeasureClocks)
  ) u_master (
      .clk_i,
      .rst_ni,
      .start_i    (request),
      .clock_o,
      .data_o,
      .data_en_o,
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
    if (Width < 1 || Width > 48) begin : gen_check_width
      $error("endat_port: Width=%0d, must be 1..48", Width);
    end
    if (ClocksPerBit < 6 || ClocksPerBit > 254 || ClocksPerBit % 2 != 0) begin : gen_check_bit
      $error("endat_port: ClocksPerBit=%0d, must be even, 6..254", ClocksPerBit);
    end
    if (Limit < 13 || Limit > 65535) begin : gen_check_limit
      $error("endat_port: Limit=%0d, must be 13..65535", Limit);
    end
    if (RecoveryClocks < 1) begin : gen_check_recovery
      $error("endat_port: RecoveryClocks=%0d, must be at least 1", RecoveryClocks);
    end
    if (MeasureClocks < ClocksPerBit || MeasureClocks > (Width + 5) * ClocksPerBit || MeasureClocks > 32767
        || MeasureClocks % 2 != 0) begin : gen_check_measure
      $error(
          "endat_port: MeasureClocks=%0d, must be even, ClocksPerBit .. (Width + 5) * ClocksPerBit, below 32768",
          MeasureClocks
      );
    end
  endgenerate
`endif

endmodule
