// SPDX-License-Identifier: Apache-2.0
// endat_master: reads the position of one absolute encoder over EnDat, point to point, half duplex.
// Contract: start_i begins a frame; clock_o falls in the next clock, the encoder's instant of the position. The first low
// phase is StartClocks longer. Pulses 3 to 8 carry the mode command, most significant bit first: data_o with
// data_en_o changes at the falling edge, the encoder takes it at the rising edge. Command 000111 (EnDat 2.1) brings
// the alarm F1; 111000 (Endat22: position with additional data, none of which is selected) F1 and F2, which is active
// low. From pulse 9 on the encoder has the line: low, until its rising edge, the start bit; then each rising edge of
// clock_o brings F1, with Endat22 F2, Width bits of position, least significant first, and 5 bits of CRC,
// x^5 + x^3 + x + 1, from ones, inverted. Bits are taken in their middle, counted from the start bit's edge as it
// arrives, so any delay of lines and encoder below MeasureClocks - 4 clocks is compensated.
// The encoder must get exactly one pulse a bit, also those that it has not seen yet when its start bit arrives. So the
// master must know the delay: the first frame after a reset, and each frame after a lost one, is slow, MeasureClocks a
// bit, and measures it. done_o is high for a clock after the last bit's middle, RecoveryClocks before busy_o falls: the
// encoder's recovery time. Then lost_o (line not low, or no start bit, within Limit pulses), or crc_error_o, or a new
// position_o with error_o. delay_o: clocks from a rising edge of clock_o to its bit in the last slow frame that was good, 2
// more than on the line. start_i while busy_o does nothing.
// Frame, times and CRC: EnDat 2.2, HEIDENHAIN technical information 383942 and PWM 20 manual (mode commands, times).
module endat_master #(
    parameter int unsigned Width          = 25,    // 1..48
    parameter int unsigned ClocksPerBit   = 14,    // 6..254, even
    parameter int unsigned Limit          = 400,   // pulses from the request to the start bit, 13..65535
    parameter bit          Endat22        = 1'b1,
    parameter int unsigned StartClocks    = 200,   // of 2 us to 10 us, or 0
    parameter int unsigned RecoveryClocks = 3000,  // longest recovery time: 30 us, or 3.75 us of EnDat 2.2 if set so
    parameter int unsigned MeasureClocks  = 400    // even, ClocksPerBit to (Width + 5) * ClocksPerBit, below 32768
) (
    input  logic             clk_i,
    input  logic             rst_ni,
    input  logic             start_i,
    output logic             clock_o,
    output logic             data_o,
    output logic             data_en_o,    // direction: 1 to the encoder
    input  logic             data_i,       // asynchronous
    output logic             busy_o,
    output logic             done_o,
    output logic [Width-1:0] position_o,   // of the last good frame
    output logic             error_o,      // F1 or F2 of the last good frame
    output logic             crc_error_o,  // of the last frame
    output logic             lost_o,
    output logic [15:0]      delay_o
);

  typedef enum logic [2:0] {
    StIdle    = 3'd0,
    StLow     = 3'd1,  // first low phase
    StCommand = 3'd2,  // until the encoder has the line
    StQuiet   = 3'd3,  // until the line is low
    StStart   = 3'd4,  // until it rises
    StBits    = 3'd5,
    StRecover = 3'd6
  } state_e;

  localparam int unsigned Flags = Endat22 ? 2 : 1;
  localparam int unsigned Bits = Flags + Width + 5;  // after the start bit
  localparam int unsigned BitBits = $clog2(Bits + 1);
  localparam int unsigned TimeClocks = (RecoveryClocks > StartClocks) ? RecoveryClocks : StartClocks;
  localparam int unsigned TimeBits = $clog2(TimeClocks + 2);
  localparam logic [5:0] COMMAND = Endat22 ? 6'b111000 : 6'b000111;
  localparam logic [15:0] SENT = 16'd8;  // pulses until the command has been sent
  localparam logic [15:0] TURNED = 16'd10;  // and until the encoder has the line
  localparam logic [BitBits-1:0] CRC_BITS = BitBits'(5);
  localparam logic [15:0] FAST = 16'(ClocksPerBit);
  localparam logic [15:0] SLOW = 16'(MeasureClocks);
  localparam logic [8:0] HALF_FAST = 9'(ClocksPerBit / 2);
  localparam logic [7:0] LAST_REST = 8'(ClocksPerBit - 1);

  state_e state_q;
  logic [1:0] data_q;  // synchroniser
  logic [15:0] phase_q;  // clocks since a falling edge of clock_o
  logic [15:0] pulse_q;  // number of the pulse, from 1
  logic [15:0] sample_q;  // clocks to the next bit's middle
  logic [7:0] rest_q, delay_rest_q;  // clocks since a rising edge, and at the start bit of the last slow frame:
  logic [BitBits-1:0] whole_q, delay_whole_q;  // whole bits of ClocksPerBit, and the rest
  logic [BitBits-1:0] left_q, pulses_q;  // bits and rising edges to come
  logic [TimeBits-1:0] time_q;
  logic [Flags+Width-1:0] word_q;
  logic [4:0] crc_q, crc_next;
  logic [BitBits-1:0] ahead;
  logic [15:0] period, half, delay_q;
  logic clock_q, out_q, en_q, measured_q;
  logic line, rise, fall, start, take, last, in_crc, failed, running, good;

  assign line    = data_q[1];
  assign period  = measured_q ? FAST : SLOW;
  assign half    = {1'b0, period[15:1]};
  assign running = state_q == StCommand || state_q == StQuiet || state_q == StStart
                   || (state_q == StBits && pulses_q != '0);
  assign rise    = running && phase_q == half - 16'd1;
  assign fall    = running && phase_q == period - 16'd1;
  assign start   = state_q == StStart && line;
  assign take    = state_q == StBits && sample_q == '0;
  assign last    = take && left_q == BitBits'(1);
  assign in_crc  = left_q <= CRC_BITS;
  assign failed  = (state_q == StQuiet || state_q == StStart) && !start && rise && pulse_q == 16'(Limit);
  assign good    = last && crc_next == '0;

  // Rising edges since that of the start bit: of the bits of the measured delay, the number that fits the rest now.
  always_comb begin
    if (!measured_q) ahead = '0;
    else if ({1'b0, delay_rest_q} > {1'b0, rest_q} + HALF_FAST) ahead = delay_whole_q + 1'b1;
    else if ({1'b0, delay_rest_q} + HALF_FAST < {1'b0, rest_q}) ahead = delay_whole_q - 1'b1;
    else ahead = delay_whole_q;
  end

  // One step of the CRC. With its own bits, inverted back, it ends at 0.
  assign crc_next = {crc_q[3:0], 1'b0} ^ ((crc_q[4] != (line ^ in_crc)) ? 5'h0B : 5'h00);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q       <= StIdle;
      data_q        <= '0;
      phase_q       <= '0;
      pulse_q       <= '0;
      sample_q      <= '0;
      rest_q        <= '0;
      whole_q       <= '0;
      delay_q       <= '0;
      delay_rest_q  <= '0;
      delay_whole_q <= '0;
      left_q        <= '0;
      pulses_q      <= '0;
      time_q        <= '0;
      clock_q       <= 1'b1;
      out_q         <= 1'b0;
      en_q          <= 1'b0;
      measured_q    <= 1'b0;
    end else begin
      data_q <= {data_q[0], data_i};
      if (state_q == StIdle) clock_q <= !start_i;
      else if (rise || state_q == StRecover) clock_q <= 1'b1;
      else if (fall) clock_q <= 1'b0;
      phase_q <= (!running || fall) ? '0 : phase_q + 16'd1;
      pulse_q <= (state_q == StIdle) ? 16'd1 : fall ? pulse_q + 16'd1 : pulse_q;
      // data_o changes with clock_o: the first pulse has passed, then a low bit, the command, and the encoder's turn.
      if (fall) begin
        en_q  <= pulse_q < SENT;
        out_q <= pulse_q >= 16'd2 && pulse_q < SENT && COMMAND[3'(16'd7-pulse_q)];
      end
      if (rise) begin
        rest_q  <= '0;
        whole_q <= '0;
      end else begin
        rest_q <= (rest_q == LAST_REST) ? '0 : rest_q + 8'd1;
        if (rest_q == LAST_REST) whole_q <= whole_q + 1'b1;
      end
      sample_q <= (state_q != StBits) ? period + half - 16'd2 : take ? period - 16'd1 : sample_q - 16'd1;
      left_q   <= (state_q != StBits) ? BitBits'(Bits) : take ? left_q - 1'b1 : left_q;
      if (start) begin
        pulses_q <= BitBits'(Bits) - ahead - BitBits'(rise);
        if (!measured_q) begin
          delay_q       <= (phase_q >= half) ? phase_q - half : phase_q + half;
          delay_rest_q  <= rest_q;
          delay_whole_q <= whole_q;
        end
      end else if (rise && state_q == StBits) pulses_q <= pulses_q - 1'b1;
      if (failed) measured_q <= 1'b0;
      else if (good) measured_q <= 1'b1;
      time_q <= (state_q == StLow || state_q == StRecover) ? time_q + 1'b1 : '0;
      case (state_q)
        StIdle:    if (start_i) state_q <= (StartClocks == 0) ? StCommand : StLow;
        StLow:     if (time_q == TimeBits'(StartClocks - 1)) state_q <= StCommand;
        StCommand: if (fall && pulse_q == TURNED) state_q <= StQuiet;
        StQuiet:   if (failed) state_q <= StRecover; else if (!line) state_q <= StStart;
        StStart:   if (start) state_q <= StBits; else if (failed) state_q <= StRecover;
        StBits:    if (last) state_q <= StRecover;
        default:   if (time_q == TimeBits'(RecoveryClocks - 1)) state_q <= StIdle;
      endcase
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      crc_q       <= '0;
      word_q      <= '0;
      done_o      <= 1'b0;
      lost_o      <= 1'b0;
      crc_error_o <= 1'b0;
      error_o     <= 1'b0;
      position_o  <= '0;
      delay_o     <= '0;
    end else begin
      if (state_q != StBits) crc_q <= '1;
      else if (take) crc_q <= crc_next;
      if (take && !in_crc) word_q <= {line, word_q[Flags+Width-1:1]};
      done_o <= failed || last;
      if (failed || last) begin
        lost_o      <= failed;
        crc_error_o <= last && !good;
      end
      if (good) begin
        position_o <= word_q[Flags+:Width];
        error_o    <= word_q[0] || (Endat22 && !word_q[Flags-1]);
        if (!measured_q) delay_o <= delay_q;
      end
    end
  end

  assign busy_o    = state_q != StIdle;
  assign clock_o   = clock_q;
  assign data_o    = out_q;
  assign data_en_o = en_q;

endmodule
