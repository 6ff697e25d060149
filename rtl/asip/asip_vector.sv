// SPDX-License-Identifier: Apache-2.0
// asip_vector: what a vector operation makes of its operands before the multiply-add. Combinational.
// Contract: with power_i operand b becomes 2^n, n the int8 in its lowest bits; with below_i operand a becomes
// max(min(a, 0), -32), with above_i max(a, 0); a NaN stays one. Without any of them both pass unchanged.
module asip_vector (
    input  logic        power_i,
    input  logic        below_i,
    input  logic        above_i,
    input  logic [31:0] a_i,
    input  logic [31:0] b_i,
    output logic [31:0] a_o,
    output logic [31:0] b_o
);

  localparam logic [31:0] Least = 32'hC200_0000;  // -32

  logic is_nan, far, zero;
  logic [7:0] exponent;

  assign is_nan   = (&a_i[30:23]) && (|a_i[22:0]);
  assign far      = below_i && a_i[31] && a_i[30:23] >= Least[30:23] && !is_nan;
  assign zero     = !is_nan && ((below_i && !a_i[31]) || (above_i && a_i[31]));
  assign exponent = b_i[7:0] + 8'd127;
  assign a_o      = far ? Least : (zero ? '0 : a_i);
  assign b_o      = power_i ? {1'b0, exponent, 23'd0} : b_i;

endmodule
