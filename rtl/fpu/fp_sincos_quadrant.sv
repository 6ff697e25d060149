// SPDX-License-Identifier: Apache-2.0
// fp_sincos_quadrant: quadrant and segment of an angle in quarter turns. Combinational.
// Contract: turns_i has the weights 2^1 .. 2^-22; the angle is q + f, q rounded to nearest. f is negative
// in the upper half of a quadrant; |f| is then taken as the complement of its bits, one unit of its last
// place less than the negation.
module fp_sincos_quadrant (
    input  logic [23:0] turns_i,
    input  logic        cos_i,
    input  logic        negative_i,    // sign of the operand
    output logic        sine_o,        // the result is +-sin(pi/2 |f|), else +-cos(pi/2 f)
    output logic        sign_o,        // of the result
    output logic [4:0]  segment_o,     // |f| in 64ths
    output logic [1:0]  leading_o      // byte that holds the leading one of |f|, see fp_sincos
);

  logic [1:0] quadrant;  // of a sine: a cosine is a sine a quarter later
  logic [20:0] high;  // of |f|, weights 2^-2 .. 2^-22

  assign quadrant  = turns_i[23:22] + {1'b0, turns_i[21]} + {1'b0, cos_i};
  assign high      = turns_i[20:0] ^ {21{turns_i[21]}};
  assign sine_o    = !quadrant[0];
  assign sign_o    = quadrant[1] ^ (!quadrant[0] && turns_i[21]) ^ (negative_i && !cos_i);
  assign segment_o = high[20:16];

  always_comb begin
    if (|high[20:16]) leading_o = 2'd0;
    else if (|high[15:8]) leading_o = 2'd1;
    else if (|high[7:0]) leading_o = 2'd2;
    else leading_o = 2'd3;
  end

endmodule
