// SPDX-License-Identifier: Apache-2.0
// biss_master: reads the position of one absolute encoder over BiSS-C, point to point, sensor data only.
// Contract: start_i begins a frame; the encoder takes its position with the first rising edge of ma_o,
// ClocksPerBit / 2 + 1 clocks after start_i. A frame is acknowledge (0), start (1), CDS, Width bits of position, most
// significant first, error and warning (active low), 6 bits of CRC, x^6 + x + 1, inverted. Bits are taken
// in their middle, counted from the start bit's edge as it arrives: any delay of lines and encoder
// is compensated. done_o is high for a clock at the end of the frame, within Limit + Width + 16 bits; then lost_o
// (line not high at start_i, no acknowledge, no start bit), or crc_error_o, or a new position_o with error_o
// and warning_o. delay_o: clocks from the second rising edge of ma_o to the acknowledge, 2 more than on the line.
// start_i while busy_o does nothing. 10 MHz with a clock of 100 MHz and ClocksPerBit 10.
module biss_master #(
    parameter int unsigned Width        = 26,
    parameter int unsigned ClocksPerBit = 10,  // 6..62, even
    parameter int unsigned Limit        = 400  // bits from the request to the start bit, at most
) (
    input  logic             clk_i,
    input  logic             rst_ni,
    input  logic             start_i,
    output logic             ma_o,
    input  logic             slo_i,        // asynchronous
    output logic             busy_o,
    output logic             done_o,
    output logic [Width-1:0] position_o,   // of the last good frame
    output logic             error_o,      // bits of the last good frame, active high
    output logic             warning_o,
    output logic             crc_error_o,  // of the last frame
    output logic             lost_o,
    output logic [15:0]      delay_o
);

  typedef enum logic [1:0] {
    StIdle        = 2'd0,
    StAcknowledge = 2'd1,  // until the line falls
    StStart       = 2'd2,  // until it rises
    StBits        = 2'd3
  } state_e;

  localparam int unsigned Bits = Width + 9;  // CDS, position, error, warning, CRC
  localparam int unsigned CountBits = $clog2(Bits + 1);
  localparam int unsigned LimitClocks = Limit * ClocksPerBit;
  localparam int unsigned LimitBits = $clog2(LimitClocks + 1);
  localparam logic [5:0] PERIOD = 6'(ClocksPerBit - 1);
  localparam logic [5:0] HALF = 6'(ClocksPerBit / 2);
  localparam int unsigned SampleBits = $clog2(ClocksPerBit + ClocksPerBit / 2);
  // of the bit after the start
  localparam logic [SampleBits-1:0] MIDDLE = SampleBits'(ClocksPerBit + ClocksPerBit / 2 - 1);
  localparam logic [CountBits-1:0] CRC_BITS = CountBits'(6);

  state_e state_q;
  logic [1:0] slo_q;  // synchroniser
  logic [5:0] phase_q;  // clocks since a falling edge of ma_o
  logic [SampleBits-1:0] sample_q;  // clocks to the next bit's middle
  logic [CountBits-1:0] left_q;  // bits to come
  logic [LimitBits-1:0] waited_q;
  logic [Width+1:0] data_q;  // position, error, warning
  logic [5:0] crc_q, crc_next;
  logic [15:0] delay_q;
  logic ma_q, rose_q, twice_q, slo, rise, take, last, over, in_crc, failed;

  assign slo    = slo_q[1];
  assign rise   = busy_o && phase_q == HALF - 6'd1;
  assign take   = state_q == StBits && sample_q == '0;
  assign last   = take && left_q == CountBits'(1);
  assign in_crc = left_q <= CRC_BITS;
  assign over   = waited_q == LimitBits'(LimitClocks);
  assign failed = (state_q == StIdle && start_i && !slo)
                  || ((state_q == StAcknowledge || state_q == StStart) && over);

  // One step of the CRC. With its own bits, inverted back, it ends at 0.
  assign crc_next = {crc_q[4:0], 1'b0} ^ ((crc_q[5] != (slo ^ in_crc)) ? 6'h03 : 6'h00);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q  <= StIdle;
      slo_q    <= '0;
      phase_q  <= '0;
      sample_q <= '0;
      left_q   <= '0;
      waited_q <= '0;
      delay_q  <= '0;
      ma_q     <= 1'b1;
      rose_q   <= 1'b0;
      twice_q  <= 1'b0;
    end else begin
      slo_q    <= {slo_q[0], slo_i};
      phase_q  <= (!busy_o || phase_q == PERIOD) ? '0 : phase_q + 6'd1;
      ma_q     <= busy_o ? (phase_q >= HALF - 6'd1 && phase_q != PERIOD) : !(start_i && slo);
      rose_q   <= busy_o && (rose_q || rise);
      twice_q  <= busy_o && (twice_q || (rise && rose_q));
      waited_q <= !busy_o ? '0 : over ? waited_q : waited_q + 1'b1;
      delay_q  <= !busy_o ? '0 : (twice_q && delay_q != '1) ? delay_q + 16'd1 : delay_q;
      sample_q <= (state_q != StBits) ? MIDDLE - 1'b1 : take ? SampleBits'(PERIOD) : sample_q - 1'b1;
      left_q   <= (state_q != StBits) ? CountBits'(Bits) : take ? left_q - 1'b1 : left_q;
      case (state_q)
        StIdle:        if (start_i && slo) state_q <= StAcknowledge;
        StAcknowledge: if (failed) state_q <= StIdle; else if (!slo) state_q <= StStart;
        StStart:       if (failed) state_q <= StIdle; else if (slo) state_q <= StBits;
        default:       if (last) state_q <= StIdle;
      endcase
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      crc_q       <= '0;
      data_q      <= '0;
      done_o      <= 1'b0;
      lost_o      <= 1'b0;
      crc_error_o <= 1'b0;
      error_o     <= 1'b0;
      warning_o   <= 1'b0;
      position_o  <= '0;
      delay_o     <= '0;
    end else begin
      if (state_q != StBits) crc_q <= '0;
      else if (take && left_q != CountBits'(Bits)) crc_q <= crc_next;
      if (take && !in_crc) data_q <= {data_q[Width:0], slo};
      if (state_q == StAcknowledge && !slo) delay_o <= delay_q;
      done_o <= failed || last;
      if (failed || last) begin
        lost_o      <= failed;
        crc_error_o <= last && crc_next != '0;
      end
      if (last && crc_next == '0) begin
        position_o <= data_q[Width+1:2];
        error_o    <= !data_q[1];
        warning_o  <= !data_q[0];
      end
    end
  end

  assign busy_o = state_q != StIdle;
  assign ma_o   = ma_q;

endmodule
