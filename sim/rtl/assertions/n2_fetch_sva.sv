// SPDX-License-Identifier: Apache-2.0
// n2_fetch_sva: a redirect drops what was fetched; a word that waits in D is held.
module n2_fetch_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic en_i,
    input logic hold_i,
    input logic redirect_m_i,
    input logic jump_e_i,
    input logic valid_d_o,
    input logic [31:0] word_d_o
);

  RedirectDrops : assert property (@(posedge clk_i) disable iff (!rst_ni)
      en_i && (redirect_m_i || jump_e_i) |=> !valid_d_o)
  else $error("an instruction behind a transfer is in D");

  HeldInD : assert property (@(posedge clk_i) disable iff (!rst_ni)
      valid_d_o && (!en_i || (hold_i && !redirect_m_i && !jump_e_i)) |=> valid_d_o && $stable(word_d_o))
  else $error("an instruction left D without going on");

endmodule

bind n2_fetch n2_fetch_sva u_sva (.*);
