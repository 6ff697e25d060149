// SPDX-License-Identifier: Apache-2.0
// n2_div: 32-bit division, two quotient bits per cycle, in stage A.
// Contract: start_i with operands at the end of M; busy_o for 18 cycles from the next one on, then
// quotient_o holds until the next start. Division by 0 gives all ones (negative signed dividend: 1),
// -2^31 / -1 gives -2^31. Only the dividend is made positive: the divisor is added if it is negative.
module n2_div (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        start_i,
    input  logic        signed_i,
    input  logic [31:0] dividend_i,
    input  logic [31:0] divisor_i,
    output logic        busy_o,
    output logic [31:0] quotient_o
);

  // 18: sign of the dividend, 17..2: two quotient bits each, 1: sign of the result.
  localparam logic [4:0] SignStep = 5'd18;

  logic [4:0] step_q;
  logic [31:0] quotient_q, remainder_q, minus_q;
  logic complement_q, negative_q, opposite_q;
  logic [31:0] quotient, remainder, difference;
  logic fits, unused;  // fits: the divisor goes in
  logic iterate, negate, busy_q;

  assign busy_o = busy_q;
  assign iterate = step_q[4:1] != 4'd0 && step_q != SignStep;
  assign negate = (step_q == SignStep && negative_q) || (step_q == 5'd1 && opposite_q);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      step_q <= 5'd0;
      busy_q <= 1'b0;
    end else if (start_i) begin
      step_q <= SignStep;
      busy_q <= 1'b1;
    end else if (busy_q) begin
      step_q <= step_q - 5'd1;
      busy_q <= step_q != 5'd1;
    end
  end

  always_comb begin
    quotient  = quotient_q;
    remainder = remainder_q;
    for (int unsigned i = 0; i < 2; i++) begin
      {fits, unused, difference} = {1'b0, remainder, quotient[31]} + {2'b01, minus_q} +
                                   {33'd0, complement_q};
      remainder = fits ? difference : {remainder[30:0], quotient[31]};
      quotient  = {quotient[30:0], fits};
    end
  end

  always_ff @(posedge clk_i) begin
    if (start_i) begin
      negative_q   <= signed_i && dividend_i[31];
      opposite_q   <= signed_i && dividend_i[31] != divisor_i[31];
      complement_q <= !(signed_i && divisor_i[31]);
      minus_q      <= signed_i && divisor_i[31] ? divisor_i : ~divisor_i;
      remainder_q  <= 32'd0;
      quotient_q   <= dividend_i;
    end else begin
      if (negate) quotient_q <= -quotient_q;
      else if (iterate) quotient_q <= quotient;
      if (iterate) remainder_q <= remainder;
    end
  end

  assign quotient_o = quotient_q;

endmodule
