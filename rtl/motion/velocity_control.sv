// SPDX-License-Identifier: Apache-2.0
// velocity_control: runs 1 to 8 axes through the phases of jerk-limited moves with one adder of 32 bits.
// A phase is a record of eight words (layout below). Every tick_i (1 us) an axis' acceleration grows by
// its jerk and its velocity by the acceleration; all rates change in the clock after tick_i.
// Time-exact phases last `count` ticks; pulse-counted ones `count` pulses, and publish a rate only
// after a pulse. Phases follow each other without a gap if the next record waits at the tick inside the
// last one; if not, the rate falls to 0 and underrun_o stays set until abort_i. Contract: ticks are
// 8*Axes + 8 clocks apart at least; between two an axis has 2^EventBits - 8 pulses at most.
module velocity_control #(
    parameter int unsigned Axes      = 1,
    parameter int unsigned EventBits = 6
) (
    input  logic               clk_i,
    input  logic               rst_ni,
    input  logic [Axes-1:0]    abort_i,     // drop the move: rate 0 from the next clock, flags cleared
    input  logic               tick_i,      // one clock in every microsecond

    // records: the word requested in a clock is there in the next one
    input  logic [Axes-1:0]    waiting_i,   // the axis has a record; looked at in the clock after tick_i
    output logic [2:0]         axis_o,
    output logic [2:0]         word_o,
    input  logic [31:0]        record_i,
    output logic [Axes-1:0]    take_o,      // the axis' record is used up after this clock
    output logic [Axes-1:0]    running_o,
    output logic [Axes-1:0]    underrun_o,

    // pulse generators
    input  logic [Axes-1:0]    pulse_i,
    output logic [32*Axes-1:0] rate_o,      // U(28.4) Hz
    output logic [Axes-1:0]    direction_o, // 1: negative
    output logic [Axes-1:0]    first_o      // in the clock before a move's first phase: centre the pulse
);

  // Words of a record: 0 flags {last, first, by pulses, direction}, 1 count (1 at least), 2-3 velocity,
  // 4-5 acceleration, 6-7 jerk, each pair low word first, all signed;
  // velocity in 2^-32/16 Hz, acceleration per tick, jerk per tick twice.
  localparam int unsigned RateBits = 30;
  localparam int unsigned FlagLast = 3, FlagFirst = 2, FlagByPulses = 1, FlagDirection = 0;
  localparam logic [2:0] LAST_AXIS = 3'(Axes - 1);

  // A round, in the clocks after each tick, gives every axis a turn of eight steps. In each step one
  // word of the axis' state, or of its next record, goes through the accumulator into the state: the
  // flags, count - 1, the jerk as they are; the others with the result before them added.
  localparam logic [2:0] FLAGS = 3'd0, COUNT = 3'd1, JERK_LOW = 3'd2, SLOPE_LOW = 3'd3,
                         VELOCITY_LOW = 3'd4, JERK_HIGH = 3'd5, SLOPE_HIGH = 3'd6, VELOCITY_HIGH = 3'd7;

  localparam int unsigned StateWords = 8 * Axes;
  localparam int unsigned StateBits = $clog2(StateWords);

  // Stages of a step: address, word read (q1), word chosen and added (q2), sum (q3).
  logic sample_q, round_q, served, served_q1, served_q2;
  logic [2:0] axis_q, step_q, step_q1, word;
  logic [Axes-1:0] turn, turn_q1, turn_q2, turn_q3;  // one of them, or none
  logic [Axes-1:0] serve_q;  // axes that get a record in this round
  logic add_q2, high_q2, flags_q2, flags_q3, count_q2, count_q3, last_q2, last_q3;
  logic [StateBits-1:0] address, address_q1, address_q2, address_q3;

  always_comb begin
    case (step_q)
      FLAGS:        word = 3'd0;
      COUNT:        word = 3'd1;
      JERK_LOW:     word = 3'd6;
      SLOPE_LOW:    word = 3'd4;
      VELOCITY_LOW: word = 3'd2;
      JERK_HIGH:    word = 3'd7;
      SLOPE_HIGH:   word = 3'd5;
      default:      word = 3'd3;
    endcase
    for (int unsigned i = 0; i < Axes; i++) turn[i] = round_q && axis_q == 3'(i);
  end

  assign served  = (turn & serve_q) != '0;
  assign address = StateBits'({axis_q, word});

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sample_q <= 1'b0;
      round_q  <= 1'b0;
      turn_q1  <= '0;
      turn_q2  <= '0;
      turn_q3  <= '0;
    end else begin
      sample_q <= tick_i;
      round_q  <= sample_q || (round_q && !(axis_q == LAST_AXIS && step_q == VELOCITY_HIGH));
      turn_q1  <= turn;
      turn_q2  <= turn_q1;
      turn_q3  <= turn_q2;
    end
  end

  always_ff @(posedge clk_i) begin
    {axis_q, step_q} <= sample_q ? 6'd0 : {axis_q, step_q} + 6'd1;
    step_q1    <= step_q;
    served_q1  <= served;
    served_q2  <= served_q1;
    address_q1 <= address;
    address_q2 <= address_q1;
    address_q3 <= address_q2;
    add_q2   <= !served_q1 && (step_q1 == SLOPE_LOW || step_q1 == VELOCITY_LOW
                               || step_q1 == SLOPE_HIGH || step_q1 == VELOCITY_HIGH);
    high_q2  <= !served_q1 && (step_q1 == SLOPE_HIGH || step_q1 == VELOCITY_HIGH);
    flags_q2 <= step_q1 == FLAGS;
    flags_q3 <= flags_q2;
    count_q2 <= step_q1 == COUNT;
    count_q3 <= count_q2;
    last_q2  <= step_q1 == VELOCITY_HIGH;
    last_q3  <= last_q2;
  end

  assign axis_o = axis_q;
  assign word_o = word;
  assign take_o = (step_q == VELOCITY_HIGH) ? turn & serve_q : '0;

  logic [31:0] state[0:StateWords-1];
  logic [31:0] state_q, word_q, sum_q, operand;
  logic [2:0] carry_q;  // of the last three steps
  logic [31:0] sum;
  logic carry, carry_in;
  logic [Axes-1:0] near, spend;
  logic [EventBits*Axes-1:0] events;
  logic [EventBits-1:0] spent;

  always_ff @(posedge clk_i) begin
    if (turn_q3 != '0) state[address_q3] <= sum_q;
    state_q <= state[address];
    word_q  <= served_q1 ? record_i : state_q;
  end

  // The count in the state is what is left less one, and less the axis' `events` since it was looked at;
  // within reach of those it stays as it is until the phase ends.
  always_comb begin
    spent = '0;
    for (int unsigned i = 0; i < Axes; i++) begin
      spend[i] = turn_q2[i] && count_q2 && (served_q2 || !near[i]);
      if (spend[i] && !served_q2) spent = spent | events[EventBits*i+:EventBits];
    end
    operand = add_q2 ? sum_q : '0;
    if (count_q2) operand = ~{{(32 - EventBits) {1'b0}}, spent};
    carry_in = (high_q2 && carry_q[2]) || (count_q2 && !served_q2);
  end

  always_ff @(posedge clk_i) begin
    sum_q   <= sum;
    carry_q <= {carry_q[1:0], carry};
  end

  assign {carry, sum} = {1'b0, operand} + {1'b0, word_q} + {32'd0, carry_in};

  genvar axis;
  generate
    for (axis = 0; axis < Axes; axis++) begin : gen_axis
      logic [RateBits-1:0] rate_q, next_q;
      logic [EventBits-1:0] events_q, limit_q;  // ticks or pulses, and the one of them that ends the phase
      logic [3:0] flags_q;
      logic near_q;  // the limit is within reach of the events
      logic direction_q;
      logic loaded_q;  // a phase is there and not yet over
      logic fresh_q;  // none of its ticks has passed, and the clock after it
      logic running_q;  // the rate belongs to a move
      logic final_q;  // the phase that ended was its move's last
      logic pulsed_q;  // a pulse since the rate was published
      logic grace_q;  // a phase ended between ticks: its next record comes after the next tick
      logic underrun_q;
      logic by_pulses, publish, happens, phase_ends, stop, load;

      assign by_pulses  = flags_q[FlagByPulses];
      assign publish    = tick_i && loaded_q && (!by_pulses || fresh_q || pulsed_q);
      assign happens    = loaded_q && (by_pulses ? pulse_i[axis] && !fresh_q : tick_i);
      assign phase_ends = happens && near_q && events_q == limit_q;
      assign stop       = tick_i && running_q && !loaded_q && !grace_q;
      assign load       = turn_q3[axis] && last_q3 && serve_q[axis];

      // Data of a phase; `loaded_q` says when they mean something.
      always_ff @(posedge clk_i) begin
        if (turn_q3[axis]) begin
          if (flags_q3 && serve_q[axis]) flags_q <= sum_q[3:0];
          if (count_q3) begin
            near_q  <= sum_q[31:EventBits] == '0;
            limit_q <= sum_q[EventBits-1:0];
          end
          if (last_q3) next_q <= sum_q[RateBits] ? '0 : sum_q[RateBits-1:0];
        end
        if (spend[axis]) events_q <= {{(EventBits - 1) {1'b0}}, happens};
        else if (happens) events_q <= events_q + 1'b1;
      end

      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) begin
          serve_q[axis]  <= 1'b0;
          loaded_q    <= 1'b0;
          fresh_q     <= 1'b0;
          running_q   <= 1'b0;
          final_q     <= 1'b0;
          pulsed_q    <= 1'b0;
          grace_q     <= 1'b0;
          underrun_q  <= 1'b0;
          direction_q <= 1'b0;
          rate_q      <= '0;
        end else if (abort_i[axis]) begin
          serve_q[axis] <= 1'b0;
          loaded_q   <= 1'b0;
          running_q  <= 1'b0;
          underrun_q <= 1'b0;
          rate_q     <= '0;
        end else begin
          if (sample_q) serve_q[axis] <= waiting_i[axis] && !loaded_q && !underrun_q;
          else if (load) serve_q[axis] <= 1'b0;
          if (load) begin
            loaded_q <= 1'b1;
            fresh_q  <= 1'b1;
          end
          if (phase_ends) begin
            loaded_q <= 1'b0;
            final_q  <= flags_q[FlagLast];
          end
          if (sample_q && loaded_q) fresh_q <= 1'b0;  // a pulse in that clock is of the rate before
          if (tick_i && loaded_q) begin
            running_q   <= 1'b1;
            direction_q <= flags_q[FlagDirection];
          end
          grace_q  <= (by_pulses && phase_ends) || (grace_q && !tick_i);
          pulsed_q <= pulse_i[axis] || (pulsed_q && !publish);
          // A pulse-counted phase ends at its last pulse, and nothing may pulse before the next one.
          if (stop || (by_pulses && phase_ends)) rate_q <= '0;
          else if (publish) rate_q <= next_q;
          if (stop) begin
            running_q  <= 1'b0;
            underrun_q <= underrun_q || !final_q;
          end
        end
      end

      assign near[axis]                         = near_q;
      assign events[EventBits*axis+:EventBits] = events_q;
      assign running_o[axis]      = running_q || loaded_q || serve_q[axis];
      assign underrun_o[axis]     = underrun_q;
      assign rate_o[32*axis+:32]  = {{(32 - RateBits) {1'b0}}, rate_q};
      assign direction_o[axis]    = direction_q;
      assign first_o[axis]        = tick_i && loaded_q && fresh_q && flags_q[FlagFirst];
    end
  endgenerate

endmodule
