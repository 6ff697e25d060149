// SPDX-License-Identifier: Apache-2.0
// current_sense: two phase currents of a motor from sigma-delta modulators, and its overcurrent comparator.
// Contract: slow_a_o, slow_b_o as sinc3_filter has them. over_o is high while the last fast value of a, of
// b or of -(a + b), the third phase, has a size of limit_i or more; limit_i counts in fast units (full scale
// FastRate^3 / 2), 0 switches it off. With FastRate 8 and a modulator at 20 MHz a step of the current is
// seen in full after 4 * FastRate bits and 8 clocks, 1.7 us.
module current_sense #(
    parameter int unsigned SlowRate = 64,
    parameter int unsigned FastRate = 8
) (
    input  logic                               clk_i,
    input  logic                               rst_ni,
    input  logic                               bit_a_i,
    input  logic                               bit_b_i,
    // from sinc3_timing
    input  logic                               strobe_i,
    input  logic [2:0]                               corner_i,
    input  logic [2:0]                               fast_i,
    input  logic                               fast_valid_i,
    input  logic [3*$clog2(FastRate):0]        limit_i,
    output logic signed [3*$clog2(SlowRate):0] slow_a_o,
    output logic signed [3*$clog2(SlowRate):0] slow_b_o,
    output logic                               over_o
);

  localparam int unsigned FastWidth = 3 * $clog2(FastRate) + 1;

  localparam logic [1:0] StepA = 2'd1;
  localparam logic [1:0] StepB = 2'd2;
  localparam logic [1:0] StepSum = 2'd3;

  logic signed [FastWidth-1:0] fast_a, fast_b;
  logic signed [FastWidth:0] value;
  logic [FastWidth:0] size_q;
  logic [1:0] step_q, judged_q;  // the phases, one a clock
  logic [2:0] over_q;
  logic over;

  sinc3_filter #(
      .SlowRate(SlowRate),
      .FastRate(FastRate)
  ) u_a (
      .clk_i,
      .rst_ni,
      .bit_i (bit_a_i),
      .strobe_i,
      .corner_i,
      .fast_i,
      .slow_o(slow_a_o),
      .fast_o(fast_a)
  );

  sinc3_filter #(
      .SlowRate(SlowRate),
      .FastRate(FastRate)
  ) u_b (
      .clk_i,
      .rst_ni,
      .bit_i (bit_b_i),
      .strobe_i,
      .corner_i,
      .fast_i,
      .slow_o(slow_b_o),
      .fast_o(fast_b)
  );

  always_comb begin
    case (step_q)
      StepA: value = (FastWidth + 1)'(fast_a);
      StepB: value = (FastWidth + 1)'(fast_b);
      default: value = (FastWidth + 1)'(fast_a) + (FastWidth + 1)'(fast_b);
    endcase
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      step_q   <= '0;
      judged_q <= '0;
      size_q   <= '0;
      over_q   <= '0;
    end else begin
      if (fast_valid_i) step_q <= StepA;
      else if (step_q != '0) step_q <= step_q + 2'd1;  // after StepSum 0
      judged_q <= step_q;
      size_q   <= value[FastWidth] ? -value : value;
      if (judged_q == StepA) over_q[0] <= over;
      if (judged_q == StepB) over_q[1] <= over;
      if (judged_q == StepSum) over_q[2] <= over;
    end
  end

  assign over   = size_q >= {1'b0, limit_i} && limit_i != '0;
  assign over_o = over_q != '0 && limit_i != '0;

endmodule
