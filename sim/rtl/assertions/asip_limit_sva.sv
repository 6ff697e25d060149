// SPDX-License-Identifier: Apache-2.0
// asip_limit_sva: an operand passes or becomes -32, not both.
module asip_limit_sva (
    input logic clk_i,
    input logic keep_o,
    input logic least_o
);

  OneResult : assert property (@(posedge clk_i) !(keep_o && least_o))
  else $error("an operand passes and is limited");

endmodule

bind asip_limit asip_limit_sva u_sva (.*);
