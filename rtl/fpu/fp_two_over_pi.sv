// SPDX-License-Identifier: Apache-2.0
// fp_two_over_pi: a byte of 2/pi, the factor of an angle for a serial multiplier. Combinational.
// Contract: for an angle a up to 256, the significand times 2^(exponent - 127 - 23), a 2/pi modulo 4 needs
// the 72 bits of 2/pi from offset_o on, whose top bit has the weight 2^8. Byte n of them, from the lowest
// one, is at window_i = offset_o + 8 n.
module fp_two_over_pi (
    input  logic [7:0] exponent_i,     // of the angle, biased
    output logic [6:0] offset_o,       // 0 .. 20 in range
    input  logic [6:0] window_i,
    output logic [7:0] byte_o
);

  // 2/pi truncated to 71 fraction bits, and zeros above.
  localparam logic [91:0] TWO_OVER_PI = 92'h00000517cc1b727220a94fe;
  localparam logic [4:0] EXP_MAX_LOW = 5'd7;  // of 135, of 256

  logic unused_exponent;

  assign offset_o        = {2'b00, EXP_MAX_LOW - exponent_i[4:0]};
  assign byte_o          = 8'(TWO_OVER_PI >> window_i);
  assign unused_exponent = ^exponent_i[7:5];

endmodule
