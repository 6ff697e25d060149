// SPDX-License-Identifier: Apache-2.0
// ecat_protection_sva: only passing frames are refused, only under a protection, and each frame begins closed.
module ecat_protection_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic frame_start_i,
    input logic frame,             // the access is one of a passing frame
    input logic [1:0] protected_q,
    input logic [1:0] enabled_q,
    input logic refused_o
);

  FramesAlone : assert property (@(posedge clk_i) disable iff (!rst_ni)
      refused_o |-> frame && protected_q != '0)
  else $error("a write was refused that no protection concerns");

  BeginsClosed : assert property (@(posedge clk_i) disable iff (!rst_ni)
      frame_start_i |=> enabled_q == '0)
  else $error("a frame begins with the writes that an earlier one has freed");

endmodule

bind ecat_protection ecat_protection_sva u_sva (
    .clk_i,
    .rst_ni,
    .frame_start_i,
    .frame(access_i.frame),
    .protected_q,
    .enabled_q,
    .refused_o
);
