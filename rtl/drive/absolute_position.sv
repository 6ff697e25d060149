// SPDX-License-Identifier: Apache-2.0
// absolute_position: the words of an absolute encoder's port as the count of a drive axis, without lines A and B.
// Contract: every Period clocks request_o asks the port for a frame, unless busy_i; the encoder takes its position
// Instant clocks later. done_i is high for a clock at the end of a frame, with good_i if position_i is right;
// position_i holds until the next end. position_o counts from 0 at the first good frame, in units of 2^Drop
// positions, across the end of the encoder's range. Between frames it goes on by the mean speed between the last
// two, one count a clock at most, so it is the position of this clock: within 3 counts at a constant speed, however
// long a frame takes. A frame acts 6 clocks after done_i. Bad frames are left out, and position_o goes on. A frame that
// is more than MostJump counts from that, or moved by more than a count a clock, is rejected and sets jump_o at
// once. Periods periods without a good frame set lost_o. After either, position_o rests until the next good frame,
// whose position it takes by the shorter way; the speed is known with the next one, and position_o right with the third.
module absolute_position #(
    parameter int unsigned Width    = 26,    // bits of position_i, 2..64
    parameter int unsigned Drop     = 0,     // its low bits that are left out, Width - 2 at most
    parameter int unsigned Modulus  = 0,     // counts of the encoder's range, below 2^31; 0: 2^(Width - Drop)
    parameter int unsigned Period   = 2500,  // clocks from a request to the next
    parameter int unsigned Instant  = 1,     // clocks, below Period: ClocksPerBit / 2 + 1 of biss_port
    parameter int unsigned MostJump = 64,    // counts
    parameter int unsigned Periods  = 4      // Periods * Period is below 2^24
) (
    input  logic               clk_i,
    input  logic               rst_ni,
    // port of the encoder
    output logic               request_o,
    input  logic               busy_i,
    input  logic               done_i,
    input  logic               good_i,
    input  logic [Width-1:0]   position_i,
    // drive axis
    input  logic               clear_i,      // forgets jump_o, lost_o and bad_count_o
    output logic signed [31:0] position_o,
    output logic               jump_o,
    output logic               lost_o,
    output logic [7:0]         bad_count_o   // frames that were not used, 255 at most
);

  typedef enum logic [1:0] {
    StNone  = 2'd0,  // no position
    StPlace = 2'd1,  // a position, no speed
    StSpeed = 2'd2,  // a speed since the last action
    StTrack = 2'd3
  } state_e;

  localparam int unsigned CountBits = (Width - Drop > 32) ? 32 : Width - Drop;
  localparam int unsigned TimerBits = $clog2(Period + 1);
  localparam int unsigned LimitClocks = Periods * Period;
  localparam int unsigned SpanBits = $clog2(LimitClocks + 1);
  localparam logic [SpanBits-1:0] PERIOD = SpanBits'(Period);
  localparam logic [SpanBits-1:0] LIMIT = SpanBits'(LimitClocks);
  localparam logic signed [31:0] RANGE = 32'(Modulus);
  localparam logic signed [31:0] HALF = (Modulus != 0) ? 32'(Modulus / 2) : 32'h7FFF_FFFF;

  state_e state_q;
  logic [TimerBits-1:0] timer_q, instant_q;
  logic [SpanBits-1:0] since_q, since_next, begun_q, span_q, size_q, room_q, rest_q;
  logic tick, late, taken, stale_q, known_q;
  // A good frame: its difference, the shorter way, distance from position_o, limits, action.
  logic [4:0] stage_q;
  logic [CountBits-1:0] raw_q, before_q;
  logic signed [31:0] base_q, at_instant_q, ahead_q, moved_q, off_q, way, step;
  logic [31:0] moved_size, off_size;
  logic [SpanBits-1:0] size_new_q;
  logic moved_down, down_q, count, count_q, count_down_q, far_q, accept, reject;
  logic unused_position;

  assign tick            = timer_q == '0;
  assign late            = tick && since_q == LIMIT && !accept;
  assign request_o       = tick && !busy_i;
  assign taken           = instant_q == TimerBits'(1);
  assign accept          = stage_q[4] && !far_q;
  assign reject          = stage_q[4] && far_q;
  assign moved_down      = moved_q[31];
  assign moved_size      = moved_down ? -moved_q : moved_q;
  assign off_size        = off_q[31] ? -off_q : off_q;
  assign unused_position = ^position_i;

  // Clocks from the instant of the last position to the last request, LIMIT at most.
  always_comb begin
    since_next = since_q;
    if (accept) since_next = since_next - span_q;
    if (tick && !late) since_next = since_next + PERIOD;
  end

  // Evenly size_q counts in size_q + room_q clocks.
  assign count = rest_q >= room_q && !stage_q[3] && !stage_q[4];
  assign step  = accept ? off_q : {{31{count_q && count_down_q}}, count_q};

  generate
    if (Modulus != 0) begin : gen_modulus
      assign way = $signed(32'(raw_q)) - $signed(32'(before_q));
    end else begin : gen_power
      logic [CountBits-1:0] difference;
      assign difference = raw_q - before_q;
      assign way = {{(32 - CountBits + 1) {difference[CountBits-1]}}, difference[CountBits-2:0]};
    end
  endgenerate

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q      <= StNone;
      timer_q      <= TimerBits'(Period - 1);
      instant_q    <= '0;
      since_q      <= '0;
      stale_q      <= 1'b0;
      known_q      <= 1'b0;
      stage_q      <= '0;
      base_q       <= '0;
      size_q       <= '0;
      room_q       <= '1;
      rest_q       <= '0;
      count_q      <= 1'b0;
      count_down_q <= 1'b0;
      position_o   <= '0;
      jump_o       <= 1'b0;
      lost_o       <= 1'b0;
      bad_count_o  <= '0;
    end else begin
      timer_q <= tick ? TimerBits'(Period - 1) : timer_q - 1'b1;
      if (request_o) instant_q <= TimerBits'(Instant);
      else if (instant_q != '0) instant_q <= instant_q - 1'b1;
      since_q <= since_next;
      // A frame that was requested before the limit has no known age at its end.
      if (late) stale_q <= busy_i;
      else if (request_o) stale_q <= 1'b0;

      stage_q      <= {stage_q[3:0], done_i && good_i && !stale_q};
      position_o   <= position_o + step;
      count_q      <= count;
      count_down_q <= down_q;
      jump_o       <= (jump_o && !clear_i) || reject;
      lost_o       <= (lost_o && !clear_i) || late;
      if (clear_i) bad_count_o <= '0;
      else if (((done_i && !good_i) || reject) && bad_count_o != '1) bad_count_o <= bad_count_o + 1'b1;

      if (accept) begin
        known_q <= 1'b1;
        base_q  <= base_q + moved_q;
        rest_q  <= {1'b0, span_q[SpanBits-1:1]};
      end else if (count) begin
        rest_q <= rest_q - room_q;
      end else if (!stage_q[3]) begin
        rest_q <= rest_q + size_q;
      end
      if (late || reject || (accept && state_q == StNone)) begin
        size_q <= '0;
        room_q <= '1;
      end else if (accept) begin
        size_q <= size_new_q;
        room_q <= span_q - size_new_q;
      end
      if (late || reject) state_q <= StNone;
      else if (accept) state_q <= (state_q == StNone) ? StPlace : (state_q == StPlace) ? StSpeed : StTrack;
    end
  end

  always_ff @(posedge clk_i) begin
    if (taken) begin
      at_instant_q <= position_o;
      begun_q      <= since_q;
    end
    if (done_i) begin
      raw_q   <= position_i[Drop+:CountBits];
      span_q  <= begun_q;
      ahead_q <= base_q - at_instant_q;
    end
    if (stage_q[0]) moved_q <= known_q ? way : '0;
    if (stage_q[1]) begin
      if (moved_q > HALF) moved_q <= moved_q - RANGE;
      if (moved_q < -HALF) moved_q <= moved_q + RANGE;
    end
    if (stage_q[2]) begin
      off_q      <= ahead_q + moved_q;
      size_new_q <= moved_size[SpanBits-1:0];
    end
    if (stage_q[3])
      far_q <= (state_q != StNone && moved_size > 32'(span_q)) || (state_q == StTrack && off_size > MostJump);
    if (accept) begin
      before_q <= raw_q;
      down_q   <= moved_down;
    end
  end

`ifndef SYNTHESIS
  generate
    if (Width < 2 || Width > 64 || Drop + 2 > Width) begin : gen_check_width
      $error("absolute_position: Width=%0d, Drop=%0d, must be 2..64 and leave two bits at least", Width, Drop);
    end
    if (Modulus > 32'h7FFF_FFFF || (Width - Drop < 31 && Modulus > (1 << (Width - Drop)))) begin : gen_check_modulus
      $error("absolute_position: Modulus=%0d, must be below 2^31 and within Width - Drop bits", Modulus);
    end
    if (Instant < 1 || Instant >= Period || Period < 16 || Periods < 1 || Periods * Period > 16777215)
    begin : gen_check_period
      $error(
          "absolute_position: Period=%0d, must be 16 at least and above Instant, Periods * Period below 2^24", Period
      );
    end
    if (MostJump < 1 || MostJump > 32'h7FFF_FFFF) begin : gen_check_jump
      $error("absolute_position: MostJump=%0d, must be 1..2147483647", MostJump);
    end
  endgenerate
`endif

endmodule
