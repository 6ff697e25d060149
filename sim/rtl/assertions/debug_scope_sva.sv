// SPDX-License-Identifier: Apache-2.0
// debug_scope_sva: a record is of one run, and a frozen ring keeps what it has.
module debug_scope_sva (
    input logic        clk_i,
    input logic        rst_ni,
    input logic        arm,
    input logic        freeze,
    input logic        recording_q,
    input logic        wait_k_o,
    input logic [1:0]  state_o,
    input logic [31:0] records_o,
    input logic        black_box_o
);

  InputsOfOneRun : assert property (@(posedge clk_i) disable iff (!rst_ni)
      recording_q |-> wait_k_o)
  else $error("the host may change a word of bank K while it is recorded");

  FrozenKeeps : assert property (@(posedge clk_i) disable iff (!rst_ni)
      state_o == debug_regmap_pkg::SCOPE_STATE_FROZEN && !arm |=>
      state_o == debug_regmap_pkg::SCOPE_STATE_FROZEN && $stable(records_o) && !recording_q)
  else $error("a frozen ring was written");

  BlackBoxIsFrozen : assert property (@(posedge clk_i) disable iff (!rst_ni)
      black_box_o |-> state_o == debug_regmap_pkg::SCOPE_STATE_FROZEN)
  else $error("records follow a fault");

  FreezeActs : assert property (@(posedge clk_i) disable iff (!rst_ni)
      freeze && !arm |=> state_o == debug_regmap_pkg::SCOPE_STATE_FROZEN)
  else $error("CONTROL.freeze did nothing");

endmodule

bind debug_scope debug_scope_sva u_sva (.*);
