// SPDX-License-Identifier: Apache-2.0
// mii_receive_sva: the store of nibbles never overflows.
module mii_receive_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic take,
    input logic [5:0] then_q,
    input logic [3:0] level
);

  RoomForANibble : assert property (@(posedge clk_i) disable iff (!rst_ni)
      take && then_q[5] |-> level < 4'd8)
  else $error("a nibble takes the place of one that has not left");

endmodule

bind mii_receive mii_receive_sva u_sva (.*);
