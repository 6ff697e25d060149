// SPDX-License-Identifier: Apache-2.0
// n2_timer: interval timer. While run is set an event happens every PERIOD cycles.
// Contract: registers TIMER_* of io_regmap.rdl; a write takes effect at the clock edge, reads are
// combinational. tick_o is high in the cycle of an event if ticks are on, irq_o from the edge after it until software
// clears TIMER_STATUS; an event in the cycle of the clearing stays. PERIOD 0 counts as 2^32.
module n2_timer (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        freeze_i,   // time stops
    // from and to the bus agent
    input  logic        write_i,
    input  logic [1:0]  word_i,
    input  logic [31:0] wdata_i,
    output logic [31:0] rdata_o,
    // to the tick block and the core
    output logic        tick_o,
    output logic        irq_o
);

  localparam logic [1:0] Period = n2_io_regmap_pkg::REG_TIMER_PERIOD[1:0];
  localparam logic [1:0] Control = n2_io_regmap_pkg::REG_TIMER_CONTROL[1:0];
  localparam logic [1:0] Status = n2_io_regmap_pkg::REG_TIMER_STATUS[1:0];

  logic [31:0] period_q, count_q;
  logic run_q, irq_enable_q, tick_q, event_q, last;

  assign last    = run_q && !freeze_i && count_q == period_q - 32'd1;
  assign tick_o  = last && tick_q;
  assign irq_o   = event_q && irq_enable_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      period_q     <= n2_io_regmap_pkg::RESET_TIMER_PERIOD;
      count_q      <= 32'd0;
      run_q        <= 1'b0;
      irq_enable_q <= 1'b0;
      tick_q       <= 1'b0;
      event_q      <= 1'b0;
    end else begin
      if (write_i && word_i == Period) period_q <= wdata_i;
      if (write_i && word_i == Control) begin
        run_q        <= wdata_i[n2_io_regmap_pkg::TIMER_CONTROL_RUN_LSB];
        irq_enable_q <= wdata_i[n2_io_regmap_pkg::TIMER_CONTROL_IRQ_ENABLE_LSB];
        tick_q       <= wdata_i[n2_io_regmap_pkg::TIMER_CONTROL_TICK_LSB];
      end
      if (last) event_q <= 1'b1;
      else if (write_i && word_i == Status) event_q <= 1'b0;
      // a new period starts to count at once
      if (last || (write_i && word_i == Period) || !run_q) count_q <= 32'd0;
      else if (!freeze_i) count_q <= count_q + 32'd1;
    end
  end

  always_comb begin
    rdata_o = 32'd0;
    case (word_i)
      Period: rdata_o = period_q;
      Control: begin
        rdata_o[n2_io_regmap_pkg::TIMER_CONTROL_RUN_LSB]        = run_q;
        rdata_o[n2_io_regmap_pkg::TIMER_CONTROL_IRQ_ENABLE_LSB] = irq_enable_q;
        rdata_o[n2_io_regmap_pkg::TIMER_CONTROL_TICK_LSB]       = tick_q;
      end
      Status: rdata_o[n2_io_regmap_pkg::TIMER_STATUS_EVENT_LSB] = event_q;
      default: rdata_o = count_q;
    endcase
  end

endmodule
