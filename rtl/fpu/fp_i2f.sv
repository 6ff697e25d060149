// SPDX-License-Identifier: Apache-2.0
// fp_i2f: 32-bit integer to binary32, signed or (unsigned_i) unsigned, one per clock.
// Contract: latency fp_pkg::FP_I2F_LATENCY register ranks, no stall. Rounds to nearest even; only
// nx can be set (above 2^24). Zero gives +0.
// Stages: e1 magnitude | e2 normalise | e3 round, pack.
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

  // ---- e1: magnitude U(32.0) ----
  logic sign_e1;

  assign sign_e1 = a_i[31] && !unsigned_i;

  logic valid_e1_q, sign_e1_q;
  logic [31:0] magnitude_e1_q;

  always_ff @(posedge clk_i) begin
    sign_e1_q      <= sign_e1;
    magnitude_e1_q <= (a_i ^ {32{sign_e1}}) + {31'd0, sign_e1};
  end

  // ---- e2: |24 significand|guard|round|6 sticky| of the normalised magnitude, U(1.31) ----
  logic [4:0] zeros_e2;
  logic zero_e2;
  logic [31:0] normal_e2;

  fp_lzc #(
      .CountWidth(5)
  ) u_lzc (
      .value_i(magnitude_e1_q),
      .count_o(zeros_e2),
      .zero_o (zero_e2)
  );

  // Widest shift first: the upper bits of the count are known first.
  always_comb begin
    normal_e2 = magnitude_e1_q;
    for (int k = 4; k >= 0; k--) if (zeros_e2[k]) normal_e2 = normal_e2 << (1 << k);
  end

  logic valid_e2_q, sign_e2_q, zero_e2_q;
  logic [31:0] normal_e2_q;
  logic [4:0] zeros_e2_q;

  always_ff @(posedge clk_i) begin
    sign_e2_q   <= sign_e1_q;
    zero_e2_q   <= zero_e2;
    normal_e2_q <= normal_e2;
    zeros_e2_q  <= zeros_e2;
  end

  // ---- e3 ----
  logic [31:0] result_e3;
  fp_pkg::flags_t flags_e3;

  fp_pack u_pack (
      .sign_i   (sign_e2_q),
      .exp_i    (9'd158 - {4'd0, zeros_e2_q}),  // 127 + 31 - leading zeros
      .sig_i    (normal_e2_q[31:8]),
      .guard_i  (normal_e2_q[7]),
      .round_i  (normal_e2_q[6]),
      .sticky_i (|normal_e2_q[5:0]),
      .exact_i  (1'b0),
      .nan_i    (1'b0),
      .invalid_i(1'b0),
      .inf_i    (1'b0),
      .by_zero_i(1'b0),
      .zero_i   (zero_e2_q),                    // its sign is plus
      .result_o (result_e3),
      .flags_o  (flags_e3)
  );

  always_ff @(posedge clk_i) begin
    result_o <= result_e3;
    flags_o  <= flags_e3;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_e1_q <= 1'b0;
      valid_e2_q <= 1'b0;
      valid_o    <= 1'b0;
    end else begin
      valid_e1_q <= valid_i;
      valid_e2_q <= valid_e1_q;
      valid_o    <= valid_e2_q;
    end
  end

endmodule
