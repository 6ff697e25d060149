// SPDX-License-Identifier: Apache-2.0
// ecat_sync_managers_sva: a passing frame restarts no watchdog, and each side has one direction.
module ecat_sync_managers_sva (
    input logic clk_i,
    input logic rst_ni,
    input ecat_pkg::access_t access_i,
    input ecat_pkg::register_access_t register_i,
    input logic [ecat_pkg::SYNC_MANAGERS-1:0] hit_q,
    input logic read_o,
    input logic write_o,
    input logic changed_o,
    input logic watchdog_o
);

  OneSide : assert property (@(posedge clk_i) disable iff (!rst_ni)
      access_i.valid |-> $onehot({access_i.frame, access_i.commit, access_i.application}))
  else $error("an access of nobody or of two sides");

  WatchdogOfACommit : assert property (@(posedge clk_i) disable iff (!rst_ni)
      watchdog_o |-> $past(access_i.valid && access_i.commit))
  else $error("a frame that is not good yet restarted the watchdog");

  OneDirection : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(hit_q != '0) && $past(access_i.valid && !access_i.commit, 2) |-> !(read_o && write_o))
  else $error("one side may read and write a guarded byte");

  ChangedByTheMaster : assert property (@(posedge clk_i) disable iff (!rst_ni)
      changed_o |-> register_i.write && !register_i.application)
  else $error("a sync manager was set up by somebody else");

endmodule

bind ecat_sync_managers ecat_sync_managers_sva u_sva (.*);
