// SPDX-License-Identifier: Apache-2.0
// fp_i2f: 32-bit integer to binary32, signed or (unsigned_i) unsigned, one per clock.
// Contract: latency fp_pkg::FP_I2F_LATENCY register ranks, no stall. Rounds to nearest even; only
// nx can be set (above 2^24). Zero gives +0.
// Stages: e1 magnitude and leading zeros | e2 normalise, round, pack.
module fp_i2f (
    input  logic           clk_i,
    input  logic           rst_ni,
    input  logic           valid_i,
    input  logic           unsigned_i,
    input  logic [31:0]    a_i,
    output logic           valid_o,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  // ---- e1: magnitude U(32.0) and its leading zeros ----
  logic        sign_e1, zero_e1;
  logic [31:0] magnitude_e1;
  logic [4:0]  zeros_e1;

  assign sign_e1      = a_i[31] && !unsigned_i;
  assign magnitude_e1 = (a_i ^ {32{sign_e1}}) + {31'd0, sign_e1};

  fp_lzc #(.CountWidth(5)) lzc (
      .value_i(magnitude_e1),
      .count_o(zeros_e1),
      .zero_o (zero_e1)
  );

  logic        valid_e1_q, sign_e1_q, zero_e1_q;
  logic [31:0] magnitude_e1_q;
  logic [4:0]  zeros_e1_q;

  always_ff @(posedge clk_i) begin
    sign_e1_q      <= sign_e1;
    zero_e1_q      <= zero_e1;
    magnitude_e1_q <= magnitude_e1;
    zeros_e1_q     <= zeros_e1;
  end

  // ---- e2: |24 significand|guard|round|6 sticky| of the normalised magnitude, U(1.31) ----
  logic [31:0]    normal_e2, rounded_e2;
  fp_pkg::flags_t flags_e2;

  assign normal_e2 = magnitude_e1_q << zeros_e1_q;

  fp_round round (
      .sign_i  (sign_e1_q),
      .exp_i   (9'd158 - {4'd0, zeros_e1_q}),   // 127 + 31 - leading zeros
      .sig_i   (normal_e2[31:8]),
      .guard_i (normal_e2[7]),
      .round_i (normal_e2[6]),
      .sticky_i(|normal_e2[5:0]),
      .result_o(rounded_e2),
      .flags_o (flags_e2)
  );

  always_ff @(posedge clk_i) begin
    result_o <= zero_e1_q ? 32'd0 : rounded_e2;
    flags_o  <= zero_e1_q ? 5'd0 : flags_e2;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_e1_q <= 1'b0;
      valid_o    <= 1'b0;
    end else begin
      valid_e1_q <= valid_i;
      valid_o    <= valid_e1_q;
    end
  end

endmodule
