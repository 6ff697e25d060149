// SPDX-License-Identifier: Apache-2.0
// biss_port: one absolute encoder on BiSS-C (biss_master) as an Avalon-MM agent.
// Contract: register map docs/biss_regmap.md, 32-bit word accesses, writes one cycle, reads two. A frame
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
    input  logic [biss_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic        read_i,
    input  logic        write_i,
    input  logic [31:0] writedata_i,
    output logic [31:0] readdata_o,
    output logic        waitrequest_o,
    // sampling instant of all encoders, a clock
    input  logic        sample_i,
    // encoder
    output logic        ma_o,
    input  logic        slo_i           // asynchronous
);

  logic read_q, control_write, clear, request, low_read;
  logic sample_q, ended_q, missed_q;
  logic busy, done, error, warning, crc_error, lost, good;
  logic [15:0] delay, crc_count_q, lost_count_q;
  logic [31:0] good_q, high_q, readdata_q, read_data, unused_writedata;
  logic [31:0] config_word, status_word, trigger_word, bad_word;
  logic [63:0] position;
  logic [Width-1:0] bits;

  assign control_write = write_i && address_i == biss_regmap_pkg::REG_CONTROL;
  assign clear         = control_write && writedata_i[biss_regmap_pkg::CONTROL_CLEAR_LSB];
  assign request       = (control_write && writedata_i[biss_regmap_pkg::CONTROL_START_LSB])
                         || (sample_i && sample_q);
  assign low_read      = read_i && !read_q && address_i == biss_regmap_pkg::REG_POSITION_LOW;
  assign good          = !crc_error && !lost;
  assign position      = 64'(bits);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      read_q       <= 1'b0;
      sample_q     <= biss_regmap_pkg::RESET_TRIGGER[biss_regmap_pkg::TRIGGER_SAMPLE_LSB];
      ended_q      <= 1'b0;
      missed_q     <= 1'b0;
      good_q       <= '0;
      crc_count_q  <= '0;
      lost_count_q <= '0;
    end else begin
      read_q   <= read_i && !read_q;
      ended_q  <= ended_q || done;
      missed_q <= (missed_q && !clear) || (request && busy);
      if (write_i && address_i == biss_regmap_pkg::REG_TRIGGER)
        sample_q <= writedata_i[biss_regmap_pkg::TRIGGER_SAMPLE_LSB];
      if (clear) begin
        good_q       <= '0;
        crc_count_q  <= '0;
        lost_count_q <= '0;
      end else if (done) begin
        if (good) good_q <= good_q + 32'd1;
        if (crc_error && crc_count_q != '1) crc_count_q <= crc_count_q + 16'd1;
        if (lost && lost_count_q != '1) lost_count_q <= lost_count_q + 16'd1;
      end
    end
  end

  always_comb begin
    config_word  = 32'd0;
    status_word  = 32'd0;
    trigger_word = 32'd0;
    bad_word     = 32'd0;
    config_word[biss_regmap_pkg::CONFIG_WIDTH_LSB+:biss_regmap_pkg::CONFIG_WIDTH_WIDTH] =
        biss_regmap_pkg::CONFIG_WIDTH_WIDTH'(Width);
    config_word[biss_regmap_pkg::CONFIG_BIT_CLOCKS_LSB+:biss_regmap_pkg::CONFIG_BIT_CLOCKS_WIDTH] =
        biss_regmap_pkg::CONFIG_BIT_CLOCKS_WIDTH'(ClocksPerBit);
    config_word[biss_regmap_pkg::CONFIG_LIMIT_LSB+:16]  = 16'(Limit);
    status_word[biss_regmap_pkg::STATUS_BUSY_LSB]       = busy;
    status_word[biss_regmap_pkg::STATUS_VALID_LSB]      = (ended_q || done) && good;
    status_word[biss_regmap_pkg::STATUS_CRC_LSB]        = crc_error;
    status_word[biss_regmap_pkg::STATUS_LOST_LSB]       = lost;
    status_word[biss_regmap_pkg::STATUS_ERROR_LSB]      = error;
    status_word[biss_regmap_pkg::STATUS_WARNING_LSB]    = warning;
    status_word[biss_regmap_pkg::STATUS_MISSED_LSB]     = missed_q;
    trigger_word[biss_regmap_pkg::TRIGGER_SAMPLE_LSB]   = sample_q;
    bad_word[biss_regmap_pkg::BAD_CRC_LSB+:16]          = crc_count_q;
    bad_word[biss_regmap_pkg::BAD_LOST_LSB+:16]         = lost_count_q;
  end

  always_comb begin
    case (address_i)
      biss_regmap_pkg::REG_ID:            read_data = biss_regmap_pkg::RESET_ID;
      biss_regmap_pkg::REG_CONFIG:        read_data = config_word;
      biss_regmap_pkg::REG_STATUS:        read_data = status_word;
      biss_regmap_pkg::REG_TRIGGER:       read_data = trigger_word;
      biss_regmap_pkg::REG_POSITION_LOW:  read_data = position[31:0];
      biss_regmap_pkg::REG_POSITION_HIGH: read_data = high_q;
      biss_regmap_pkg::REG_GOOD:          read_data = good_q;
      biss_regmap_pkg::REG_BAD:           read_data = bad_word;
      biss_regmap_pkg::REG_DELAY:         read_data = 32'(delay);
      default:                            read_data = 32'd0;
    endcase
  end

  always_ff @(posedge clk_i) begin
    readdata_q <= read_data;
    if (low_read) high_q <= position[63:32];
  end

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
      .position_o (bits),
      .error_o    (error),
      .warning_o  (warning),
      .crc_error_o(crc_error),
      .lost_o     (lost),
      .delay_o    (delay)
  );

  assign readdata_o       = readdata_q;
  assign waitrequest_o    = read_i && !read_q;
  assign unused_writedata = writedata_i;

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
