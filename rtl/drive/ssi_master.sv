// SPDX-License-Identifier: Apache-2.0
// ssi_master: reads the position of one absolute encoder over SSI, point to point.
// Contract: start_i begins a frame; clock_o falls in the next clock, the encoder's instant of the position, and each
// rising edge brings a bit: Width bits of position, most significant first, binary or with Gray in Gray code, then
// with Alarm a bit that is high if the position is wrong, and with Parity a bit (1: even, 2: odd number of ones with
// it) over all bits before it. A last rising edge lets the line fall; it rises again when the encoder's monoflop time
// is over, and that ends the frame, so no request can come too early. With Repeat the clock goes on, after a low bit,
// for the same word once more, and both must be equal. A bit is taken at the next rising edge: the line and the encoder
// may delay it by ClocksPerBit - 3 clocks, which are not compensated. The monoflop time must exceed 1.5 bits: the line
// must still be low one bit after the last edge.
// done_o is high for a clock: 3 clocks after the line's last rise, (bits + 1) * (Repeat ? 2 : 1) + 1/2 bits and the
// monoflop time after the request. Then lost_o (line not high at start_i, high after the last bit, or not high within
// Limit bits after the last edge), or crc_error_o (parity, or the words differ), or a new position_o with error_o.
// SSI has no check sequence: without Parity and Repeat a disturbed bit is a wrong position. start_i while busy_o does
// nothing. delay_o: clocks from the last rising edge of clock_o to the line's rise, and 2: the monoflop time.
// Timing of the line: SSI as in the manuals of TR-Electronic (COK 65) and Posital.
module ssi_master #(
    parameter int unsigned Width        = 25,
    parameter int unsigned ClocksPerBit = 100,  // 6..254, even
    parameter int unsigned Limit        = 60,   // bits from the last rising edge to the line's rise
    parameter bit          Gray         = 1'b0,
    parameter bit          Alarm        = 1'b0,
    parameter int unsigned Parity       = 0,    // 0 none, 1 even, 2 odd
    parameter bit          Repeat       = 1'b0
) (
    input  logic             clk_i,
    input  logic             rst_ni,
    input  logic             start_i,
    output logic             clock_o,
    input  logic             data_i,       // asynchronous
    output logic             busy_o,
    output logic             done_o,
    output logic [Width-1:0] position_o,   // of the last good frame
    output logic             error_o,      // alarm bit of the last good frame
    output logic             crc_error_o,  // of the last frame
    output logic             lost_o,
    output logic [15:0]      delay_o
);

  typedef enum logic [1:0] {
    StIdle  = 2'd0,
    StBits  = 2'd1,
    StPause = 2'd2  // until the line rises
  } state_e;

  localparam int unsigned Bits = Width + (Alarm ? 1 : 0) + (Parity != 0 ? 1 : 0);  // of a word
  localparam int unsigned Edges = (Bits + 1) * (Repeat ? 2 : 1);
  localparam int unsigned LeftBits = $clog2(Edges + 1);
  localparam int unsigned PlaceBits = $clog2(Bits + 1);
  localparam int unsigned LimitClocks = Limit * ClocksPerBit;
  localparam int unsigned LimitBits = $clog2(LimitClocks + 1);
  localparam logic [7:0] PERIOD = 8'(ClocksPerBit - 1);
  localparam logic [7:0] HALF = 8'(ClocksPerBit / 2);

  state_e state_q;
  logic [1:0] data_q;  // synchroniser
  logic [7:0] phase_q;  // clocks since a falling edge of clock_o
  logic [LeftBits-1:0] left_q;  // bits to come, with the low ones after a word
  logic [PlaceBits-1:0] place_q;  // of the next bit in its word
  logic [LimitBits-1:0] waited_q;  // clocks since the last rising edge
  logic [Bits-1:0] word_q;  // decoded
  logic [15:0] delay_q;
  logic clock_q, rose_q, second_q, ones_q, differs_q;
  logic line, rise, take, low_bit, last, over, failed, ended, decoded, parity_wrong, wrong;

  assign line    = data_q[1];
  assign rise    = state_q == StBits && phase_q == HALF - 8'd1;
  assign take    = rise && rose_q;
  assign low_bit = place_q == PlaceBits'(Bits);
  assign last    = take && left_q == LeftBits'(1);
  assign over    = waited_q == LimitBits'(LimitClocks);
  assign ended   = state_q == StPause && line;
  assign failed  = (state_q == StIdle && start_i && !line) || (last && line)
                   || (state_q == StPause && !line && over);
  // Of Gray code, the sum of all bits down to this one.
  assign decoded = line ^ (Gray && place_q != '0 && place_q < PlaceBits'(Width) && word_q[0]);
  assign parity_wrong = (Parity == 1 && ones_q) || (Parity == 2 && !ones_q);
  assign wrong   = differs_q || parity_wrong;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q   <= StIdle;
      data_q    <= '0;
      phase_q   <= '0;
      left_q    <= '0;
      place_q   <= '0;
      waited_q  <= '0;
      delay_q   <= '0;
      word_q    <= '0;
      clock_q   <= 1'b1;
      rose_q    <= 1'b0;
      second_q  <= 1'b0;
      ones_q    <= 1'b0;
      differs_q <= 1'b0;
    end else begin
      data_q  <= {data_q[0], data_i};
      phase_q <= (state_q != StBits || phase_q == PERIOD) ? '0 : phase_q + 8'd1;
      rose_q  <= state_q == StBits && (rose_q || rise);
      // After the last rising edge only its bit is to come: the clock stays high.
      if (state_q == StIdle) clock_q <= !(start_i && line);
      else if (state_q == StBits) clock_q <= (phase_q >= HALF - 8'd1 && phase_q != PERIOD) || left_q == LeftBits'(1);
      else clock_q <= 1'b1;
      if (state_q == StIdle) begin
        left_q    <= LeftBits'(Edges);
        place_q   <= '0;
        waited_q  <= '0;
        delay_q   <= '0;
        second_q  <= 1'b0;
        ones_q    <= 1'b0;
        differs_q <= 1'b0;
      end else begin
        if (left_q == LeftBits'(1) && !over) waited_q <= waited_q + 1'b1;
        if (left_q == LeftBits'(1) && delay_q != '1) delay_q <= delay_q + 16'd1;
        if (take && !last) begin
          left_q  <= left_q - 1'b1;
          place_q <= low_bit ? '0 : place_q + 1'b1;
          if (low_bit) begin
            second_q  <= 1'b1;
            differs_q <= differs_q || line;
          end else begin
            word_q    <= Bits'({word_q, decoded});
            ones_q    <= ones_q ^ (line && !second_q);
            differs_q <= differs_q || (second_q && word_q[Bits-1] != decoded);
          end
        end
      end
      case (state_q)
        StIdle:  if (start_i && line) state_q <= StBits;
        StBits:  if (last) state_q <= line ? StIdle : StPause;
        default: if (ended || failed) state_q <= StIdle;
      endcase
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      done_o      <= 1'b0;
      lost_o      <= 1'b0;
      crc_error_o <= 1'b0;
      error_o     <= 1'b0;
      position_o  <= '0;
      delay_o     <= '0;
    end else begin
      done_o <= failed || ended;
      if (failed || ended) begin
        lost_o      <= failed;
        crc_error_o <= ended && wrong;
      end
      if (ended) delay_o <= delay_q;
      if (ended && !wrong) begin
        position_o <= word_q[Bits-1-:Width];
        error_o    <= Alarm && word_q[(Parity != 0) ? 1 : 0];
      end
    end
  end

  assign busy_o  = state_q != StIdle;
  assign clock_o = clock_q;

endmodule
