// SPDX-License-Identifier: Apache-2.0
// drive_front_end: motors' encoders, currents and gates, as an Avalon-MM agent with a link to a processor.
// Contract: register map docs/drive_regmap.md, 32-bit word accesses, writes one cycle, reads two. In every
// half period of the carrier one window of the currents, then positions and currents are sampled in one
// clock and the link runs the processor; its values are in force from the next half period on. With
// LINK.orders the run gets order_i too, which another processor commits (binary32, all of one clock).
// A fault of a run, a trigger while the link is at work, stop_i with LINK.orders, or a bus voltage
// below GUARD.bus or above BUS_LIMIT trips every axis. Bus voltage: bus_i, signed; gates are off after the
// third clock edge that sees it outside. chopper_o follows one edge after bus_i: on above CHOPPER.on, off
// below CHOPPER.off; trips do not change it. Guards of the sensors, each off after a reset: drive_plausible
// looks at the values of the link, current_sum at a third sensor, index_check at the encoder. position_o is POSITION + ORIGIN.
// With its bit of External an axis takes count and faults (STATUS.illegal, ILLEGAL) of another encoder's block, whose
// clear_i is external_clear_o.
module drive_front_end #(
    parameter int unsigned Axes          = 5,   // 1..8
    parameter int unsigned ClocksPerBit  = 6,
    parameter int unsigned SlowRate      = 64,
    parameter int unsigned FastRate      = 8,
    parameter int unsigned LeastDeadTime = 12,
    parameter int unsigned ThirdSensor   = 0,   // 1: bit_c_i, for the sum of the currents
    parameter int unsigned EdgeStamps    = 0,   // 1: STAMP and STAMP_POSITION
    parameter int unsigned External      = 0    // bit n: axis n counts by external_position_i, not by A and B
) (
    input  logic              clk_i,
    input  logic              rst_ni,
    // Avalon-MM agent
    input  logic [drive_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic              read_i,
    input  logic              write_i,
    input  logic [31:0]       writedata_i,
    output logic [31:0]       readdata_o,
    output logic              waitrequest_o,
    // processor, Avalon-MM
    output logic [13:0]       core_address_o,
    output logic              core_read_o,
    output logic              core_write_o,
    output logic [31:0]       core_writedata_o,
    input  logic [31:0]       core_readdata_i,
    input  logic              core_waitrequest_i,
    input  logic              core_irq_i,
    // the processor that orders forces
    input  logic [32*Axes-1:0] order_i,
    input  logic              stop_i,       // it has faulted
    output logic [32*Axes-1:0] position_o,
    // motors
    input  logic [Axes-1:0]   a_i,
    input  logic [Axes-1:0]   b_i,
    input  logic [Axes-1:0]   z_i,
    input  logic [32*Axes-1:0] external_position_i,  // of absolute_position or hall_decoder
    input  logic [Axes-1:0]   external_fault_i,
    input  logic [8*Axes-1:0] external_count_i,
    output logic [Axes-1:0]   external_clear_o,
    output logic              mclk_o,
    input  logic [Axes-1:0]   bit_a_i,
    input  logic [Axes-1:0]   bit_b_i,
    input  logic [Axes-1:0]   bit_c_i,
    input  logic signed [15:0] bus_i,
    input  logic [Axes-1:0]   fault_i,
    output logic [3*Axes-1:0] high_o,
    output logic [3*Axes-1:0] low_o,
    output logic [Axes-1:0]   release_o,   // holding brakes; a trip closes them
    output logic              chopper_o    // switch of the brake resistor across the bus
);

  localparam logic [1:0] MoRun = 2'd2;  // of pwm_bridge
  localparam int unsigned Width = drive_regmap_pkg::PWM_HALF_PERIOD_WIDTH;
  localparam int unsigned ModeBits = drive_regmap_pkg::MODE_AXIS0_WIDTH;
  localparam int unsigned DeadBits = drive_regmap_pkg::DEAD_TIME_CLOCKS_WIDTH;
  localparam int unsigned FilterBits = drive_regmap_pkg::ENCODER_FILTER_WIDTH;
  localparam int unsigned SlowWidth = 3 * $clog2(SlowRate) + 1;
  localparam int unsigned FastWidth = 3 * $clog2(FastRate) + 1;
  localparam int unsigned SumWidth = SlowWidth + 1;
  localparam int unsigned Samples = 4 * Axes + 1;
  localparam int unsigned WordBits = $clog2(5 * Axes + 1);
  localparam int unsigned Index = drive_regmap_pkg::ADDRESS_WIDTH;

  logic read_q, compare_write, compare_commit, write_q, link_clear, control_write;
  logic [Index-1:0] register_index;
  logic [2**Index-1:0] reads;  // one bit a register
  logic [31:0] time_q, read_data, readdata_q;
  logic [31:0] config_word, status_word, pwm_word, link_word, guard_word;
  logic signed [15:0] bus_least_q, bus_most_q, chopper_on_q, chopper_off_q;
  logic [7:0] release_q;
  logic [8*ModeBits-1:0] mode_q;
  logic [Width-1:0] half_period_q, minimum_q, window_start_q, count, unused_half;
  logic [DeadBits-1:0] dead_time_q;
  logic [FastWidth-1:0] limit_q;
  logic [FilterBits-1:0] filter_q;
  logic enable_q, orders_q, guard_encoder_q, late_q, fault_q, under_q, stop_q, bus_over_q, alarm;
  logic chopper_q, link_q;
  logic [SumWidth-1:0] sum_limit_q;
  logic [15:0] follow_current_q;
  logic [7:0] follow_persist_q;
  logic [(Width+2)*Axes-1:0] follow_voltage_q;
  logic signed [SlowWidth-1:0] follow_a, follow_b;
  logic [Axes-1:0] running, lost, sum_over, passes, index_lost;
  logic [24*Axes-1:0] index_distance_q;
  logic [8*Axes-1:0] index_tolerance_q;
  logic [31:0] cause_word;
  logic up, load, window;
  logic strobe, fast_valid, done, sampled_q;
  logic [2:0] corner, fast;
  logic link_valid, link_done, link_busy, link_late, link_fault;
  logic [2:0] link_axis, value_axis;
  logic [1:0] link_phase, value_phase;
  logic [Width-1:0] link_value, value, bounded;
  logic [1:0] commit_q, phase_q;
  logic [2:0] axis_q;
  logic [WordBits-1:0] word;
  logic [31:0] order;
  logic [32*Axes-1:0] order_q, origin_q;
  logic signed [22:0] sample;
  logic [Axes-1:0] trip, illegal, index, over, unused_over, clear;
  logic [32*Axes-1:0] position, index_position, edge_time, current_a, current_b;
  logic [32*Axes-1:0] stamp, stamp_position;
  logic stamp_sample;
  logic [8*Axes-1:0] illegal_count;
  logic signed [22:0] samples_q[0:Samples-1];

  assign register_index = address_i;
  assign reads          = (2 ** Index)'(1) << register_index;
  assign control_write  = write_i && register_index == drive_regmap_pkg::REG_CONTROL;
  assign compare_write  = write_i && register_index == drive_regmap_pkg::REG_COMPARE && !enable_q;
  assign compare_commit = compare_write && writedata_i[drive_regmap_pkg::COMPARE_COMMIT_LSB];
  assign link_clear     = control_write && writedata_i[drive_regmap_pkg::CONTROL_LINK_LSB];
  assign stamp_sample   = control_write && writedata_i[drive_regmap_pkg::CONTROL_STAMP_LSB];
  assign clear          = control_write
                          ? writedata_i[drive_regmap_pkg::CONTROL_CLEAR_LSB+:Axes] : '0;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      time_q           <= '0;
      mode_q           <= '0;
      half_period_q    <= drive_regmap_pkg::RESET_PWM[drive_regmap_pkg::PWM_HALF_PERIOD_LSB+:Width];
      minimum_q        <= drive_regmap_pkg::RESET_PWM[drive_regmap_pkg::PWM_MINIMUM_LSB+:Width];
      dead_time_q      <=
          drive_regmap_pkg::RESET_DEAD_TIME[drive_regmap_pkg::DEAD_TIME_CLOCKS_LSB+:DeadBits];
      window_start_q   <= drive_regmap_pkg::RESET_WINDOW[drive_regmap_pkg::WINDOW_START_LSB+:Width];
      limit_q          <=
          drive_regmap_pkg::RESET_CURRENT_LIMIT[drive_regmap_pkg::CURRENT_LIMIT_SIZE_LSB+:FastWidth];
      filter_q         <=
          drive_regmap_pkg::RESET_ENCODER[drive_regmap_pkg::ENCODER_FILTER_LSB+:FilterBits];
      bus_least_q      <= '0;
      bus_most_q       <= '0;
      chopper_on_q     <= '0;
      chopper_off_q    <= '0;
      release_q        <= '0;
      enable_q         <= 1'b0;
      orders_q         <= 1'b0;
      guard_encoder_q  <= 1'b0;
      late_q           <= 1'b0;
      fault_q          <= 1'b0;
      under_q          <= 1'b0;
      stop_q           <= 1'b0;
      bus_over_q       <= 1'b0;
      chopper_q        <= 1'b0;
      sum_limit_q      <= '0;
      follow_current_q <= '0;
      follow_persist_q <= '0;
      link_q           <= 1'b0;
      write_q          <= 1'b0;
      commit_q         <= '0;
      read_q           <= 1'b0;
    end else begin
      time_q           <= time_q + 32'd1;
      read_q           <= read_i && !read_q;
      late_q           <= (late_q && !link_clear) || link_late;
      fault_q          <= (fault_q && !link_clear) || link_fault;
      under_q          <= (under_q && !link_clear) || (bus_i < bus_least_q && bus_least_q != '0);
      stop_q           <= (stop_q && !link_clear) || (stop_i && orders_q);
      bus_over_q       <= (bus_over_q && !link_clear) || (bus_i > bus_most_q && bus_most_q != '0);
      chopper_q        <= chopper_on_q != '0 && (bus_i > chopper_on_q || (chopper_q && bus_i >= chopper_off_q));
      write_q          <= link_valid || compare_write;
      link_q           <= link_valid;
      commit_q         <= {commit_q[0], link_done || compare_commit};
      if (write_i) begin
        case (register_index)
          drive_regmap_pkg::REG_MODE: mode_q <= writedata_i[drive_regmap_pkg::MODE_AXIS0_LSB+:8*ModeBits];
          drive_regmap_pkg::REG_PWM: begin
            half_period_q <= writedata_i[drive_regmap_pkg::PWM_HALF_PERIOD_LSB+:Width];
            minimum_q     <= writedata_i[drive_regmap_pkg::PWM_MINIMUM_LSB+:Width];
          end
          drive_regmap_pkg::REG_DEAD_TIME:
          dead_time_q <= writedata_i[drive_regmap_pkg::DEAD_TIME_CLOCKS_LSB+:DeadBits];
          drive_regmap_pkg::REG_WINDOW:
          window_start_q <= writedata_i[drive_regmap_pkg::WINDOW_START_LSB+:Width];
          drive_regmap_pkg::REG_CURRENT_LIMIT:
          limit_q <= writedata_i[drive_regmap_pkg::CURRENT_LIMIT_SIZE_LSB+:FastWidth];
          drive_regmap_pkg::REG_ENCODER:
          filter_q <= writedata_i[drive_regmap_pkg::ENCODER_FILTER_LSB+:FilterBits];
          drive_regmap_pkg::REG_LINK: begin
            enable_q <= writedata_i[drive_regmap_pkg::LINK_ENABLE_LSB];
            if (!link_busy) orders_q <= writedata_i[drive_regmap_pkg::LINK_ORDERS_LSB];
          end
          drive_regmap_pkg::REG_GUARD: begin
            bus_least_q     <= writedata_i[drive_regmap_pkg::GUARD_BUS_LSB+:16];
            guard_encoder_q <= writedata_i[drive_regmap_pkg::GUARD_ENCODER_LSB];
          end
          drive_regmap_pkg::REG_BRAKE:
          release_q <= writedata_i[drive_regmap_pkg::BRAKE_RELEASE_LSB+:8];
          drive_regmap_pkg::REG_BUS_LIMIT:
          bus_most_q <= writedata_i[drive_regmap_pkg::BUS_LIMIT_MOST_LSB+:16];
          drive_regmap_pkg::REG_CHOPPER: begin
            chopper_on_q  <= writedata_i[drive_regmap_pkg::CHOPPER_ON_LSB+:16];
            chopper_off_q <= writedata_i[drive_regmap_pkg::CHOPPER_OFF_LSB+:16];
          end
          drive_regmap_pkg::REG_CURRENT_SUM:
          sum_limit_q <= writedata_i[drive_regmap_pkg::CURRENT_SUM_SIZE_LSB+:SumWidth];
          drive_regmap_pkg::REG_PLAUSIBLE: begin
            follow_current_q <= writedata_i[drive_regmap_pkg::PLAUSIBLE_CURRENT_LSB+:16];
            follow_persist_q <= writedata_i[drive_regmap_pkg::PLAUSIBLE_PERSIST_LSB+:8];
          end
          default: ;
        endcase
      end
    end
  end

  function automatic logic [31:0] shown(input logic chosen, input logic [31:0] data);
    shown = chosen ? data : 32'd0;
  endfunction

  always_comb begin
    config_word = 32'd0;
    status_word = 32'd0;
    pwm_word    = 32'd0;
    link_word   = 32'd0;
    guard_word  = 32'd0;
    cause_word  = 32'd0;
    config_word[drive_regmap_pkg::CONFIG_AXES_LSB+:4]            = 4'(Axes);
    config_word[drive_regmap_pkg::CONFIG_BIT_CLOCKS_LSB+:6]      = 6'(ClocksPerBit);
    config_word[drive_regmap_pkg::CONFIG_FAST_LOG2_LSB+:4]       = 4'($clog2(FastRate));
    config_word[drive_regmap_pkg::CONFIG_SLOW_LOG2_LSB+:4]       = 4'($clog2(SlowRate));
    config_word[drive_regmap_pkg::CONFIG_THIRD_SENSOR_LSB]       = ThirdSensor != 0;
    config_word[drive_regmap_pkg::CONFIG_EDGE_STAMPS_LSB]        = EdgeStamps != 0;
    config_word[drive_regmap_pkg::CONFIG_LEAST_DEAD_TIME_LSB+:8] = 8'(LeastDeadTime);
    status_word[drive_regmap_pkg::STATUS_TRIP_LSB+:8]            = 8'(trip);
    status_word[drive_regmap_pkg::STATUS_ILLEGAL_LSB+:8]         = 8'(illegal);
    status_word[drive_regmap_pkg::STATUS_INDEX_LSB+:8]           = 8'(index);
    status_word[drive_regmap_pkg::STATUS_LATE_LSB]               = late_q;
    status_word[drive_regmap_pkg::STATUS_FAULT_LSB]              = fault_q;
    status_word[drive_regmap_pkg::STATUS_BUSY_LSB]               = link_busy;
    status_word[drive_regmap_pkg::STATUS_UNDERVOLTAGE_LSB]       = under_q;
    status_word[drive_regmap_pkg::STATUS_STOP_LSB]               = stop_q;
    status_word[drive_regmap_pkg::STATUS_OVERVOLTAGE_LSB]        = bus_over_q;
    status_word[drive_regmap_pkg::STATUS_CHOPPER_LSB]            = chopper_q;
    pwm_word[drive_regmap_pkg::PWM_HALF_PERIOD_LSB+:Width]       = half_period_q;
    pwm_word[drive_regmap_pkg::PWM_MINIMUM_LSB+:Width]           = minimum_q;
    link_word[drive_regmap_pkg::LINK_ENABLE_LSB]                 = enable_q;
    link_word[drive_regmap_pkg::LINK_ORDERS_LSB]                 = orders_q;
    guard_word[drive_regmap_pkg::GUARD_BUS_LSB+:16]              = bus_least_q;
    guard_word[drive_regmap_pkg::GUARD_ENCODER_LSB]              = guard_encoder_q;
    cause_word[drive_regmap_pkg::CAUSE_PLAUSIBLE_LSB+:8]         = 8'(lost);
    cause_word[drive_regmap_pkg::CAUSE_SUM_LSB+:8]               = 8'(sum_over);
    cause_word[drive_regmap_pkg::CAUSE_INDEX_LOST_LSB+:8]        = 8'(index_lost);
  end

  // An OR of values of which one at most is not 0 is smaller than a case.
  always_comb begin
    // verilog_format: off - it breaks calls inside their parentheses
    read_data = shown(reads[drive_regmap_pkg::REG_ID], drive_regmap_pkg::RESET_ID)
        | shown(reads[drive_regmap_pkg::REG_CONFIG], config_word)
        | shown(reads[drive_regmap_pkg::REG_STATUS], status_word)
        | shown(reads[drive_regmap_pkg::REG_MODE], 32'(mode_q))
        | shown(reads[drive_regmap_pkg::REG_PWM], pwm_word)
        | shown(reads[drive_regmap_pkg::REG_DEAD_TIME], 32'(dead_time_q))
        | shown(reads[drive_regmap_pkg::REG_WINDOW], 32'(window_start_q))
        | shown(reads[drive_regmap_pkg::REG_CURRENT_LIMIT], 32'(limit_q))
        | shown(reads[drive_regmap_pkg::REG_ENCODER], 32'(filter_q))
        | shown(reads[drive_regmap_pkg::REG_LINK], link_word)
        | shown(reads[drive_regmap_pkg::REG_GUARD], guard_word)
        | shown(reads[drive_regmap_pkg::REG_BRAKE], 32'(release_q))
        | shown(reads[drive_regmap_pkg::REG_BUS_LIMIT], {16'd0, bus_most_q})
        | shown(reads[drive_regmap_pkg::REG_CHOPPER], {chopper_off_q, chopper_on_q})
        | shown(reads[drive_regmap_pkg::REG_CURRENT_SUM], 32'(sum_limit_q))
        | shown(reads[drive_regmap_pkg::REG_CAUSE], cause_word)
        | shown(reads[drive_regmap_pkg::REG_PLAUSIBLE], {8'd0, follow_persist_q, follow_current_q})
        | shown(reads[drive_regmap_pkg::REG_TIME], time_q);
    for (int unsigned i = 0; i < Axes; i++)
      read_data = read_data
          | shown(reads[drive_regmap_pkg::REG_POSITION + Index'(i)], position[32*i+:32])
          | shown(reads[drive_regmap_pkg::REG_EDGE_TIME + Index'(i)], edge_time[32*i+:32])
          | shown(reads[drive_regmap_pkg::REG_INDEX + Index'(i)], index_position[32*i+:32])
          | shown(reads[drive_regmap_pkg::REG_ORIGIN + Index'(i)], origin_q[32*i+:32])
          | shown(reads[drive_regmap_pkg::REG_INDEX_DISTANCE + Index'(i)],
                  {index_tolerance_q[8*i+:8], index_distance_q[24*i+:24]})
          | shown(reads[drive_regmap_pkg::REG_PLAUSIBLE_VOLTAGE + Index'(i)],
                  32'(follow_voltage_q[(Width+2)*i+:Width+2]))
          | shown(reads[drive_regmap_pkg::REG_CURRENT_A + Index'(i)], current_a[32*i+:32])
          | shown(reads[drive_regmap_pkg::REG_CURRENT_B + Index'(i)], current_b[32*i+:32])
          | shown(reads[drive_regmap_pkg::REG_STAMP + Index'(i)], stamp[32*i+:32])
          | shown(reads[drive_regmap_pkg::REG_STAMP_POSITION + Index'(i)], stamp_position[32*i+:32])
          | shown(reads[drive_regmap_pkg::REG_ILLEGAL + Index'(i)], {24'd0, illegal_count[8*i+:8]});
    // verilog_format: on
  end

  always_ff @(posedge clk_i) begin
    readdata_q <= read_data;
    axis_q     <= value_axis;
    phase_q    <= value_phase;
  end

  pwm_carrier #(
      .Width(Width)
  ) u_carrier (
      .clk_i,
      .rst_ni,
      .half_period_i (half_period_q),
      .window_start_i(window_start_q),
      .count_o       (count),
      .up_o          (up),
      .load_o        (load),
      .window_o      (window),
      .half_o        (unused_half)
  );

  pwm_bound #(
      .Width(Width)
  ) u_bound (
      .clk_i,
      .rst_ni,
      .half_i   (half_period_q),
      .minimum_i(minimum_q),
      .value_i  (value),
      .value_o  (bounded)
  );

  sinc3_timing #(
      .ClocksPerBit(ClocksPerBit),
      .SlowRate    (SlowRate),
      .FastRate    (FastRate)
  ) u_timing (
      .clk_i,
      .rst_ni,
      .window_i    (window),
      .mclk_o,
      .strobe_o    (strobe),
      .corner_o    (corner),
      .done_o      (done),
      .fast_o      (fast),
      .fast_valid_o(fast_valid)
  );

  genvar axis;
  generate
    for (axis = 0; axis < Axes; axis++) begin : gen_axis
      logic signed [SlowWidth-1:0] slow_a, slow_b;
      logic [31:0] age;

      drive_axis #(
          .Width        (Width),
          .DeadBits     (DeadBits),
          .LeastDeadTime(LeastDeadTime),
          .SlowRate     (SlowRate),
          .FastRate     (FastRate),
          .FilterBits   (FilterBits),
          .ThirdSensor  (ThirdSensor),
          .External     ((External >> axis) & 1)
      ) u_axis (
          .clk_i,
          .rst_ni,
          .a_i             (a_i[axis]),
          .b_i             (b_i[axis]),
          .z_i             (z_i[axis]),
          .filter_i        (filter_q),
          .time_i          (time_q),
          .position_o      (position[32*axis+:32]),
          .edge_time_o     (edge_time[32*axis+:32]),
          .index_o         (index[axis]),
          .index_position_o(index_position[32*axis+:32]),
          .passes_o        (passes[axis]),
          .illegal_o       (illegal[axis]),
          .illegal_count_o (illegal_count[8*axis+:8]),
          .external_position_i(external_position_i[32*axis+:32]),
          .external_fault_i   (external_fault_i[axis]),
          .external_count_i   (external_count_i[8*axis+:8]),
          .bit_a_i         (bit_a_i[axis]),
          .bit_b_i         (bit_b_i[axis]),
          .bit_c_i         (bit_c_i[axis]),
          .strobe_i        (strobe),
          .corner_i        (corner),
          .fast_i          (fast),
          .fast_valid_i    (fast_valid),
          .limit_i         (limit_q),
          .done_i          (done),
          .sum_limit_i     (sum_limit_q),
          .sum_over_o      (sum_over[axis]),
          .current_a_o     (slow_a),
          .current_b_o     (slow_b),
          .over_o          (over[axis]),
          .count_i         (count),
          .up_i            (up),
          .load_i          (load),
          .mode_i          (mode_q[ModeBits*axis+:ModeBits]),
          .dead_time_i     (dead_time_q),
          .write_i         (write_q && axis_q == 3'(axis)),
          .phase_i         (phase_q),
          .value_i         (bounded),
          .commit_i        (commit_q[1]),
          .fault_i         (fault_i[axis]),
          .alarm_i         (alarm || (illegal[axis] && guard_encoder_q) || lost[axis] || index_lost[axis]),
          .clear_i         (clear[axis]),
          .trip_o          (trip[axis]),
          .high_o          (high_o[3*axis+:3]),
          .low_o           (low_o[3*axis+:3])
      );

      if (EdgeStamps != 0) begin : gen_stamp
        quadrature_time u_time (
            .clk_i,
            .rst_ni,
            .position_i(position[32*axis+:32]),
            .sample_i  (stamp_sample),
            .position_o(stamp_position[32*axis+:32]),
            .stamp_o   (stamp[32*axis+:32])
        );
      end else begin : gen_no_stamp
        logic unused_sample;
        assign unused_sample               = stamp_sample;
        assign stamp_position[32*axis+:32] = '0;
        assign stamp[32*axis+:32]          = '0;
      end

      assign current_a[32*axis+:32] = {{9{samples_q[4*axis+1][22]}}, samples_q[4*axis+1]};
      assign current_b[32*axis+:32] = {{9{samples_q[4*axis+2][22]}}, samples_q[4*axis+2]};
      assign age = time_q - edge_time[32*axis+:32];

      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) begin
          origin_q[32*axis+:32]                      <= '0;
          follow_voltage_q[(Width+2)*axis+:Width+2] <= '0;
          index_distance_q[24*axis+:24]             <= '0;
          index_tolerance_q[8*axis+:8]              <= '0;
        end else if (write_i) begin
          if (register_index == drive_regmap_pkg::REG_ORIGIN + Index'(axis)) origin_q[32*axis+:32] <= writedata_i;
          if (register_index == drive_regmap_pkg::REG_PLAUSIBLE_VOLTAGE + Index'(axis))
            follow_voltage_q[(Width+2)*axis+:Width+2] <= writedata_i[Width+1:0];
          if (register_index == drive_regmap_pkg::REG_INDEX_DISTANCE + Index'(axis)) begin
            index_distance_q[24*axis+:24] <= writedata_i[drive_regmap_pkg::INDEX_DISTANCE_COUNTS_LSB+:24];
            index_tolerance_q[8*axis+:8]  <= writedata_i[drive_regmap_pkg::INDEX_DISTANCE_TOLERANCE_LSB+:8];
          end
        end
      end

      always_ff @(posedge clk_i) position_o[32*axis+:32] <= position[32*axis+:32] + origin_q[32*axis+:32];

      assign running[axis]   = mode_q[ModeBits*axis+:ModeBits] == MoRun && !trip[axis];
      assign release_o[axis] = release_q[axis] && running[axis];

      // What the link hands over, all of one clock. Ages beyond 2^22 clocks show as that.
      always_ff @(posedge clk_i) begin
        if (done) begin
          samples_q[4*axis]   <= position[32*axis+:23];
          samples_q[4*axis+1] <= {{(23 - SlowWidth) {slow_a[SlowWidth-1]}}, slow_a};
          samples_q[4*axis+2] <= {{(23 - SlowWidth) {slow_b[SlowWidth-1]}}, slow_b};
          samples_q[4*axis+3] <= (age[31:22] != '0) ? 23'h3f_ffff : age[22:0];
        end
      end
    end
  endgenerate

  always_ff @(posedge clk_i) begin
    if (done) begin
      samples_q[Samples-1] <= 23'(bus_i);
      order_q              <= order_i;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sampled_q <= 1'b0;
    end else begin
      sampled_q <= done;
    end
  end

  index_check #(
      .Axes(Axes)
  ) u_index (
      .clk_i,
      .rst_ni,
      .position_i      (position),
      .index_position_i(index_position),
      .passes_i        (passes),
      .distance_i      (index_distance_q),
      .tolerance_i     (index_tolerance_q),
      .clear_i         (clear),
      .lost_o          (index_lost)
  );

  drive_plausible #(
      .Axes    (Axes),
      .Width   (Width),
      .SlowRate(SlowRate)
  ) u_plausible (
      .clk_i,
      .rst_ni,
      .write_i    (link_q),
      .axis_i     (axis_q),
      .phase_i    (phase_q),
      .value_i    (bounded),
      .current_a_i(follow_a),
      .current_b_i(follow_b),
      .run_i      (running),
      .clear_i    (clear),
      .voltage_i  (follow_voltage_q),
      .current_i  (follow_current_q),
      .persist_i  (follow_persist_q),
      .lost_o     (lost)
  );

  servo_link #(
      .Axes (Axes),
      .Width(Width)
  ) u_link (
      .clk_i,
      .rst_ni,
      .enable_i     (enable_q),
      .trigger_i    (sampled_q),
      .orders_i     (orders_q),
      .word_o       (word),
      .sample_i     (sample),
      .order_i      (order),
      .value_valid_o(link_valid),
      .axis_o       (link_axis),
      .phase_o      (link_phase),
      .value_o      (link_value),
      .done_o       (link_done),
      .address_o    (core_address_o),
      .read_o       (core_read_o),
      .write_o      (core_write_o),
      .writedata_o  (core_writedata_o),
      .readdata_i   (core_readdata_i),
      .waitrequest_i(core_waitrequest_i),
      .irq_i        (core_irq_i),
      .busy_o       (link_busy),
      .late_o       (link_late),
      .fault_o      (link_fault)
  );

  always_comb begin
    follow_a = '0;
    follow_b = '0;
    for (int unsigned i = 0; i < Axes; i++)
    if (axis_q == 3'(i)) begin
      follow_a = samples_q[4*i+1][SlowWidth-1:0];
      follow_b = samples_q[4*i+2][SlowWidth-1:0];
    end
  end

  always_comb begin
    sample = '0;
    order  = '0;
    for (int unsigned i = 0; i < Samples; i++) if (word == WordBits'(i)) sample = samples_q[i];
    for (int unsigned i = 0; i < Axes; i++) if (word == WordBits'(Samples + i)) order = order_q[32*i+:32];
  end

  assign alarm       = late_q || fault_q || under_q || bus_over_q || stop_q;
  assign chopper_o   = chopper_q;
  assign external_clear_o = clear;
  assign value_axis  = link_valid ? link_axis
                                  : writedata_i[drive_regmap_pkg::COMPARE_AXIS_LSB+:3];
  assign value_phase = link_valid ? link_phase
                                  : writedata_i[drive_regmap_pkg::COMPARE_PHASE_LSB+:2];
  assign value       = link_valid ? link_value
                                  : writedata_i[drive_regmap_pkg::COMPARE_VALUE_LSB+:Width];
  assign unused_over   = over;
  assign readdata_o    = readdata_q;
  assign waitrequest_o = read_i && !read_q;

`ifndef SYNTHESIS
  generate
    if (External >= (1 << Axes)) begin : gen_check_external
      $error("drive_front_end: External=%0d, must be below 2^Axes", External);
    end
    if (External != 0 && EdgeStamps != 0) begin : gen_check_stamps
      $error("drive_front_end: EdgeStamps=1 needs single counts of lines A and B; leave External 0");
    end
    if (Axes < 1 || Axes > 8) begin : gen_check_shape
      $error("drive_front_end: Axes=%0d, must be 1..8", Axes);
    end
  endgenerate
`endif

endmodule
