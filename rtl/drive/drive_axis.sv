// SPDX-License-Identifier: Apache-2.0
// drive_axis: what one motor needs: decoder, filters of two phase currents, three half bridges.
// Contract: that of quadrature_decoder, current_sense, pwm_bridge and, with ThirdSensor, current_sum. With External
// the count is external_position_i, one clock later, and external_fault_i, held until a clear, is an illegal
// transition; there is no index then. edge_time_o is the time of the last change of the count.
// Overcurrent and a sum of the currents that is not 0 are alarms of the bridge.
module drive_axis #(
    parameter int unsigned Width         = 12,
    parameter int unsigned DeadBits      = 8,
    parameter int unsigned LeastDeadTime = 12,
    parameter int unsigned SlowRate      = 64,
    parameter int unsigned FastRate      = 8,
    parameter int unsigned FilterBits    = 4,
    parameter int unsigned ThirdSensor   = 0,   // 1: bit_c_i, for the sum of the currents
    parameter int unsigned External      = 0    // 1: the count of another encoder, without a_i, b_i and z_i
) (
    input  logic                               clk_i,
    input  logic                               rst_ni,
    // encoder
    input  logic                               a_i,
    input  logic                               b_i,
    input  logic                               z_i,
    input  logic [FilterBits-1:0]              filter_i,
    input  logic [31:0]                        time_i,
    output logic signed [31:0]                 position_o,
    output logic [31:0]                        edge_time_o,
    output logic                               index_o,
    output logic signed [31:0]                 index_position_o,
    output logic                               passes_o,
    output logic                               illegal_o,
    output logic [7:0]                         illegal_count_o,
    input  logic signed [31:0]                 external_position_i,
    input  logic                               external_fault_i,
    input  logic [7:0]                         external_count_i,
    // currents, and sinc3_timing
    input  logic                               bit_a_i,
    input  logic                               bit_b_i,
    input  logic                               bit_c_i,
    input  logic                               strobe_i,
    input  logic [2:0]                               corner_i,
    input  logic [2:0]                               fast_i,
    input  logic                               fast_valid_i,
    input  logic [3*$clog2(FastRate):0]        limit_i,
    output logic signed [3*$clog2(SlowRate):0] current_a_o,
    output logic signed [3*$clog2(SlowRate):0] current_b_o,
    output logic                               over_o,
    input  logic                               done_i,
    input  logic [3*$clog2(SlowRate)+1:0]      sum_limit_i,
    output logic                               sum_over_o,
    // pwm_carrier
    input  logic [Width-1:0]                   count_i,
    input  logic                               up_i,
    input  logic                               load_i,
    // bridge
    input  logic [1:0]                         mode_i,
    input  logic [DeadBits-1:0]                dead_time_i,
    input  logic                               write_i,
    input  logic [1:0]                         phase_i,
    input  logic [Width-1:0]                   value_i,
    input  logic                               commit_i,
    input  logic                               fault_i,
    input  logic                               alarm_i,
    input  logic                               clear_i,
    output logic                               trip_o,
    output logic [2:0]                         high_o,
    output logic [2:0]                         low_o
);

  logic [2:0] ordered, unused_ordered;

  generate
    if (External != 0) begin : gen_external
      logic unused_lines;
      assign unused_lines     = ^{a_i, b_i, z_i, filter_i};
      assign illegal_o        = external_fault_i;
      assign illegal_count_o  = external_count_i;
      assign index_o          = 1'b0;
      assign index_position_o = '0;
      assign passes_o         = 1'b0;

      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) position_o <= '0;
        else position_o <= external_position_i;
      end

      always_ff @(posedge clk_i) begin
        if (position_o != external_position_i) edge_time_o <= time_i;
      end
    end else begin : gen_decoder
      logic unused_external;
      assign unused_external = ^{external_position_i, external_fault_i, external_count_i};

      quadrature_decoder #(
          .FilterBits(FilterBits)
      ) u_decoder (
          .clk_i,
          .rst_ni,
          .a_i,
          .b_i,
          .z_i,
          .filter_i,
          .clear_i,
          .time_i,
          .position_o,
          .edge_time_o,
          .index_o,
          .index_position_o,
          .passes_o,
          .illegal_o,
          .illegal_count_o
      );
    end
  endgenerate

  current_sense #(
      .SlowRate(SlowRate),
      .FastRate(FastRate)
  ) u_currents (
      .clk_i,
      .rst_ni,
      .bit_a_i,
      .bit_b_i,
      .strobe_i,
      .corner_i,
      .fast_i,
      .fast_valid_i,
      .limit_i,
      .slow_a_o(current_a_o),
      .slow_b_o(current_b_o),
      .over_o
  );

  generate
    if (ThirdSensor != 0) begin : gen_sum
      current_sum #(
          .SlowRate(SlowRate)
      ) u_sum (
          .clk_i,
          .rst_ni,
          .bit_a_i,
          .bit_b_i,
          .bit_c_i,
          .strobe_i,
          .corner_i,
          .done_i,
          .limit_i(sum_limit_i),
          .clear_i,
          .over_o (sum_over_o)
      );
    end else begin : gen_no_sum
      logic unused_sum;
      assign unused_sum = ^{bit_c_i, done_i, sum_limit_i};
      assign sum_over_o = 1'b0;
    end
  endgenerate

  pwm_bridge #(
      .Width        (Width),
      .DeadBits     (DeadBits),
      .LeastDeadTime(LeastDeadTime)
  ) u_bridge (
      .clk_i,
      .rst_ni,
      .count_i,
      .up_i,
      .load_i,
      .mode_i,
      .dead_time_i,
      .write_i,
      .phase_i,
      .value_i,
      .commit_i,
      .fault_i,
      .alarm_i  (alarm_i || over_o || sum_over_o),
      .clear_i,
      .trip_o,
      .high_o,
      .low_o,
      .ordered_o(ordered)
  );

  assign unused_ordered = ordered;

endmodule
