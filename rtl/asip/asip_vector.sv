// SPDX-License-Identifier: Apache-2.0
// asip_vector: what a vector operation makes of its operands before the multiply-add. Combinational.
// Contract: with power_i operand b becomes 2^n, n the int8 in its lowest bits; with below_i operand a becomes
// max(min(a, 0), -32), with above_i max(a, 0); a NaN stays one. Without any of them both pass unchanged.
// At most one of them is set. The exponents of the multiply-add follow in the same cycle, so the
// selection is computed in parallel: the limit from sign and exponent alone, and whether the operand is a NaN.
module asip_vector (
    input  logic        power_i,
    input  logic        below_i,
    input  logic        above_i,
    input  logic [31:0] a_i,
    input  logic [31:0] b_i,
    output logic [31:0] a_o,
    output logic [31:0] b_o
);

  logic highest, fraction, far, limited, keep, least;
  logic [7:0] exponent, power;

  assign highest  = &a_i[30:23];
  assign fraction = |a_i[22:0];
  assign far      = a_i[30] && (|a_i[29:25]);  // 32 or more
  assign limited  = a_i[31] ? above_i || (below_i && far) : below_i;
  assign keep     = !limited || (highest && fraction);
  assign least    = below_i && a_i[31] && far && !(highest && fraction);

  // -32 has three bits set.
  assign a_o = (a_i & {32{keep}}) | {least, least, 4'd0, least, 25'd0};

  // n + 127 = (n ^ 128) - 1 modulo 256: a bit changes if all below it are zero.
  assign exponent = {!b_i[7], b_i[6:0]};
  always_comb begin
    for (int unsigned i = 0; i < 8; i++) power[i] = exponent[i] ^ !(|(b_i[7:0] & 8'((1 << i) - 1)));
  end
  assign b_o = (b_i & {32{!power_i}}) | {1'b0, power & {8{power_i}}, 23'd0};

endmodule
