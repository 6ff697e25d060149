// SPDX-License-Identifier: Apache-2.0
// endat_master_sva: who has the line, and the rules of every absolute encoder's master.
module endat_master_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic clock_o,
    input logic data_en_o,
    input logic busy_o,
    input logic done_o,
    input logic start
);

  DrivesInAFrameAlone : assert property (@(posedge clk_i) disable iff (!rst_ni)
      data_en_o |-> busy_o)
  else $error("the master has the line without a frame");

  ReleasedBeforeTheStartBit : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start |-> !data_en_o)
  else $error("master and encoder both have the line");

  DataChangesWithTheFallingClock : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && !$stable(data_en_o) |-> $fell(clock_o))
  else $error("the line changes its direction apart from the falling clock");

  StaysBusyAfterTheEnd : assert property (@(posedge clk_i) disable iff (!rst_ni)
      done_o |-> busy_o && clock_o)
  else $error("a frame ended without the recovery time");

endmodule

bind endat_master endat_master_sva u_sva (.*);

bind endat_master absolute_rules #(
    .Width(Width)
) u_rules (
    .clk_i,
    .rst_ni,
    .start    (start_i),
    .clock    (clock_o),
    .busy     (busy_o),
    .done     (done_o),
    .position (position_o),
    .crc_error(crc_error_o),
    .lost     (lost_o)
);
