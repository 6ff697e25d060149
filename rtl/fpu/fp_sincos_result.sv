// SPDX-License-Identifier: Apache-2.0
// fp_sincos_result: last two steps of a sine or cosine: normalise; round or take the special result.
// Contract: two register ranks, the other inputs two clocks long. magnitude_i U(8.26) is in (0.7, 202), the
// sine times 2^(5 + 8 leading_i) or the cosine times 2^6. The result of an approximation is inexact.
module fp_sincos_result (
    input  logic           clk_i,
    input  logic [33:0]    magnitude_i,
    input  logic           sine_i,
    input  logic [1:0]     leading_i,
    input  logic           sign_i,
    input  logic           special_i,
    input  logic [31:0]    special_result_i,
    input  fp_pkg::flags_t special_flags_i,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  logic [3:0] zeros;  // of magnitude_i, 0 .. 8
  logic [25:0] sig_q;  // U(1.25)
  logic [7:0] exp_q;  // biased

  always_comb begin
    casez (magnitude_i[33:26])
      8'b1???????: zeros = 4'd0;
      8'b01??????: zeros = 4'd1;
      8'b001?????: zeros = 4'd2;
      8'b0001????: zeros = 4'd3;
      8'b00001???: zeros = 4'd4;
      8'b000001??: zeros = 4'd5;
      8'b0000001?: zeros = 4'd6;
      8'b00000001: zeros = 4'd7;
      default:     zeros = 4'd8;
    endcase
  end

  always_ff @(posedge clk_i) begin
    sig_q <= 26'((magnitude_i << zeros) >> 8);
    exp_q <= 8'd128 + {7'd0, sine_i} - (sine_i ? {3'd0, leading_i, 3'd0} : 8'd0) - {4'd0, zeros};
  end

  logic [31:0] rounded;
  fp_pkg::flags_t rounded_flags;

  fp_round u_round (
      .sign_i,
      .exp_i   ({1'b0, exp_q}),
      .sig_i   (sig_q[25:2]),
      .guard_i (sig_q[1]),
      .round_i (sig_q[0]),
      .sticky_i(1'b1),                           // transcendental: never exact
      .result_o(rounded),
      .flags_o (rounded_flags)
  );

  always_ff @(posedge clk_i) begin
    result_o <= special_i ? special_result_i : rounded;
    flags_o  <= special_i ? special_flags_i : rounded_flags;
  end

endmodule
