// SPDX-License-Identifier: Apache-2.0
// debug_send_sva: bytes come when they are taken, and a packet fits its half of the buffer.
module debug_send_sva (
    input logic       clk_i,
    input logic       rst_ni,
    input logic       ready_o,
    input logic       put_i,
    input logic       end_i,
    input logic [7:0] at_q,
    input logic [7:0] mark_q,
    input logic       write,
    input logic       half_q,
    input logic [1:0] full_q
);

  PutWhenReady : assert property (@(posedge clk_i) disable iff (!rst_ni)
      put_i || end_i |-> ready_o)
  else $error("a byte or the end of a packet was lost");

  RoomForTheCrc : assert property (@(posedge clk_i) disable iff (!rst_ni)
      put_i |-> at_q <= 8'd252)
  else $error("a packet of more than 252 bytes");

  DistanceFits : assert property (@(posedge clk_i) disable iff (!rst_ni)
      ready_o |-> mark_q < at_q)
  else $error("a distance of COBS is zero");

  SentIsNotBuilt : assert property (@(posedge clk_i) disable iff (!rst_ni)
      write |-> !full_q[half_q])
  else $error("a packet was built over one that is sent");

endmodule

bind debug_send debug_send_sva u_sva (.*);
