// SPDX-License-Identifier: Apache-2.0
// motion_front_end: five axes of velocity control, pulse generation and step output, and the lines and
// arcs that can drive them instead, as an Avalon-MM agent.
// Contract: register map docs/motion_regmap.md, 32-bit word accesses, writes one cycle, reads two; one tick
// every ClocksPerTick clocks, a microsecond.
module motion_front_end #(
    parameter int unsigned Axes          = 5,    // 1..8
    parameter int unsigned ClocksPerTick = 100,  // clock frequency in MHz, 8*Axes + 8 .. 255
    parameter int unsigned Interpolators = 1,    // 0: without path_control, its registers read 0
    parameter logic [31:0] Modulus       = 32'd16_000_000 * ClocksPerTick  // 16 x that in Hz, even
) (
    input  logic            clk_i,
    input  logic            rst_ni,
    // Avalon-MM
    input  logic [motion_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic            read_i,
    input  logic            write_i,
    input  logic [31:0]     writedata_i,
    output logic [31:0]     readdata_o,
    output logic            waitrequest_o,
    output logic            irq_o,
    // drives
    output logic [Axes-1:0] step_o,
    output logic [Axes-1:0] direction_o
);

  localparam int unsigned TimeBits = motion_regmap_pkg::STEP_TIMING_LENGTH_WIDTH;
  localparam int unsigned TickBits = $clog2(ClocksPerTick);
  // Pulses between two ticks, one every other clock at most, and a margin.
  localparam int unsigned EventBits = $clog2(ClocksPerTick / 2 + 8);
  localparam logic [TickBits-1:0] LAST_CLOCK = TickBits'(ClocksPerTick - 1);

  logic [TickBits-1:0] clock_q;
  logic tick, in_csr, in_records, csr_write, head_write, read_q;
  logic [4:0] register_index;
  logic [31:0] ticks_q, reads, read_data, readdata_q;  // reads: one bit a register
  logic [TimeBits-1:0] length_q, space_q, setup_q, hold_q;
  logic irq_idle_q, irq_fault_q;
  logic [Axes-1:0] abort, running, moving, idle, underrun, overrun, waiting, take;
  logic [Axes-1:0] pulse, negative, first;
  logic [2:0] record_axis, record_word;
  logic [31:0] record;
  logic [32*Axes-1:0] rate;
  logic [Axes-1:0] source, path_step, path_negative;
  logic path_pending, path_busy;
  logic path_fault;
  logic [31:0] path_status, path_feed, config_word, status_word, step_word, direction_word, irq_word;
  logic [4*Axes-1:0] head, tail;
  logic [32*Axes-1:0] position;

  // Blocks are aligned powers of two.
  function automatic logic in_block(input logic [motion_regmap_pkg::ADDRESS_WIDTH-1:0] address, input int unsigned base,
                                    input int unsigned words);
    in_block = (32'(address) & ~(words - 1)) == base;
  endfunction

  assign in_csr     = in_block(address_i, motion_regmap_pkg::BASE_CSR, motion_regmap_pkg::WORDS_CSR);
  assign in_records = in_block(address_i, motion_regmap_pkg::BASE_RECORDS,
                               motion_regmap_pkg::WORDS_RECORDS);
  assign register_index = address_i[$clog2(motion_regmap_pkg::WORDS_CSR)-1:0];
  assign reads      = in_csr ? 32'd1 << register_index : 32'd0;
  assign csr_write  = write_i && in_csr;
  assign head_write = csr_write && register_index == motion_regmap_pkg::REG_HEAD;
  assign abort      = (csr_write && register_index == motion_regmap_pkg::REG_CONTROL)
                      ? writedata_i[motion_regmap_pkg::CONTROL_ABORT_LSB+:Axes] : '0;
  assign tick       = clock_q == LAST_CLOCK;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      clock_q      <= '0;
      ticks_q      <= '0;
      length_q     <= motion_regmap_pkg::RESET_STEP_TIMING[motion_regmap_pkg::STEP_TIMING_LENGTH_LSB+:TimeBits];
      space_q      <= motion_regmap_pkg::RESET_STEP_TIMING[motion_regmap_pkg::STEP_TIMING_SPACE_LSB+:TimeBits];
      setup_q      <=
          motion_regmap_pkg::RESET_DIRECTION_TIMING[motion_regmap_pkg::DIRECTION_TIMING_SETUP_LSB+:TimeBits];
      hold_q       <=
          motion_regmap_pkg::RESET_DIRECTION_TIMING[motion_regmap_pkg::DIRECTION_TIMING_HOLD_LSB+:TimeBits];
      irq_idle_q   <= 1'b0;
      irq_fault_q  <= 1'b0;
      read_q       <= 1'b0;
    end else begin
      clock_q <= tick ? '0 : clock_q + 1'b1;
      if (tick) ticks_q <= ticks_q + 32'd1;
      if (csr_write && register_index == motion_regmap_pkg::REG_STEP_TIMING) begin
        length_q <= writedata_i[motion_regmap_pkg::STEP_TIMING_LENGTH_LSB+:TimeBits];
        space_q  <= writedata_i[motion_regmap_pkg::STEP_TIMING_SPACE_LSB+:TimeBits];
      end
      if (csr_write && register_index == motion_regmap_pkg::REG_DIRECTION_TIMING) begin
        setup_q <= writedata_i[motion_regmap_pkg::DIRECTION_TIMING_SETUP_LSB+:TimeBits];
        hold_q  <= writedata_i[motion_regmap_pkg::DIRECTION_TIMING_HOLD_LSB+:TimeBits];
      end
      if (csr_write && register_index == motion_regmap_pkg::REG_IRQ_ENABLE) begin
        irq_idle_q  <= writedata_i[motion_regmap_pkg::IRQ_ENABLE_IDLE_LSB];
        irq_fault_q <= writedata_i[motion_regmap_pkg::IRQ_ENABLE_FAULT_LSB];
      end
      read_q <= read_i && !read_q;
    end
  end

  function automatic logic [31:0] shown(input logic chosen, input logic [31:0] value);
    shown = chosen ? value : 32'd0;
  endfunction

  always_comb begin
    config_word    = 32'd0;
    status_word    = 32'd0;
    step_word      = 32'd0;
    direction_word = 32'd0;
    irq_word       = 32'd0;
    config_word[motion_regmap_pkg::CONFIG_AXES_LSB+:4]       = 4'(Axes);
    config_word[motion_regmap_pkg::CONFIG_RECORDS_LSB+:4]    = 4'd8;
    config_word[motion_regmap_pkg::CONFIG_CLOCKS_LSB+:8]     = 8'(ClocksPerTick);
    config_word[motion_regmap_pkg::CONFIG_INTERPOLATORS_LSB] = Interpolators != 0;
    status_word[motion_regmap_pkg::STATUS_RUNNING_LSB+:8]    = 8'(running);
    status_word[motion_regmap_pkg::STATUS_UNDERRUN_LSB+:8]   = 8'(underrun);
    status_word[motion_regmap_pkg::STATUS_OVERRUN_LSB+:8]    = 8'(overrun);
    step_word[motion_regmap_pkg::STEP_TIMING_LENGTH_LSB+:TimeBits] = length_q;
    step_word[motion_regmap_pkg::STEP_TIMING_SPACE_LSB+:TimeBits]  = space_q;
    direction_word[motion_regmap_pkg::DIRECTION_TIMING_SETUP_LSB+:TimeBits] = setup_q;
    direction_word[motion_regmap_pkg::DIRECTION_TIMING_HOLD_LSB+:TimeBits]  = hold_q;
    irq_word[motion_regmap_pkg::IRQ_ENABLE_IDLE_LSB]         = irq_idle_q;
    irq_word[motion_regmap_pkg::IRQ_ENABLE_FAULT_LSB]        = irq_fault_q;
  end

  // An OR of values of which one at most is not 0 is smaller than a case.
  always_comb begin
    // verilog_format: off - it breaks calls inside their parentheses
    read_data = shown(reads[motion_regmap_pkg::REG_ID], motion_regmap_pkg::RESET_ID)
        | shown(reads[motion_regmap_pkg::REG_CONFIG], config_word)
        | shown(reads[motion_regmap_pkg::REG_STATUS], status_word)
        | shown(reads[motion_regmap_pkg::REG_HEAD], 32'(head))
        | shown(reads[motion_regmap_pkg::REG_TAIL], 32'(tail))
        | shown(reads[motion_regmap_pkg::REG_STEP_TIMING], step_word)
        | shown(reads[motion_regmap_pkg::REG_DIRECTION_TIMING], direction_word)
        | shown(reads[motion_regmap_pkg::REG_IRQ_ENABLE], irq_word)
        | shown(reads[motion_regmap_pkg::REG_TICKS], ticks_q)
        | shown(reads[motion_regmap_pkg::REG_SOURCE], 32'(source))
        | shown(reads[motion_regmap_pkg::REG_PATH_FEED], path_feed)
        | shown(reads[motion_regmap_pkg::REG_PATH_STATUS], path_status);
    // verilog_format: on
    for (int unsigned i = 0; i < Axes; i++) begin
      read_data = read_data | shown(reads[motion_regmap_pkg::REG_POSITION+5'(i)], position[32*i+:32]);
    end
  end

  always_ff @(posedge clk_i) readdata_q <= read_data;

  profile_memory #(
      .Axes(Axes)
  ) u_profiles (
      .clk_i,
      .rst_ni,
      .abort_i     (abort),
      .write_i     (write_i && in_records),
      .address_i   (address_i[$clog2(motion_regmap_pkg::WORDS_RECORDS)-1:0]),
      .data_i      (writedata_i),
      .head_write_i(head_write),
      .head_i      (writedata_i[motion_regmap_pkg::HEAD_AXIS0_LSB+:motion_regmap_pkg::HEAD_AXIS0_WIDTH*Axes]),
      .head_o      (head),
      .tail_o      (tail),
      .waiting_o   (waiting),
      .axis_i      (record_axis),
      .word_i      (record_word),
      .record_o    (record),
      .take_i      (take)
  );

  velocity_control #(
      .Axes     (Axes),
      .EventBits(EventBits)
  ) u_velocity (
      .clk_i,
      .rst_ni,
      .abort_i    (abort),
      .tick_i     (tick),
      .waiting_i  (waiting),
      .axis_o     (record_axis),
      .word_o     (record_word),
      .record_i   (record),
      .take_o     (take),
      .running_o  (moving),
      .underrun_o (underrun),
      .pulse_i    (pulse),
      .rate_o     (rate),
      .direction_o(negative),
      .first_o    (first)
  );

  genvar axis;
  generate
    for (axis = 0; axis < Axes; axis++) begin : gen_axis
      motion_axis #(
          .Modulus (Modulus),
          .TimeBits(TimeBits)
      ) u_axis (
          .clk_i,
          .rst_ni,
          .abort_i    (abort[axis]),
          .rate_i     (rate[32*axis+:32]),
          .negative_i (negative[axis]),
          .first_i    (first[axis]),
          .pulse_o    (pulse[axis]),
          .source_i       (source[axis]),
          .path_step_i    (path_step[axis]),
          .path_negative_i(path_negative[axis]),
          .length_i   (length_q),
          .space_i    (space_q),
          .setup_i    (setup_q),
          .hold_i     (hold_q),
          .idle_o     (idle[axis]),
          .overrun_o  (overrun[axis]),
          .position_o (position[32*axis+:32]),
          .step_o     (step_o[axis]),
          .direction_o(direction_o[axis])
      );
    end

    if (Interpolators != 0) begin : gen_path
      path_control #(
          .Axes(Axes)
      ) u_path (
          .clk_i,
          .rst_ni,
          .word_write_i   (csr_write && register_index[4:3] == motion_regmap_pkg::REG_PATH_WORD[4:3]),
          .word_i         (register_index[2:0]),
          .command_write_i(csr_write && register_index == motion_regmap_pkg::REG_PATH_COMMAND),
          .feed_write_i   (csr_write && register_index == motion_regmap_pkg::REG_PATH_FEED),
          .source_write_i (csr_write && register_index == motion_regmap_pkg::REG_SOURCE),
          .data_i         (writedata_i),
          .clear_i        (csr_write && register_index == motion_regmap_pkg::REG_CONTROL
                         && writedata_i[motion_regmap_pkg::CONTROL_PATH_LSB]),
          .pending_o      (path_pending),
          .busy_o         (path_busy),
          .fault_o        (path_fault),
          .status_o       (path_status),
          .feed_o         (path_feed),
          .source_o       (source),
          .abort_i        (abort),
          .resting_i      (~running),
          .overrun_i      (overrun),
          .pulse_i        (pulse),
          .step_o         (path_step),
          .negative_o     (path_negative)
      );
    end else begin : gen_no_path
      assign source        = '0;
      assign path_step     = '0;
      assign path_negative = '0;
      assign path_pending  = 1'b0;
      assign path_busy     = 1'b0;
      assign path_fault    = 1'b0;
      assign path_status   = '0;
      assign path_feed     = '0;
    end
  endgenerate

  assign running       = moving | pulse | ~idle;  // a move's last pulse may come a clock after it
  assign readdata_o    = readdata_q;
  assign waitrequest_o = read_i && !read_q;
  assign irq_o = (irq_idle_q && (running | waiting) == '0 && !path_busy && !path_pending)
                 || (irq_fault_q && ((underrun | overrun) != '0 || path_fault));

`ifndef SYNTHESIS
  generate
    if (Axes < 1 || Axes > 8 || ClocksPerTick < 8 * Axes + 8 || ClocksPerTick > 255) begin : gen_check_shape
      $error("motion_front_end: Axes=%0d, ClocksPerTick=%0d, must be 1..8 and 8*Axes + 8 .. 255", Axes, ClocksPerTick);
    end
  endgenerate
`endif

endmodule
