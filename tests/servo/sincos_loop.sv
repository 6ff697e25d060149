// SPDX-License-Identifier: Apache-2.0
// sincos_loop: the bits of two modulators on sine and cosine lines as a count, as docs/drive.md connects them.
module sincos_loop #(
    parameter int unsigned Width    = 16,
    parameter int unsigned Bits     = 10,
    parameter int unsigned SlowRate = 32,
    parameter int unsigned Period   = 660,
    parameter int unsigned Instant  = 268,
    parameter int unsigned MostJump = 448,
    parameter int unsigned Least    = 4096,
    parameter int unsigned Most     = 12288,
    parameter int unsigned After    = 4
) (
    input  logic               clk_i,
    input  logic               rst_ni,
    output logic               strobe_o,
    input  logic               bit_sine_i,
    input  logic               bit_cosine_i,
    input  logic               clear_i,
    output logic signed [31:0] position_o,
    output logic               jump_o,
    output logic               lost_o,
    output logic [7:0]         bad_count_o,
    output logic               done_o
);

  logic [2:0] corner, fast;
  logic request, window, busy, good, valid, mclk, fast_valid, unused;
  logic [Bits-1:0] word;
  logic signed [Width-1:0] sine, cosine;
  logic signed [9:0] fast_sine, fast_cosine;

  sinc3_timing #(
      .SlowRate(SlowRate)
  ) u_timing (
      .clk_i,
      .rst_ni,
      .window_i    (window),
      .mclk_o      (mclk),
      .strobe_o,
      .corner_o    (corner),
      .done_o      (valid),
      .fast_o      (fast),
      .fast_valid_o(fast_valid)
  );

  sinc3_filter #(
      .SlowRate(SlowRate)
  ) u_sine (
      .clk_i,
      .rst_ni,
      .bit_i   (bit_sine_i),
      .strobe_i(strobe_o),
      .corner_i(corner),
      .fast_i  (fast),
      .slow_o  (sine),
      .fast_o  (fast_sine)
  );

  sinc3_filter #(
      .SlowRate(SlowRate)
  ) u_cosine (
      .clk_i,
      .rst_ni,
      .bit_i   (bit_cosine_i),
      .strobe_i(strobe_o),
      .corner_i(corner),
      .fast_i  (fast),
      .slow_o  (cosine),
      .fast_o  (fast_cosine)
  );

  sincos_position #(
      .Width(Width),
      .Bits (Bits),
      .Least(Least),
      .Most (Most),
      .After(After)
  ) u_port (
      .clk_i,
      .rst_ni,
      .window_o  (window),
      .valid_i   (valid),
      .sine_i    (sine),
      .cosine_i  (cosine),
      .sample_i  (request),
      .busy_o    (busy),
      .done_o,
      .good_o    (good),
      .position_o(word)
  );

  absolute_position #(
      .Width   (Bits),
      .Period  (Period),
      .Instant (Instant),
      .MostJump(MostJump)
  ) u_position (
      .clk_i,
      .rst_ni,
      .request_o  (request),
      .busy_i     (busy),
      .done_i     (done_o),
      .good_i     (good),
      .position_i (word),
      .clear_i,
      .position_o,
      .jump_o,
      .lost_o,
      .bad_count_o
  );

  assign unused = ^{mclk, fast_valid, fast_sine, fast_cosine};

endmodule
