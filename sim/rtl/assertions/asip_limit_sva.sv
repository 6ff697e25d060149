// SPDX-License-Identifier: Apache-2.0
// asip_limit_sva: an operand has one limit at most; it passes or becomes -32, not both.
module asip_limit_sva (
    input logic clk_i,
    input logic used_i,
    input logic below_i,
    input logic above_i,
    input logic keep_o,
    input logic least_o
);

  OneLimit : assert property (@(posedge clk_i) !(below_i && above_i))
  else $error("an operand has two limits");

  Unused : assert property (@(posedge clk_i) !used_i |=> !keep_o && !least_o)
  else $error("an operand that is not used passes");

  // The registers have no reset.
  OneResult : assert property (@(posedge clk_i) 1'b1 |=> !(keep_o && least_o))
  else $error("an operand passes and is limited");

endmodule

bind asip_limit asip_limit_sva u_sva (.*);
