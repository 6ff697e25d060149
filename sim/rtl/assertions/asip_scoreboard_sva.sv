// SPDX-License-Identifier: Apache-2.0
// asip_scoreboard_sva: a register has one write in flight at most.
module asip_scoreboard_sva #(
    parameter int unsigned IndexWidth = 6
) (
    input logic clk_i,
    input logic rst_ni,
    input logic set_i,
    input logic clear_i,
    input logic [IndexWidth-1:0] set_index_i,
    input logic [IndexWidth-1:0] clear_index_i,
    input logic [2**IndexWidth-1:0] pending_q
);

  OneWrite : assert property (@(posedge clk_i) disable iff (!rst_ni)
      set_i |-> !pending_q[set_index_i])
  else $error("a second write to a register that has one in flight");

  EndsWhatBegan : assert property (@(posedge clk_i) disable iff (!rst_ni)
      clear_i |-> pending_q[clear_index_i])
  else $error("the end of a write that was not in flight");

endmodule

bind asip_scoreboard asip_scoreboard_sva #(
    .IndexWidth(IndexWidth)
) u_sva (.*);
