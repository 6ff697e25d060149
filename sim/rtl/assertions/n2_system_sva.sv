// SPDX-License-Identifier: Apache-2.0
// n2_system_sva: an access where no agent is ends in its cycle.
module n2_system_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic stray,
    input logic avm_waitrequest
);

  StrayEnds : assert property (@(posedge clk_i) disable iff (!rst_ni) stray |-> !avm_waitrequest)
  else $error("an access where no agent is waits");

endmodule

bind n2_system n2_system_sva u_sva (
    .clk_i,
    .rst_ni,
    .stray(External == 0 && (avm_read || avm_write) && !io_select),
    .avm_waitrequest
);
