// SPDX-License-Identifier: Apache-2.0
// path_control: lines and arcs in whole steps, from commands to the axes that take their steps from here.
// Contract: words (layout below) and then a command; with pending_o low the next ones may be written, and
// follow the running one without a gap. A command is looked at before it moves anything: what is wrong
// sets a fault (bits below), and nothing starts until clear_i. A step is made every `period`
// clocks, or with period 0 at every pulse of an axis, so a planned profile is the speed along the path.
// A wrong access is refused with FaultOrder or FaultFeed; an overrun of an axis, or a pulse while
// seven steps wait for theirs, stops the path at once with FaultOverrun.
module path_control #(
    parameter int unsigned Axes     = 5,   // 1..8
    parameter int unsigned Width    = 24,  // bits of a coordinate
    parameter int unsigned TurnBits = 8
) (
    input  logic            clk_i,
    input  logic            rst_ni,
    // registers
    input  logic            word_write_i,
    input  logic [2:0]      word_i,
    input  logic            command_write_i,
    input  logic            feed_write_i,
    input  logic            source_write_i,
    input  logic [31:0]     data_i,
    input  logic            clear_i,      // drop the commands and the faults
    output logic            pending_o,    // a command waits
    output logic            busy_o,       // one is under way
    output logic            fault_o,      // any
    output logic [31:0]     status_o,     // registers PATH_STATUS and PATH_FEED
    output logic [31:0]     feed_o,
    output logic [Axes-1:0] source_o,     // 1: the axis takes its steps from here
    // axes
    input  logic [Axes-1:0] abort_i,      // of an axis with source_o: drop the commands
    input  logic [Axes-1:0] resting_i,
    input  logic [Axes-1:0] overrun_i,
    input  logic [Axes-1:0] pulse_i,
    output logic [Axes-1:0] step_o,
    output logic [Axes-1:0] negative_o
);

  // Words: a line in a plane has its end {v, u} in 3, 2, from its start; an arc its start in 1, 0, its end
  // in 3, 2, both from its centre, and start_u^2 + start_v^2 - R^2 in 4; a line in all axes the
  // length of axis n in n. A word never written counts as out of range.
  localparam int unsigned Words = (Axes > 5) ? Axes : 5;
  localparam logic [1:0] LINE = 2'd0, ARC = 2'd1, ALL_AXES = 2'd2;
  localparam logic [7:0] THERE = 8'({Axes{1'b1}});
  // Smallest period: an arc's step takes two clocks and a change of commands some more.
  localparam logic [23:0] SHORTEST = 24'd4;
  localparam int unsigned FaultKind = 0, FaultRange = 1, FaultCircle = 2, FaultAxis = 3, FaultFeed = 4,
                          FaultOrder = 5, FaultOverrun = 6;

  typedef enum logic [1:0] {
    StEmpty,
    StCheck,
    StMeasure,
    StReady
  } state_e;

  state_e state_q;
  logic [Width*Words-1:0] words_q;
  logic [Words-1:0] bad_q, nonzero_q;
  logic [1:0] kind_q, plane_q;
  logic combined_q, clockwise_q, running_q, all_axes_q;
  logic [TurnBits-1:0] turns_q;
  logic [Axes-1:0] source_q, step_q, negative_q;
  logic [6:0] fault_q, fault_d;
  logic [23:0] feed_period, feed_period_q;
  logic [2:0] feed_axis, feed_axis_q;
  logic lost_q, accept, stop, begins, faulty, measured, off_circle;
  logic plane_active, plane_ready, plane_valid, all_active, all_ready, active, ready, advance;

  assign accept = !pending_o && !faulty;
  assign faulty = fault_q != '0;
  assign stop   = clear_i || lost_q || ((abort_i | overrun_i) & source_q) != '0;

  // ---- registers
  logic in_range, feed_good, source_good;
  logic [Axes-1:0] changed, sources_new;

  assign in_range = (data_i[31:Width-1] == '0)
                    || (data_i[31:Width-1] == '1 && data_i[Width-2:0] != '0);
  assign feed_period = data_i[motion_regmap_pkg::PATH_FEED_PERIOD_LSB+:24];
  assign feed_axis   = data_i[motion_regmap_pkg::PATH_FEED_AXIS_LSB+:3];
  assign feed_good   = (feed_period == '0) ? THERE[feed_axis] : feed_period >= SHORTEST;
  assign sources_new = data_i[motion_regmap_pkg::SOURCE_VALUE_LSB+:Axes];
  assign changed     = sources_new ^ source_q;
  assign source_good = !pending_o && !busy_o && (changed & ~resting_i) == '0;

  always_ff @(posedge clk_i) begin
    for (int unsigned i = 0; i < Words; i++) begin
      if (word_write_i && accept && word_i == 3'(i)) begin
        words_q[Width*i+:Width] <= data_i[Width-1:0];
        nonzero_q[i]            <= data_i[Width-1:0] != '0;
      end
    end
    if (command_write_i && accept) begin
      kind_q      <= data_i[motion_regmap_pkg::PATH_COMMAND_KIND_LSB+:2];
      plane_q     <= data_i[motion_regmap_pkg::PATH_COMMAND_PLANE_LSB+:2];
      combined_q  <= data_i[motion_regmap_pkg::PATH_COMMAND_COMBINED_LSB];
      clockwise_q <= data_i[motion_regmap_pkg::PATH_COMMAND_CLOCKWISE_LSB];
      turns_q     <= data_i[motion_regmap_pkg::PATH_COMMAND_TURNS_LSB+:TurnBits];
    end
  end

  // ---- what is wrong with a command
  logic [7:0] used, need;  // its words, and the axes that it moves
  logic [7:0] bad, nonzero, sources;

  assign bad     = 8'(bad_q);
  assign nonzero = 8'(nonzero_q);
  assign sources = 8'(source_q);

  always_comb begin
    case (kind_q)
      LINE:    used = 8'b00001100;
      ARC:     used = 8'b00011111;
      default: used = THERE;
    endcase
    case (plane_q)
      2'd0:    need = 8'b00000011;
      2'd1:    need = 8'b00000101;
      default: need = 8'b00000110;
    endcase
    if (kind_q == ALL_AXES) need = nonzero & THERE;

    fault_d = '0;
    if (state_q == StCheck) begin
      fault_d[FaultKind]  = kind_q == 2'd3 || (kind_q != ALL_AXES && plane_q == 2'd3);
      fault_d[FaultRange] = !fault_d[FaultKind] && (bad & used) != 8'd0;
      fault_d[FaultAxis]  = !fault_d[FaultKind] && (need & ~sources) != 8'd0;
    end
    fault_d[FaultCircle]  = state_q == StMeasure && off_circle;
    fault_d[FaultFeed]    = feed_write_i && !feed_good;
    fault_d[FaultOrder]   = ((word_write_i || command_write_i) && pending_o)
                            || (source_write_i && !source_good);
    fault_d[FaultOverrun] = lost_q || (overrun_i & source_q) != '0;
  end

  // ---- an arc's nodes have to be on the circle: with N = u^2 + v^2 - R^2, -(|u| + |v|) <= N < |u| + |v|.
  // N of the end is that of the start and (e - s)(e + s) of both coordinates, bit by bit.
  localparam int unsigned SumBits = 2 * Width + 3;
  localparam int unsigned ProductSteps = 2 * (Width + 1);
  localparam logic [6:0] PRODUCTS = 7'd4, BEHIND = PRODUCTS + 7'(ProductSteps), END = BEHIND + 7'd4;

  logic signed [Width-1:0] start_u, start_v, end_u, end_v, node_u, node_v, one_end, one_start;
  logic signed [Width:0] difference;
  logic [Width:0] sum_u_q, sum_v_q, size;
  logic signed [SumBits-1:0] norm_q, base, operand, operand_q;
  logic [6:0] measure_q;
  logic multiplies, second, factor, negate, negate_q, double_q, clear_q;

  assign start_u = words_q[0+:Width];
  assign start_v = words_q[Width+:Width];
  assign end_u   = words_q[2*Width+:Width];
  assign end_v   = words_q[3*Width+:Width];

  assign multiplies = measure_q >= PRODUCTS && measure_q < BEHIND;
  assign second     = measure_q[0];  // v after u
  assign factor     = second ? sum_v_q[Width] : sum_u_q[Width];
  assign one_end    = second ? end_v : end_u;
  assign one_start  = second ? start_v : start_u;
  assign difference = $signed({one_end[Width-1], one_end}) - $signed({one_start[Width-1], one_start});
  assign node_u = (measure_q < PRODUCTS) ? start_u : end_u;
  assign node_v = (measure_q < PRODUCTS) ? start_v : end_v;
  assign size   = {1'b0, node_u[Width-1] ? -node_u : node_u} + {1'b0, node_v[Width-1] ? -node_v : node_v};

  // The operand, of a step each, is added a clock later.
  always_comb begin
    operand = '0;
    negate  = 1'b0;
    if (multiplies) begin
      if (factor) operand = {{(SumBits - Width - 1) {difference[Width]}}, difference};
      negate = factor && measure_q[6:1] == PRODUCTS[6:1];  // the sign's bit
    end else begin
      case (measure_q)
        7'd0, BEHIND: operand = {{(SumBits - Width) {words_q[5*Width-1]}}, words_q[4*Width+:Width]};
        7'd1, BEHIND + 7'd1: operand = {{(SumBits - Width - 1) {1'b0}}, size};
        7'd2, BEHIND + 7'd2: begin
          operand = {{(SumBits - Width - 2) {1'b0}}, size, 1'b0};
          negate  = 1'b1;
        end
        default: operand = '0;
      endcase
    end
  end

  always_comb begin
    base = norm_q;
    if (double_q) base = norm_q <<< 1;
    if (clear_q) base = '0;
  end

  always_ff @(posedge clk_i) begin
    operand_q <= negate ? ~operand : operand;
    negate_q  <= negate;
    double_q  <= multiplies && !second;
    clear_q   <= measure_q == 7'd0 || measure_q == 7'd3;
    norm_q    <= base + operand_q + $signed({{(SumBits - 1) {1'b0}}, negate_q});
    measure_q <= (state_q == StMeasure) ? measure_q + 7'd1 : 7'd0;
    if (state_q == StCheck) begin
      sum_u_q <= {end_u[Width-1], end_u} + {start_u[Width-1], start_u};
      sum_v_q <= {end_v[Width-1], end_v} + {start_v[Width-1], start_v};
    end else if (multiplies) begin
      if (second) sum_v_q <= sum_v_q << 1;
      else sum_u_q <= sum_u_q << 1;
    end
  end

  assign off_circle = ((measure_q == 7'd3 || measure_q == BEHIND + 7'd3) && norm_q[SumBits-1])
                      || ((measure_q == 7'd4 || measure_q == END) && !norm_q[SumBits-1]);
  assign measured   = measure_q == END;

  // ---- commands
  assign begins = state_q == StReady && !active && !faulty && !stop;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q   <= StEmpty;
      bad_q     <= '1;
      running_q <= 1'b0;
      fault_q   <= '0;
      source_q  <= '0;
      feed_period_q <= '0;
      feed_axis_q   <= '0;
    end else begin
      for (int unsigned i = 0; i < Words; i++) begin
        if (word_write_i && accept && word_i == 3'(i)) bad_q[i] <= !in_range;
      end
      if (feed_write_i && feed_good) begin
        feed_period_q <= feed_period;
        feed_axis_q   <= feed_axis;
      end
      if (source_write_i && source_good) source_q <= sources_new;
      fault_q <= clear_i ? '0 : fault_q | fault_d;

      if (stop || faulty || fault_d != '0) state_q <= StEmpty;
      else
        case (state_q)
          StEmpty: if (command_write_i) state_q <= StCheck;
          StCheck: state_q <= (kind_q == ARC) ? StMeasure : StReady;
          StMeasure: if (measured) state_q <= StReady;
          default: if (begins) state_q <= StEmpty;
        endcase
      running_q <= !stop && (begins || (running_q && active));
    end
  end

  // ---- speed: steps that are due, the job's own clocks being a few
  logic [23:0] period_q;
  logic [2:0] due_q;
  logic [7:0] pulses;
  logic by_pulses, due, full;

  assign by_pulses = feed_period_q == '0;
  assign pulses    = 8'(pulse_i);
  assign due       = by_pulses ? pulses[feed_axis_q] : period_q == '0;
  assign ready     = all_axes_q ? all_ready : plane_ready;
  assign advance   = ready && due_q != '0;
  assign full      = due && !advance && due_q == '1;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) due_q <= '0;
    else if (!running_q) due_q <= '0;
    else if (due && !advance && !full) due_q <= due_q + 1'b1;
    else if (!due && advance) due_q <= due_q - 1'b1;
  end

  // A period is made up for as far as it goes, but a pulse represents a part of a planned profile.
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) lost_q <= 1'b0;
    else lost_q <= running_q && by_pulses && full;

  // A shorter period than what is left counts from now.
  always_ff @(posedge clk_i)
    period_q <= ((!running_q || period_q == '0 || period_q >= feed_period_q) ? feed_period_q : period_q) - 1'b1;

  // ---- the interpolators; a stop drops their jobs
  logic [2:0] plane_step, plane_negative;
  logic [Axes-1:0] all_step, all_negative;

  step_interpolator #(
      .Width   (Width),
      .TurnBits(TurnBits)
  ) u_plane (
      .clk_i,
      .rst_ni,
      .flush_i      (stop),
      .start_i      (begins && kind_q != ALL_AXES),
      .arc_i        (kind_q == ARC),
      .plane_i      (plane_q),
      .combined_i   (combined_q),
      .clockwise_i  (clockwise_q),
      .turns_i      (turns_q),
      .start_u_i    (start_u),
      .start_v_i    (start_v),
      .end_u_i      (end_u),
      .end_v_i      (end_v),
      .start_error_i(words_q[4*Width+:Width]),
      .advance_i    (advance && !all_axes_q),
      .active_o     (plane_active),
      .ready_o      (plane_ready),
      .valid_o      (plane_valid),
      .step_o       (plane_step),
      .negative_o   (plane_negative)
  );

  synchronised_line #(
      .Axes (Axes),
      .Width(Width)
  ) u_all (
      .clk_i,
      .rst_ni,
      .flush_i   (stop),
      .start_i   (begins && kind_q == ALL_AXES),
      .lengths_i (words_q[Axes*Width-1:0]),
      .advance_i (advance && all_axes_q),
      .active_o  (all_active),
      .ready_o   (all_ready),
      .step_o    (all_step),
      .negative_o(all_negative)
  );

  assign active = plane_active || all_active;

  always_ff @(posedge clk_i) if (begins) all_axes_q <= kind_q == ALL_AXES;

  // A command for axes that are not there, or have another source, has been refused.
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) step_q <= '0;
    else if (stop) step_q <= '0;
    else if (all_axes_q) step_q <= all_step & {Axes{advance}};
    else step_q <= Axes'(plane_step) & {Axes{plane_valid}};

  always_ff @(posedge clk_i) negative_q <= all_axes_q ? all_negative : Axes'(plane_negative);

  // With fewer than three axes.
  logic unused;
  assign unused = ^{plane_step, plane_negative};

  always_comb begin
    status_o = 32'd0;
    status_o[motion_regmap_pkg::PATH_STATUS_PENDING_LSB] = pending_o;
    status_o[motion_regmap_pkg::PATH_STATUS_BUSY_LSB]    = busy_o;
    status_o[motion_regmap_pkg::PATH_STATUS_KIND_LSB]    = fault_q[FaultKind];
    status_o[motion_regmap_pkg::PATH_STATUS_RANGE_LSB]   = fault_q[FaultRange];
    status_o[motion_regmap_pkg::PATH_STATUS_CIRCLE_LSB]  = fault_q[FaultCircle];
    status_o[motion_regmap_pkg::PATH_STATUS_AXIS_LSB]    = fault_q[FaultAxis];
    status_o[motion_regmap_pkg::PATH_STATUS_FEED_LSB]    = fault_q[FaultFeed];
    status_o[motion_regmap_pkg::PATH_STATUS_ORDER_LSB]   = fault_q[FaultOrder];
    status_o[motion_regmap_pkg::PATH_STATUS_OVERRUN_LSB] = fault_q[FaultOverrun];

    feed_o = 32'd0;
    feed_o[motion_regmap_pkg::PATH_FEED_PERIOD_LSB+:24] = feed_period_q;
    feed_o[motion_regmap_pkg::PATH_FEED_AXIS_LSB+:3]    = feed_axis_q;
  end

  assign pending_o  = state_q != StEmpty;
  assign busy_o     = running_q;
  assign fault_o    = faulty;
  assign source_o   = source_q;
  assign step_o     = step_q;
  assign negative_o = negative_q;

endmodule
