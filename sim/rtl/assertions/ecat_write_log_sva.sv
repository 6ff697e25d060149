// SPDX-License-Identifier: Apache-2.0
// ecat_write_log_sva: nothing comes in while a frame's entries go out; an entry is held until taken.
module ecat_write_log_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic push_i,
    input logic busy_o,
    input logic valid_o,
    input logic ready_i,
    input logic [ecat_pkg::LOG_WIDTH-1:0] entry_o
);

  QuietWhileBusy : assert property (@(posedge clk_i) disable iff (!rst_ni) busy_o |-> !push_i)
  else $error("an entry came while others go out");

  HeldUntilTaken : assert property (@(posedge clk_i) disable iff (!rst_ni)
      valid_o && !ready_i |=> valid_o && $stable(entry_o))
  else $error("an entry was dropped");

  OnlyWhileBusy : assert property (@(posedge clk_i) disable iff (!rst_ni) valid_o |-> busy_o)
  else $error("an entry without a commit");

endmodule

bind ecat_write_log ecat_write_log_sva u_sva (.*);
