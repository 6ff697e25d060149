// SPDX-License-Identifier: Apache-2.0
// current_sum: the sum of a motor's three phase currents, whose sensors are modulators, must be small.
// Contract: with each sample of sinc3_filter the sum of the three samples is known, exactly. over_o is set two
// clocks after a done_i with a sum of size limit_i or more, and stays until clear_i; limit_i counts as the
// samples do (full scale of one sensor SlowRate^3 / 2), 0 switches it off. One filter takes the sum of the bits.
module current_sum #(
    parameter int unsigned SlowRate = 64
) (
    input  logic                        clk_i,
    input  logic                        rst_ni,
    input  logic                        bit_a_i,
    input  logic                        bit_b_i,
    input  logic                        bit_c_i,
    // from sinc3_timing
    input  logic                        strobe_i,
    input  logic [2:0]                  corner_i,
    input  logic                        done_i,
    // registers
    input  logic [3*$clog2(SlowRate)+1:0] limit_i,
    input  logic                        clear_i,
    output logic                        over_o
);

  localparam int unsigned Width = 3 * $clog2(SlowRate) + 2;

  logic [Width-1:0] sum1_q, sum2_q, sum3_q, s0_q, s1_q, s2_q, e1_q, e2_q, e3_q, size_q, sum;
  logic [1:0] ones_q;
  logic done_q;

  // Three halves of a sensor's greatest value less: only the upper three bits change.
  assign sum = {e3_q[Width-1-:3] - 3'd3, e3_q[Width-4:0]};

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      ones_q <= '0;
      sum1_q <= '0;
      sum2_q <= '0;
      sum3_q <= '0;
      done_q <= 1'b0;
      over_o <= 1'b0;
    end else begin
      ones_q <= {1'b0, bit_a_i} + {1'b0, bit_b_i} + {1'b0, bit_c_i};
      if (strobe_i) begin
        sum1_q <= sum1_q + Width'(ones_q);
        sum2_q <= sum2_q + sum1_q;
        sum3_q <= sum3_q + sum2_q;
      end
      done_q <= done_i;
      over_o <= !clear_i && (over_o || (done_q && size_q >= limit_i && limit_i != '0));
    end
  end

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
    if (done_i) size_q <= sum[Width-1] ? -sum : sum;
  end

endmodule
