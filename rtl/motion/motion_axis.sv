// SPDX-License-Identifier: Apache-2.0
// motion_axis: one axis from a rate to step and direction lines.
// Contract: velocity_control's rate, direction and first on one side, step_output's drive timing on the
// other; a pulse of the generator becomes a request in the direction of the rate that made it, also where
// the next move begins in that clock. After abort_i there is none. With source_i the pulses go nowhere and
// requests come from path_control.
module motion_axis #(
    parameter logic [31:0] Modulus = 32'd1_600_000_000,  // 16 x clock frequency in Hz
    parameter int unsigned TimeBits = 10
) (
    input  logic                clk_i,
    input  logic                rst_ni,
    input  logic                abort_i,
    // velocity_control
    input  logic [31:0]         rate_i,
    input  logic                negative_i,
    input  logic                first_i,
    output logic                pulse_o,
    // path_control
    input  logic                source_i,
    input  logic                path_step_i,
    input  logic                path_negative_i,
    // registers
    input  logic [TimeBits-1:0] length_i,
    input  logic [TimeBits-1:0] space_i,
    input  logic [TimeBits-1:0] setup_i,
    input  logic [TimeBits-1:0] hold_i,
    output logic                idle_o,
    output logic                overrun_o,
    output logic signed [31:0]  position_o,
    // drive
    output logic                step_o,
    output logic                direction_o
);

  logic [31:0] unused_count;
  logic generated, pulse, aborted_q, negative_q;

  pulse_generator #(
      .Modulus(Modulus)
  ) u_pulses (
      .clk_i,
      .rst_ni,
      .clear_i(first_i),
      .rate_i,
      .pulse_o(generated),
      .count_o(unused_count)
  );

  // A pulse is that of the clock before.
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) aborted_q <= 1'b0;
    else aborted_q <= abort_i;

  always_ff @(posedge clk_i) negative_q <= negative_i;

  assign pulse = generated && !aborted_q;

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
      .request_i ((source_i ? path_step_i : pulse) && !abort_i),
      .negative_i(source_i ? path_negative_i : negative_q),
      .step_o,
      .direction_o,
      .position_o,
      .idle_o,
      .overrun_o
  );

  assign pulse_o = pulse;

endmodule
