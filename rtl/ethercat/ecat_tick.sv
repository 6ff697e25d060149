// SPDX-License-Identifier: Apache-2.0
// ecat_tick: the control tick of the application, each Period clocks, steered by SYNC0.
// Contract: while run_i is low there is none; the first comes Period clocks after that. At a beginning of sync_i the distance
// to the nearest tick is taken, and each period that follows is longer or shorter by at most Slew clocks until
// that distance is gone. So a tick begins with each SYNC0 whose cycle is a multiple of Period, and differences of up to
// Slew / Period between the speeds are followed; what remains is what the clocks drift from SYNC0 to SYNC0, and a clock. From
// any phase it takes Period / (2 * Slew) ticks. Without SYNC0 the period is Period. tick_o lasts one clock.
module ecat_tick #(
    parameter int unsigned Period = 10000,
    parameter int unsigned Slew   = 8
) (
    input  logic clk_i,
    input  logic rst_ni,
    input  logic run_i,
    input  logic sync_i,
    output logic tick_o
);

  localparam int unsigned Width = $clog2(Period + Slew) + 1;
  localparam logic signed [Width-1:0] Most = Width'(Slew);
  localparam logic signed [Width-1:0] Whole = Width'(Period);
  localparam logic signed [Width-1:0] Half = Width'(Period / 2);

  logic sync_q;
  logic signed [Width-1:0] count_q, early_q, step, early;

  assign step   = early_q > Most ? Most : early_q < -Most ? -Most : early_q;
  assign early  = count_q > Half ? count_q - Whole : count_q;  // how long before SYNC0 the tick was
  assign tick_o = run_i && count_q >= Whole - Width'(1) + step;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sync_q  <= 1'b0;
      count_q <= '0;
      early_q <= '0;
    end else begin
      sync_q  <= sync_i;
      count_q <= !run_i || tick_o ? '0 : count_q + Width'(1);
      if (!run_i) early_q <= '0;
      else if (sync_i && !sync_q) early_q <= tick_o ? -(Width'(1)) : early;
      else if (tick_o) early_q <= early_q - step;
    end
  end

endmodule
