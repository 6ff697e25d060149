// SPDX-License-Identifier: Apache-2.0
// n2_io: Avalon-MM agent with the timer, the control tick, its inputs and outputs and a console.
// Contract: registers and blocks of io_regmap.rdl, whole words. A write takes one cycle, a read two
// (one with waitrequest). tick_i or the timer starts a tick, the write of TICK_DONE ends it; TICK_CYCLES
// counts the cycles between, first and last included. A tick while one is pending sets overrun until reset.
// The host writes inputs between ticks and reads outputs, one cycle later, when pending_o is low.
module n2_io #(
    parameter int unsigned Platform = 2
) (
    input  logic                                          clk_i,
    input  logic                                          rst_ni,
    input  logic                                          freeze_i,   // timer and counters hold
    // from and to the core
    input  logic [n2_system_pkg::IO_ADDRESS_WIDTH-1:0]    avs_address_i,
    input  logic                                          avs_read_i,
    input  logic                                          avs_write_i,
    input  logic [31:0]                                   avs_writedata_i,
    output logic [31:0]                                   avs_readdata_o,
    output logic                                          avs_waitrequest_o,
    output logic                                          irq_o,
    // host
    input  logic [$clog2(n2_io_regmap_pkg::WORDS_INPUTS)-1:0] host_word_i,
    input  logic                                          host_write_i,
    input  logic [31:0]                                   host_wdata_i,
    output logic [31:0]                                   host_rdata_o,
    input  logic                                          enable_i,
    input  logic                                          tick_i,
    output logic                                          pending_o,
    output logic                                          overrun_o,
    output logic [31:0]                                   tick_cycles_o,
    // console and end of a program
    output logic                                          console_valid_o,
    output logic [7:0]                                    console_data_o,
    output logic                                          exit_valid_o,
    output logic [31:0]                                   exit_status_o
);

  localparam int unsigned Width = n2_system_pkg::IO_ADDRESS_WIDTH;
  localparam int unsigned InputWidth = $clog2(n2_io_regmap_pkg::WORDS_INPUTS);
  localparam int unsigned OutputWidth = $clog2(n2_io_regmap_pkg::WORDS_OUTPUTS);
  localparam int unsigned RegisterWidth = $clog2(n2_io_regmap_pkg::WORDS_CSR);
  localparam int unsigned TimerWidth = 2;  // the timer's four registers come first

  localparam logic [Width-1:0] InputWord = Width'(n2_io_regmap_pkg::BASE_INPUTS);
  localparam logic [Width-1:0] OutputWord = Width'(n2_io_regmap_pkg::BASE_OUTPUTS);
  localparam logic [Width-1:0] RegisterWord = Width'(n2_io_regmap_pkg::BASE_CSR);
  localparam logic [RegisterWidth-1:0] TimerRegister = n2_io_regmap_pkg::REG_TIMER_PERIOD;

  logic [31:0] inputs[0:n2_io_regmap_pkg::WORDS_INPUTS-1];
  logic [31:0] outputs[0:n2_io_regmap_pkg::WORDS_OUTPUTS-1];

  logic register_select, input_select, output_select, timer_select, write, input_q, read_q, done;
  logic timer_tick, tick;
  logic [RegisterWidth-1:0] word;
  logic [31:0] timer_rdata, rdata_d, rdata_q, input_rdata_q;
  logic pending_q, overrun_q;
  logic [31:0] ticks_q, running_q, cycles_q, worst_q, high_q;
  logic [63:0] cycle_q;

  // ------------------------------------------------------------------ bus
  assign register_select = avs_address_i[Width-1:RegisterWidth] == RegisterWord[Width-1:RegisterWidth];
  assign input_select  = avs_address_i[Width-1:InputWidth] == InputWord[Width-1:InputWidth];
  assign output_select = avs_address_i[Width-1:OutputWidth] == OutputWord[Width-1:OutputWidth];
  assign write = avs_write_i && register_select;
  assign word = avs_address_i[RegisterWidth-1:0];
  assign timer_select = register_select &&
      word[RegisterWidth-1:TimerWidth] == TimerRegister[RegisterWidth-1:TimerWidth];
  assign done = write && word == n2_io_regmap_pkg::REG_TICK_DONE;

  assign avs_waitrequest_o = avs_read_i && !read_q;
  assign avs_readdata_o    = input_q ? input_rdata_q : rdata_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) read_q <= 1'b0;
    else read_q <= avs_read_i && !read_q;
  end

  always_ff @(posedge clk_i) begin
    rdata_q <= rdata_d;
    input_q <= input_select;
  end

  always_comb begin
    rdata_d = 32'd0;
    case (word)
      n2_io_regmap_pkg::REG_TICK_STATUS: begin
        rdata_d[n2_io_regmap_pkg::TICK_STATUS_PENDING_LSB] = pending_q;
        rdata_d[n2_io_regmap_pkg::TICK_STATUS_ENABLE_LSB]  = enable_i;
        rdata_d[n2_io_regmap_pkg::TICK_STATUS_OVERRUN_LSB] = overrun_q;
      end
      n2_io_regmap_pkg::REG_TICK_COUNT:  rdata_d = ticks_q;
      n2_io_regmap_pkg::REG_TICK_CYCLES: rdata_d = cycles_q;
      n2_io_regmap_pkg::REG_TICK_WORST:  rdata_d = worst_q;
      n2_io_regmap_pkg::REG_CYCLE:       rdata_d = cycle_q[31:0];
      n2_io_regmap_pkg::REG_CYCLE_HIGH:  rdata_d = high_q;
      n2_io_regmap_pkg::REG_PLATFORM:    rdata_d = Platform;
      default:                        rdata_d = timer_select ? timer_rdata : 32'd0;
    endcase
    if (!register_select) rdata_d = 32'd0;
  end

  // ------------------------------------------------------------------ inputs and outputs of a tick
  always_ff @(posedge clk_i) begin
    if (host_write_i) inputs[host_word_i] <= host_wdata_i;
    input_rdata_q <= inputs[avs_address_i[InputWidth-1:0]];
  end

  always_ff @(posedge clk_i) begin
    if (avs_write_i && output_select) outputs[avs_address_i[OutputWidth-1:0]] <= avs_writedata_i;
    host_rdata_o <= outputs[host_word_i[OutputWidth-1:0]];
  end

  // ------------------------------------------------------------------ tick and cycle counters
  n2_timer u_timer (
      .clk_i  (clk_i),
      .rst_ni (rst_ni),
      .freeze_i(freeze_i),
      .write_i(avs_write_i && timer_select),
      .word_i (avs_address_i[TimerWidth-1:0]),
      .wdata_i(avs_writedata_i),
      .rdata_o(timer_rdata),
      .tick_o (timer_tick),
      .irq_o  (irq_o)
  );

  assign tick = tick_i || timer_tick;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      pending_q <= 1'b0;
      overrun_q <= 1'b0;
      ticks_q   <= 32'd0;
      running_q <= 32'd1;
      cycles_q  <= 32'd0;
      worst_q   <= 32'd0;
      cycle_q   <= 64'd0;
      high_q    <= 32'd0;
    end else begin
      if (!freeze_i) cycle_q <= cycle_q + 64'd1;
      if (avs_read_i && register_select && word == n2_io_regmap_pkg::REG_CYCLE && !read_q) begin
        high_q <= cycle_q[63:32];
      end

      if (tick) begin
        pending_q <= 1'b1;
        ticks_q   <= ticks_q + 32'd1;
        running_q <= 32'd1;
        if (pending_q && !done) overrun_q <= 1'b1;
      end else begin
        if (done) pending_q <= 1'b0;
        if (!freeze_i) running_q <= running_q + 32'd1;
      end

      if (done && pending_q) begin
        cycles_q <= running_q;
        if (running_q > worst_q) worst_q <= running_q;
      end
    end
  end

  assign pending_o     = pending_q;
  assign overrun_o     = overrun_q;
  assign tick_cycles_o = cycles_q;

  // ------------------------------------------------------------------ console and end of a program
  assign console_valid_o = write && word == n2_io_regmap_pkg::REG_CONSOLE;
  assign console_data_o  = avs_writedata_i[7:0];
  assign exit_valid_o    = write && word == n2_io_regmap_pkg::REG_EXIT;
  assign exit_status_o   = avs_writedata_i;


endmodule
