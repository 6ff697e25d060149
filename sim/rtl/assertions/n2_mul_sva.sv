// SPDX-License-Identifier: Apache-2.0
// n2_mul_sva: a stage that is frozen keeps what it holds.
module n2_mul_sva (
    input logic        clk_i,
    input logic        en_i,
    input logic [63:0] product_a_o
);

  Frozen : assert property (@(posedge clk_i) !en_i |=> $stable(product_a_o))
  else $error("a result changed in a frozen stage");

endmodule

bind n2_mul n2_mul_sva u_sva (.*);
