// SPDX-License-Identifier: Apache-2.0
// velocity_control: runs one axis through the phases of a jerk-limited move, without a multiplier.
// A phase is a record of eight words written through the load port (layout below); every tick_i
// (1 us) the acceleration grows by the jerk and the velocity by the acceleration.
// Time-exact phases last `count` ticks; seed-compatible ones last `count` pulses and publish
// a new rate only after a pulse. Phases follow each other without a gap if the next record is loaded
// before the next tick; if it is not, the rate falls to 0 and underrun_o stays set until clear.
module velocity_control #(
    parameter int unsigned IntegerBits  = 30,  // of the velocity, 1/16 Hz
    parameter int unsigned FractionBits = 32,  // of velocity, acceleration and jerk
    parameter int unsigned SlopeBits    = 21   // integer bits of acceleration and jerk, with sign
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        abort_i,     // drop the move: rate 0 from the next clock, flags cleared
    input  logic        tick_i,      // one clock in every microsecond

    // records, from the profile memory: word 0 first, word 7 starts the phase at the next tick
    input  logic        load_i,
    input  logic [2:0]  load_word_i,
    input  logic [31:0] load_data_i,
    output logic        request_o,   // a next record is wanted
    output logic        running_o,
    output logic        underrun_o,

    // pulse generator
    input  logic        pulse_i,
    output logic [31:0] rate_o,      // U(28.4) Hz
    output logic        direction_o, // 1: negative
    output logic        first_o      // in the clock before a move's first phase: centre the pulse
);

  // Words of a record: 0 flags {last, first, seed, direction}, 1 count, 2-3 velocity,
  // 4-5 acceleration, 6-7 jerk, each pair low word first, velocity unsigned, the others signed;
  // velocity in 2^-FractionBits/16 Hz, acceleration per tick, jerk per tick twice.
  localparam int unsigned VelocityBits = IntegerBits + FractionBits + 1;  // and a sign
  localparam int unsigned RateBits     = SlopeBits + FractionBits;
  localparam int unsigned FlagLast = 3, FlagFirst = 2, FlagSeed = 1, FlagDirection = 0;

  logic signed [VelocityBits-1:0] velocity_q, velocity_d;
  logic signed [RateBits-1:0]     slope_q, slope_d, jerk_q;
  logic [31:0]                    count_q;
  logic [3:0]                     flags_q;
  logic [IntegerBits-1:0]         rate_q;
  logic direction_q;
  logic loaded_q;      // a record is there and not yet used up
  logic fresh_q;       // none of its ticks has passed
  logic running_q;     // the rate belongs to a move
  logic last_q;        // the phase that ended was its move's last
  logic pulsed_q;      // a pulse since the rate was published
  logic grace_q;       // a phase ended between ticks: its next record comes after the next tick
  logic underrun_q;
  logic seed, publish, step_count, phase_ends, stop;

  assign seed       = flags_q[FlagSeed];
  assign slope_d    = slope_q + jerk_q;
  assign velocity_d = velocity_q + {{(VelocityBits - RateBits) {slope_d[RateBits-1]}}, slope_d};
  assign publish    = tick_i && loaded_q && (!seed || fresh_q || pulsed_q);
  assign step_count = loaded_q && (seed ? pulse_i && !fresh_q : tick_i);
  assign phase_ends = step_count && count_q == 32'd1;
  assign stop       = tick_i && running_q && !loaded_q && !grace_q;

  // Data of a phase; `loaded_q` says when they mean something.
  always_ff @(posedge clk_i) begin
    if (load_i) begin
      case (load_word_i)
        3'd0: flags_q <= load_data_i[3:0];
        3'd1: count_q <= load_data_i;
        3'd2: velocity_q[31:0] <= load_data_i;
        3'd3: velocity_q[VelocityBits-1:32] <= load_data_i[VelocityBits-33:0];
        3'd4: slope_q[31:0] <= load_data_i;
        3'd5: slope_q[RateBits-1:32] <= load_data_i[RateBits-33:0];
        3'd6: jerk_q[31:0] <= load_data_i;
        default: jerk_q[RateBits-1:32] <= load_data_i[RateBits-33:0];
      endcase
    end else begin
      if (tick_i && loaded_q) begin
        velocity_q <= velocity_d;
        slope_q    <= slope_d;
      end
      if (step_count) count_q <= count_q - 32'd1;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      loaded_q    <= 1'b0;
      fresh_q     <= 1'b0;
      running_q   <= 1'b0;
      last_q      <= 1'b0;
      pulsed_q    <= 1'b0;
      grace_q     <= 1'b0;
      underrun_q  <= 1'b0;
      direction_q <= 1'b0;
      rate_q      <= '0;
    end else if (abort_i) begin
      loaded_q   <= 1'b0;
      running_q  <= 1'b0;
      underrun_q <= 1'b0;
      rate_q     <= '0;
    end else begin
      if (load_i && load_word_i == 3'd7) begin
        loaded_q <= 1'b1;
        fresh_q  <= 1'b1;
      end
      if (phase_ends) begin
        loaded_q <= 1'b0;
        last_q   <= flags_q[FlagLast];
      end
      if (tick_i && loaded_q) begin
        fresh_q     <= 1'b0;
        running_q   <= 1'b1;
        direction_q <= flags_q[FlagDirection];
      end
      grace_q  <= (seed && phase_ends) || (grace_q && !tick_i);
      pulsed_q <= pulse_i || (pulsed_q && !publish);
      // A seed-compatible phase ends at its last pulse, and nothing may pulse before the next one.
      if (stop || (seed && phase_ends)) rate_q <= '0;
      else if (publish)
        rate_q <= velocity_q[VelocityBits-1] ? '0 : velocity_q[VelocityBits-2:FractionBits];
      if (stop) begin
        running_q  <= 1'b0;
        underrun_q <= underrun_q || !last_q;
      end
    end
  end

  assign request_o   = !loaded_q && !underrun_q;
  assign running_o   = running_q || loaded_q;
  assign underrun_o  = underrun_q;
  assign rate_o      = {{(32 - IntegerBits){1'b0}}, rate_q};
  assign direction_o = direction_q;
  assign first_o     = tick_i && loaded_q && fresh_q && flags_q[FlagFirst];

endmodule
