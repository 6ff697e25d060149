// SPDX-License-Identifier: Apache-2.0
// absolute_registers: the registers of one absolute encoder as an Avalon-MM agent, in front of any protocol's master.
// Contract: register map docs/absolute_regmap.md, 32-bit word accesses, writes one cycle, reads two. request_o, high for a
// clock, asks the master for a frame: by CONTROL.start or, with TRIGGER.sample, by sample_i, in the same clock. The
// master answers with busy_i from the next clock on, or with done_i and lost_i in the next clock. done_i is high for a
// clock at the end of a frame; the other inputs then hold until the next end. A request while busy_i is dropped and flagged.
module absolute_registers #(
    parameter logic [31:0] Id           = absolute_regmap_pkg::RESET_ID,
    parameter int unsigned Width        = 26,  // 1..64
    parameter int unsigned ClocksPerBit = 10,  // below 256
    parameter int unsigned Limit        = 400  // below 65536
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
    // master of the protocol
    output logic             request_o,
    input  logic             busy_i,
    input  logic             done_i,
    input  logic [Width-1:0] position_i,
    input  logic             error_i,
    input  logic             warning_i,
    input  logic             crc_error_i,
    input  logic             lost_i,
    input  logic [15:0]      delay_i
);

  logic read_q, control_write, clear, low_read, good;
  logic sample_q, ended_q, missed_q;
  logic [15:0] crc_count_q, lost_count_q;
  logic [31:0] good_q, high_q, readdata_q, read_data, unused_writedata;
  logic [31:0] config_word, status_word, trigger_word, bad_word;
  logic [63:0] position;

  assign control_write = write_i && address_i == absolute_regmap_pkg::REG_CONTROL;
  assign clear         = control_write && writedata_i[absolute_regmap_pkg::CONTROL_CLEAR_LSB];
  assign request_o     = (control_write && writedata_i[absolute_regmap_pkg::CONTROL_START_LSB])
                         || (sample_i && sample_q);
  assign low_read      = read_i && !read_q && address_i == absolute_regmap_pkg::REG_POSITION_LOW;
  assign good          = !crc_error_i && !lost_i;
  assign position      = 64'(position_i);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      read_q       <= 1'b0;
      sample_q     <= absolute_regmap_pkg::RESET_TRIGGER[absolute_regmap_pkg::TRIGGER_SAMPLE_LSB];
      ended_q      <= 1'b0;
      missed_q     <= 1'b0;
      good_q       <= '0;
      crc_count_q  <= '0;
      lost_count_q <= '0;
    end else begin
      read_q   <= read_i && !read_q;
      ended_q  <= ended_q || done_i;
      missed_q <= (missed_q && !clear) || (request_o && busy_i);
      if (write_i && address_i == absolute_regmap_pkg::REG_TRIGGER)
        sample_q <= writedata_i[absolute_regmap_pkg::TRIGGER_SAMPLE_LSB];
      if (clear) begin
        good_q       <= '0;
        crc_count_q  <= '0;
        lost_count_q <= '0;
      end else if (done_i) begin
        if (good) good_q <= good_q + 32'd1;
        if (crc_error_i && crc_count_q != '1) crc_count_q <= crc_count_q + 16'd1;
        if (lost_i && lost_count_q != '1) lost_count_q <= lost_count_q + 16'd1;
      end
    end
  end

  always_comb begin
    config_word  = 32'd0;
    status_word  = 32'd0;
    trigger_word = 32'd0;
    bad_word     = 32'd0;
    config_word[absolute_regmap_pkg::CONFIG_WIDTH_LSB+:absolute_regmap_pkg::CONFIG_WIDTH_WIDTH] =
        absolute_regmap_pkg::CONFIG_WIDTH_WIDTH'(Width);
    config_word[absolute_regmap_pkg::CONFIG_BIT_CLOCKS_LSB+:absolute_regmap_pkg::CONFIG_BIT_CLOCKS_WIDTH] =
        absolute_regmap_pkg::CONFIG_BIT_CLOCKS_WIDTH'(ClocksPerBit);
    config_word[absolute_regmap_pkg::CONFIG_LIMIT_LSB+:16]  = 16'(Limit);
    status_word[absolute_regmap_pkg::STATUS_BUSY_LSB]       = busy_i;
    status_word[absolute_regmap_pkg::STATUS_VALID_LSB]      = (ended_q || done_i) && good;
    status_word[absolute_regmap_pkg::STATUS_CRC_LSB]        = crc_error_i;
    status_word[absolute_regmap_pkg::STATUS_LOST_LSB]       = lost_i;
    status_word[absolute_regmap_pkg::STATUS_ERROR_LSB]      = error_i;
    status_word[absolute_regmap_pkg::STATUS_WARNING_LSB]    = warning_i;
    status_word[absolute_regmap_pkg::STATUS_MISSED_LSB]     = missed_q;
    trigger_word[absolute_regmap_pkg::TRIGGER_SAMPLE_LSB]   = sample_q;
    bad_word[absolute_regmap_pkg::BAD_CRC_LSB+:16]          = crc_count_q;
    bad_word[absolute_regmap_pkg::BAD_LOST_LSB+:16]         = lost_count_q;
  end

  always_comb begin
    case (address_i)
      absolute_regmap_pkg::REG_ID:            read_data = Id;
      absolute_regmap_pkg::REG_CONFIG:        read_data = config_word;
      absolute_regmap_pkg::REG_STATUS:        read_data = status_word;
      absolute_regmap_pkg::REG_TRIGGER:       read_data = trigger_word;
      absolute_regmap_pkg::REG_POSITION_LOW:  read_data = position[31:0];
      absolute_regmap_pkg::REG_POSITION_HIGH: read_data = high_q;
      absolute_regmap_pkg::REG_GOOD:          read_data = good_q;
      absolute_regmap_pkg::REG_BAD:           read_data = bad_word;
      absolute_regmap_pkg::REG_DELAY:         read_data = 32'(delay_i);
      default:                            read_data = 32'd0;
    endcase
  end

  always_ff @(posedge clk_i) begin
    readdata_q <= read_data;
    if (low_read) high_q <= position[63:32];
  end

  assign readdata_o       = readdata_q;
  assign waitrequest_o    = read_i && !read_q;
  assign unused_writedata = writedata_i;

endmodule
