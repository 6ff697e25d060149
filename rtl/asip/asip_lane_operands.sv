// SPDX-License-Identifier: Apache-2.0
// asip_lane_operands: operands of a lane's multiply-add, its own or those of the pipe. Combinational.
// Contract: operand i is own_i[i] if select_i[i] is set, otherwise pipe_i[i]. Operands a and b are then changed as
// asip_vector does. Of own_i[0] it is known that it is a number of this sign, positive_i or negative_i, and that it
// is -32 or less, far_i; own_power_i is the exponent that own_i[1] has as a power of two. So the exponents of the
// multiply-add wait for nothing but the operands of the pipe, and for three levels of logic.
module asip_lane_operands (
    input  logic             power_i,
    input  logic             below_i,
    input  logic             above_i,
    input  logic [2:0]       select_i,
    input  logic [2:0][31:0] own_i,
    input  logic             positive_i,
    input  logic             negative_i,
    input  logic             far_i,
    input  logic [7:0]       own_power_i,
    input  logic [2:0][31:0] pipe_i,
    output logic [31:0]      a_o,
    output logic [31:0]      b_o,
    output logic [31:0]      c_o
);

  logic keep_own, least_own, far, nan, keep_pipe, least_pipe, least;
  logic [7:0] power;

  assign keep_own  = select_i[0] && !(below_i && (positive_i || far_i)) && !(above_i && negative_i);
  assign least_own = select_i[0] && below_i && far_i;

  assign far        = pipe_i[0][30] && (|pipe_i[0][29:25]);  // 32 or more
  assign nan        = (&pipe_i[0][30:23]) && (|pipe_i[0][22:0]);
  assign keep_pipe  = !select_i[0] && (nan || !(pipe_i[0][31] ? above_i || (below_i && far) : below_i));
  assign least_pipe = !select_i[0] && !nan && below_i && pipe_i[0][31] && far;

  // -32 has three bits set.
  assign least = least_own || least_pipe;
  assign a_o   = (own_i[0] & {32{keep_own}}) | (pipe_i[0] & {32{keep_pipe}}) | {least, least, 4'd0, least, 25'd0};

  // n + 127 = (n ^ 128) - 1 modulo 256: a bit changes if all below it are zero.
  always_comb begin
    for (int unsigned i = 0; i < 8; i++) begin
      power[i] = pipe_i[1][i] ^ (i == 7) ^ !(|(pipe_i[1][7:0] & 8'((1 << i) - 1)));
    end
    if (select_i[1]) power = own_power_i;
  end
  assign b_o = power_i ? {1'b0, power, 23'd0} : (select_i[1] ? own_i[1] : pipe_i[1]);
  assign c_o = select_i[2] ? own_i[2] : pipe_i[2];

endmodule
