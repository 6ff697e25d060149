// SPDX-License-Identifier: Apache-2.0
// motion_axis: one axis from phase records to step and direction lines.
// Contract: velocity_control's load port and ticks on one side, step_output's drive timing on the other;
// a pulse of the generator becomes a request one clock later, in the direction of its move.
module motion_axis #(
    parameter logic [31:0] Modulus = 32'd1_600_000_000,  // 16 x clock frequency in Hz
    parameter int unsigned TimeBits = 10
) (
    input  logic                clk_i,
    input  logic                rst_ni,
    input  logic                abort_i,
    input  logic                tick_i,
    // profile memory
    input  logic                load_i,
    input  logic [2:0]          load_word_i,
    input  logic [31:0]         load_data_i,
    output logic                request_o,
    // registers
    input  logic [TimeBits-1:0] length_i,
    input  logic [TimeBits-1:0] space_i,
    input  logic [TimeBits-1:0] setup_i,
    input  logic [TimeBits-1:0] hold_i,
    output logic                running_o,
    output logic                underrun_o,
    output logic                overrun_o,
    output logic signed [31:0]  position_o,
    // drive
    output logic                step_o,
    output logic                direction_o
);

  logic [31:0] rate, unused_count;
  logic pulse, negative, first, moving, idle;

  velocity_control u_velocity (
      .clk_i,
      .rst_ni,
      .abort_i,
      .tick_i,
      .load_i,
      .load_word_i,
      .load_data_i,
      .request_o,
      .running_o  (moving),
      .underrun_o,
      .pulse_i    (pulse),
      .rate_o     (rate),
      .direction_o(negative),
      .first_o    (first)
  );

  pulse_generator #(
      .Modulus(Modulus)
  ) u_pulses (
      .clk_i,
      .rst_ni,
      .clear_i(first),
      .rate_i (rate),
      .pulse_o(pulse),
      .count_o(unused_count)
  );

  step_output #(
      .TimeBits(TimeBits)
  ) u_step (
      .clk_i,
      .rst_ni,
      .clear_i   (abort_i),
      .length_i,
      .space_i,
      .setup_i,
      .hold_i,
      .request_i (pulse && !abort_i),
      .negative_i(negative),
      .step_o,
      .direction_o,
      .position_o,
      .idle_o    (idle),
      .overrun_o
  );

  assign running_o = moving || !idle;

endmodule
