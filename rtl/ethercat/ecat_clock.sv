// SPDX-License-Identifier: Apache-2.0
// ecat_clock: distributed clocks: local time of 64 bits whose speed follows a reference, receive times of frames, system
// time, and the control that takes their difference away.
// Contract: times are in ns, a clock is 10 of them, one more or less by its speed and one by its phase: 8 to 12. A
// frame's time is that at which it began on the port that the processing unit hears; frame_end_i keeps it for the frame's
// writes. A write of SYSTEM_TIME is compared when done_i says that the frame's writes are in force:
//   e = system time at the frame's beginning - (written + TIME_DELAY), at most 2^15 - 1 either way
//   phase -= e / 2^DIFFERENCE_FILTER, a ns a clock;  speed -= e * 2^(16 - SPEED_FILTER) * 2^-34
// TIME_DIFFERENCE is the mean of e over 2^DIFFERENCE_FILTER comparisons. live_* as in ecat_control.
module ecat_clock (
    input  logic clk_i,
    input  logic rst_ni,
    input  ecat_pkg::register_access_t register_i,
    input  logic [11:0] live_address_i,
    input  logic        live_application_i,
    input  logic        live_read_i,   // the access is a read
    output logic        live_hit_o,
    output logic [7:0]  live_data_o,
    // frames
    input  logic [1:0]  start_i,       // a frame began on port 0, 1
    input  logic        looped_i,      // the processing unit hears port 1
    input  logic        frame_end_i,
    input  logic        done_i,
    output logic [63:0] time_o         // system time
);

  localparam int unsigned Nanoseconds = 10;  // a clock
  localparam logic signed [16:0] Most = 17'sd32767;

  logic [63:0] local_q, system_q, offset_q, offset_new_q, begun_local_q, begun_system_q, kept_local_q, unit_time_q;
  logic [31:0] delay_q, kept_system_q, received_q, time_0_q, time_1_q, return_q, begun_0_q, kept_0_q, kept_return_q;
  logic [33:0] fraction_q;
  logic signed [23:0] speed_q;
  logic signed [27:0] step;
  logic signed [35:0] fraction;
  logic signed [16:0] slew_q;
  logic signed [1:0] carry, nudge;
  logic [3:0] filter_q, speed_filter_q;
  logic returned_q, kept_returned_q, armed_q, compare_q, latch_q, shift_q, restart_q, unit_start, other_start;
  logic write;
  logic [11:0] place;

  assign write       = register_i.write && !register_i.application;
  assign place       = register_i.address;
  assign unit_start  = looped_i ? start_i[1] : start_i[0];
  assign other_start = looped_i ? 1'b0 : start_i[1];

  // Time goes on.
  assign step     = {{1{speed_q[23]}}, speed_q, 3'd0} + {{3{speed_q[23]}}, speed_q, 1'b0};
  assign fraction = $signed({2'b00, fraction_q}) + 36'(step);
  assign carry    = fraction[35:34];
  assign nudge    = slew_q == '0 ? 2'sd0 : slew_q[16] ? -2'sd1 : 2'sd1;
  logic signed [2:0] extra;
  logic [4:0] increment;
  assign extra     = 3'(carry) + 3'(nudge);
  assign increment = 5'(Nanoseconds) + 5'(extra);
  logic [4:0] increment_q;  // of the clock to come

  // Comparison.
  logic [31:0] target_q;
  logic signed [31:0] error, mean_step;
  logic signed [16:0] error_q;
  logic signed [23:0] correction;
  logic signed [16:0] phase;
  logic signed [24:0] speed;
  logic [3:0] compared_q;  // the comparison's clocks
  logic signed [31:0] mean_q;  // e with 15 bits after the point
  always_ff @(posedge clk_i) begin
    error     <= kept_system_q - target_q;
    mean_step <= ($signed({error_q, 15'd0}) - mean_q) >>> filter_q;
  end
  assign phase      = error_q >>> filter_q;
  assign correction = 24'(error_q) <<< (5'd16 - {1'b0, speed_filter_q});
  assign speed      = 25'(speed_q) - 25'(correction);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      local_q         <= '0;
      fraction_q      <= '0;
      slew_q          <= '0;
      speed_q         <= '0;
      increment_q     <= 5'(Nanoseconds);
      system_q        <= '0;
      offset_q        <= '0;
      offset_new_q    <= '0;
      delay_q         <= '0;
      filter_q        <= 4'(esc_regmap_pkg::RESET_DIFFERENCE_FILTER);
      speed_filter_q  <= 4'(esc_regmap_pkg::RESET_SPEED_FILTER);
      returned_q      <= 1'b0;
      kept_returned_q <= 1'b0;
      armed_q         <= 1'b0;
      compare_q       <= 1'b0;
      latch_q         <= 1'b0;
      shift_q         <= 1'b0;
      restart_q       <= 1'b0;
      compared_q      <= '0;
      error_q         <= '0;
      mean_q          <= '0;
      time_0_q        <= '0;
      time_1_q        <= '0;
      unit_time_q     <= '0;
    end else begin
      increment_q <= increment;
      local_q    <= local_q + 64'(increment_q);
      fraction_q <= fraction[33:0];
      system_q   <= local_q + offset_q;

      // What a frame's writes ask for, until all of them are in force.
      if (write) begin
        if (place == esc_regmap_pkg::REG_RECEIVE_TIME_0) latch_q <= 1'b1;
        if (place == esc_regmap_pkg::REG_SYSTEM_TIME + 12'd3) compare_q <= 1'b1;
        if (place[11:3] == esc_regmap_pkg::REG_TIME_OFFSET[11:3]) begin
          offset_new_q[8*place[2:0]+:8] <= register_i.data;
          shift_q <= 1'b1;
        end
        if (place[11:2] == esc_regmap_pkg::REG_TIME_DELAY[11:2]) delay_q[8*place[1:0]+:8] <= register_i.data;
        if (place == esc_regmap_pkg::REG_SPEED_START) restart_q <= 1'b1;
        if (place == esc_regmap_pkg::REG_DIFFERENCE_FILTER) filter_q <= 4'(register_i.data);
        if (place == esc_regmap_pkg::REG_SPEED_FILTER) speed_filter_q <= 4'(register_i.data);
      end
      if (unit_start) returned_q <= 1'b0;
      else if (other_start && !returned_q) returned_q <= 1'b1;
      if (frame_end_i) kept_returned_q <= returned_q;
      compared_q <= {compared_q[2:0], done_i && compare_q};
      if (done_i) begin
        latch_q   <= 1'b0;
        compare_q <= 1'b0;
        shift_q   <= 1'b0;
        restart_q <= 1'b0;
        if (shift_q) offset_q <= offset_new_q;
        if (latch_q) begin
          unit_time_q <= kept_local_q;
          if (looped_i) begin
            time_1_q <= kept_local_q[31:0];
          end else begin
            time_0_q <= kept_0_q;
            if (kept_returned_q) time_1_q <= kept_return_q;
            else armed_q <= !returned_q;
            if (!kept_returned_q && returned_q) time_1_q <= return_q;
          end
        end
      end
      if (armed_q && other_start) begin
        time_1_q <= local_q[31:0];
        armed_q  <= 1'b0;
      end
      // The control.
      if (compared_q[1]) begin
        error_q <= error > 32'(Most) ? Most : error < -(32'(Most)) ? -Most : 17'(error);
      end
      if (done_i && restart_q) begin
        speed_q <= '0;
        slew_q  <= '0;
        mean_q  <= '0;
      end else if (compared_q[2]) begin
        slew_q <= -phase;
        if (speed[24] == speed[23]) speed_q <= speed[23:0];
      end else if (slew_q != '0) begin
        slew_q <= slew_q - 17'(nudge);
      end
      if (compared_q[3] && !(done_i && restart_q)) mean_q <= mean_q + mean_step;
    end
  end

  always_ff @(posedge clk_i) begin
    if (unit_start) begin
      begun_local_q  <= local_q;
      begun_system_q <= system_q;
    end
    if (start_i[0]) begun_0_q <= local_q[31:0];
    if (other_start && !returned_q) return_q <= local_q[31:0];
    if (frame_end_i) begin
      kept_local_q  <= begun_local_q;
      kept_system_q <= begun_system_q[31:0];
      kept_0_q      <= begun_0_q;
      kept_return_q <= return_q;
    end
    if (write && place[11:2] == esc_regmap_pkg::REG_SYSTEM_TIME[11:2]) received_q[8*place[1:0]+:8] <= register_i.data;
    target_q <= received_q + delay_q;
  end

  // Reads.
  logic [63:0] shown_q, shown;
  logic [30:0] mean;
  logic [31:0] difference;
  logic signed [31:0] mean_whole;
  assign mean_whole = mean_q >>> 15;
  assign mean       = 31'(mean_q[31] ? -mean_whole : mean_whole);
  assign shown      = live_application_i ? (live_address_i[2:0] == '0 ? system_q : shown_q) : begun_system_q;
  always_ff @(posedge clk_i) begin
    if (live_application_i && live_read_i && live_address_i == esc_regmap_pkg::REG_SYSTEM_TIME) shown_q <= system_q;
  end

  always_comb begin
    difference = '0;
    difference[esc_regmap_pkg::TIME_DIFFERENCE_SIZE_LSB+:31] = mean;
    difference[esc_regmap_pkg::TIME_DIFFERENCE_BEHIND_LSB]   = mean_q[31];
    live_hit_o  = 1'b1;
    live_data_o = '0;
    case (live_address_i[11:3])
      esc_regmap_pkg::REG_RECEIVE_TIME_0[11:3]: begin
        live_data_o = live_address_i[2] ? time_1_q[8*live_address_i[1:0]+:8] : time_0_q[8*live_address_i[1:0]+:8];
      end
      esc_regmap_pkg::REG_SYSTEM_TIME[11:3]: live_data_o = shown[8*live_address_i[2:0]+:8];
      esc_regmap_pkg::REG_RECEIVE_TIME_UNIT[11:3]: live_data_o = unit_time_q[8*live_address_i[2:0]+:8];
      esc_regmap_pkg::REG_TIME_DELAY[11:3]: begin
        live_hit_o  = live_address_i[2];
        live_data_o = difference[8*live_address_i[1:0]+:8];
      end
      esc_regmap_pkg::REG_SPEED_DIFFERENCE[11:3]: begin
        live_hit_o  = live_address_i[2:1] == esc_regmap_pkg::REG_SPEED_DIFFERENCE[2:1];
        live_data_o = live_address_i[0] ? speed_q[23:16] : speed_q[15:8];
      end
      default: live_hit_o = 1'b0;
    endcase
  end

  assign time_o = system_q;

  logic unused;
  assign unused = &{register_i.read};

endmodule
