// SPDX-License-Identifier: Apache-2.0
// sinc3_filter: a sigma-delta modulator's bits as numbers, at two rates.
// Contract: three integrators run at the bits' rate, arithmetic is modulo 2^width and exact. slow_o is a
// window of bits with the weights of (1 + z + .. + z^(SlowRate-1))^3, SlowRate^3 / 2 less than their sum: from
// -SlowRate^3 / 2, all bits 0, to SlowRate^3 / 2, all bits 1. It is a sample only in the clock in which the
// timing's done_o is high; its last bit is the one of two strobes before the fourth corner. fast_o is the same with
// FastRate, after every FastRate bits, in the clock of fast_valid_o.
module sinc3_filter #(
    parameter int unsigned SlowRate = 64,
    parameter int unsigned FastRate = 8
) (
    input  logic                               clk_i,
    input  logic                               rst_ni,
    input  logic                               bit_i,         // modulator, stable around the strobe
    // from sinc3_timing
    input  logic                               strobe_i,
    input  logic [2:0]                         corner_i,
    input  logic [2:0]                         fast_i,
    output logic signed [3*$clog2(SlowRate):0] slow_o,
    output logic signed [3*$clog2(FastRate):0] fast_o
);

  localparam int unsigned SlowWidth = 3 * $clog2(SlowRate) + 1;
  localparam int unsigned FastWidth = 3 * $clog2(FastRate) + 1;

  logic [SlowWidth-1:0] sum1_q, sum2_q, sum3_q, s0_q, s1_q, s2_q, e1_q, e2_q, e3_q;
  logic [FastWidth-1:0] f0_q, f1_q, f2_q, d1_q, d2_q, d3_q;
  logic bit_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      bit_q  <= 1'b0;
      sum1_q <= '0;
      sum2_q <= '0;
      sum3_q <= '0;
    end else begin
      bit_q <= bit_i;
      if (strobe_i) begin
        sum1_q <= sum1_q + SlowWidth'(bit_q);
        sum2_q <= sum2_q + sum1_q;
        sum3_q <= sum3_q + sum2_q;
      end
    end
  end

  // Three differences, one in each of three clocks: e of the windows' corners, d of the fast values.
  always_ff @(posedge clk_i) begin
    if (corner_i[0]) begin
      e1_q <= sum3_q - s0_q;
      s0_q <= sum3_q;
    end
    if (corner_i[1]) begin
      e2_q <= e1_q - s1_q;
      s1_q <= e1_q;
    end
    if (corner_i[2]) begin
      e3_q <= e2_q - s2_q;
      s2_q <= e2_q;
    end
    if (fast_i[0]) begin
      d1_q <= sum3_q[FastWidth-1:0] - f0_q;
      f0_q <= sum3_q[FastWidth-1:0];
    end
    if (fast_i[1]) begin
      d2_q <= d1_q - f1_q;
      f1_q <= d1_q;
    end
    if (fast_i[2]) begin
      d3_q <= d2_q - f2_q;
      f2_q <= d2_q;
    end
  end

  // Half of the greatest value less: only the upper two bits change.
  assign slow_o = {e3_q[SlowWidth-1-:2] - 2'd1, e3_q[SlowWidth-3:0]};
  assign fast_o = {d3_q[FastWidth-1-:2] - 2'd1, d3_q[FastWidth-3:0]};

endmodule
