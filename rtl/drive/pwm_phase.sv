// SPDX-License-Identifier: Apache-2.0
// pwm_phase: the two gates of a half bridge.
// Contract: the ordered state is high for exactly `compare` clocks of each half of the carrier (all of them
// where it is not below the half), in the middle of the period; ordered_o shows it a clock later. The gates
// follow two clocks after the carrier. A gate turns on only after both were off for dead_time_i clocks, one at
// least: the dead time of the last clock in which a gate was on. It turns off at once. off_i turns both
// off with the next edge. compare_i is taken over with load_i.
module pwm_phase #(
    parameter int unsigned Width    = 12,
    parameter int unsigned DeadBits = 8
) (
    input  logic                clk_i,
    input  logic                rst_ni,
    // carrier
    input  logic [Width-1:0]    count_i,
    input  logic                up_i,
    input  logic                load_i,
    // registers
    input  logic [Width-1:0]    compare_i,
    input  logic [DeadBits-1:0] dead_time_i,  // clocks
    input  logic                run_i,        // follows the carrier
    input  logic                brake_i,      // low gate on, unless run_i
    input  logic                off_i,
    output logic                ordered_o,
    output logic                high_o,
    output logic                low_o
);

  logic [Width-1:0] compare_q;
  logic [DeadBits-1:0] wait_q;  // clocks that both gates must still be off, this one included
  logic ordered_q, high_q, low_q, high_d, low_d, ready;

  assign ready  = wait_q[DeadBits-1:1] == '0;
  assign high_d = !off_i && run_i && ordered_q && !low_q && (high_q || ready);
  assign low_d  = !off_i && (run_i ? !ordered_q : brake_i) && !high_q && (low_q || ready);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      compare_q <= '0;
      ordered_q <= 1'b0;
      high_q    <= 1'b0;
      low_q     <= 1'b0;
      wait_q    <= '1;
    end else begin
      if (load_i) compare_q <= compare_i;
      ordered_q <= {compare_q, 1'b0} >= {count_i, up_i};  // count < compare up, <= down
      high_q    <= high_d;
      low_q     <= low_d;
      if (high_q || low_q) wait_q <= dead_time_i;
      else if (!ready) wait_q <= wait_q - 1'b1;
    end
  end

  assign ordered_o = ordered_q;
  assign high_o    = high_q;
  assign low_o     = low_q;

endmodule
