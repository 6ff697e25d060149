// SPDX-License-Identifier: Apache-2.0
// drive_plausible: the current of a phase must follow a large voltage that is ordered for the phase.
// Contract: compare values of an axis come in the order of its phases, marked by write_i; with the third
// come the last samples of the axis' currents a and b; the third current is -(a + b). The voltage of phase k
// against the star point is 2 c_k - c_l - c_m, in thirds of clocks of a half period. A set of values is odd
// if a phase has a voltage of size voltage_i or more and a current smaller than current_i. lost_o[n] is set
// six clocks after the last value of persist_i odd sets of axis n without another between them, and stays
// until clear_i[n]. Sets of an axis that does not run, or with voltage_i 0, are not odd; persist_i 0: never.
module drive_plausible #(
    parameter int unsigned Axes     = 5,   // 1..8
    parameter int unsigned Width    = 12,
    parameter int unsigned SlowRate = 64
) (
    input  logic                               clk_i,
    input  logic                               rst_ni,
    // values
    input  logic                               write_i,
    input  logic [2:0]                         axis_i,
    input  logic [1:0]                         phase_i,
    input  logic [Width-1:0]                   value_i,
    input  logic signed [3*$clog2(SlowRate):0] current_a_i,
    input  logic signed [3*$clog2(SlowRate):0] current_b_i,
    // registers
    input  logic [Axes-1:0]                    run_i,
    input  logic [Axes-1:0]                    clear_i,
    input  logic [(Width+2)*Axes-1:0]          voltage_i,
    input  logic [15:0]                        current_i,
    input  logic [7:0]                         persist_i,
    output logic [Axes-1:0]                    lost_o
);

  localparam int unsigned Current = 3 * $clog2(SlowRate) + 2;

  logic [Width-1:0] first_q, second_q;
  logic [Width-1:0] value0_q, value1_q, value2_q;  // of a set; the phase in place 0 is looked at
  logic signed [Current-1:0] current0_q, current1_q, current2_q;
  logic [Width+1:0] sum_q, least;
  logic signed [Width+2:0] volts, volts_q;
  logic signed [Current-1:0] amps_q;
  logic [Width+2:0] volts_size;
  logic [Current-1:0] amps_size;
  logic [2:0] axis_q, looked_axis_q, odd_axis_q;
  logic [2:0] step_q;  // bit k: phase k is in place 0
  logic looked_first_q, looked_last_q, ends_q, odd_q, odd, complete;
  logic [7:0] count_q[0:Axes-1];

  assign complete = write_i && phase_i == 2'd2;
  assign volts    = $signed({2'd0, value0_q, 1'b0}) + $signed({3'd0, value0_q}) - $signed({1'b0, sum_q});

  always_comb begin
    least = '0;
    for (int unsigned i = 0; i < Axes; i++) if (looked_axis_q == 3'(i)) least = voltage_i[(Width+2)*i+:Width+2];
  end

  assign volts_size = volts_q[Width+2] ? -volts_q : volts_q;
  assign amps_size  = amps_q[Current-1] ? -amps_q : amps_q;
  assign odd        = volts_size >= {1'b0, least} && least != '0 && amps_size < Current'(current_i);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      step_q   <= '0;
      looked_first_q <= 1'b0;
      looked_last_q <= 1'b0;
      ends_q   <= 1'b0;
    end else begin
      step_q   <= {step_q[1:0], complete};
      looked_first_q <= step_q[0];
      looked_last_q <= step_q[2];
      ends_q   <= looked_last_q;
    end
  end

  always_ff @(posedge clk_i) begin
    if (write_i && phase_i == 2'd0) first_q <= value_i;
    if (write_i && phase_i == 2'd1) second_q <= value_i;
    if (complete) begin
      value0_q   <= first_q;
      value1_q   <= second_q;
      value2_q   <= value_i;
      sum_q        <= {2'd0, first_q} + {2'd0, second_q} + {2'd0, value_i};
      current0_q <= Current'(current_a_i);
      current1_q <= Current'(current_b_i);
      current2_q <= -(Current'(current_a_i) + Current'(current_b_i));
      axis_q       <= axis_i;
    end else begin
      value0_q   <= value1_q;
      value1_q   <= value2_q;
      current0_q <= current1_q;
      current1_q <= current2_q;
    end
    volts_q       <= volts;
    amps_q        <= current0_q;
    looked_axis_q <= axis_q;
    odd_axis_q    <= looked_axis_q;
    odd_q         <= odd || (odd_q && !looked_first_q);
  end

  genvar n;
  generate
    for (n = 0; n < Axes; n++) begin : gen_axis
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) begin
          count_q[n] <= '0;
          lost_o[n]  <= 1'b0;
        end else if (clear_i[n] || !run_i[n]) begin
          count_q[n] <= '0;
          if (clear_i[n]) lost_o[n] <= 1'b0;
        end else if (ends_q && odd_axis_q == 3'(n)) begin
          if (!odd_q) count_q[n] <= '0;
          else if (count_q[n] != '1) count_q[n] <= count_q[n] + 8'd1;
          if (odd_q && persist_i != '0 && {1'b0, count_q[n]} + 9'd1 >= {1'b0, persist_i}) lost_o[n] <= 1'b1;
        end
      end
    end
  endgenerate

endmodule
