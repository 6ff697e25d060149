// SPDX-License-Identifier: Apache-2.0
// n2_shift_sva: a stage that is frozen keeps what it holds.
module n2_shift_sva (
    input logic        clk_i,
    input logic        en_i,
    input logic [31:0] result_m_o
);

  Frozen : assert property (@(posedge clk_i) !en_i |=> $stable(result_m_o))
  else $error("a result changed in a frozen stage");

endmodule

bind n2_shift n2_shift_sva u_sva (.*);
