// SPDX-License-Identifier: Apache-2.0
// drive_axis_sva: the count and its time stamp change together, whichever encoder counts.
module drive_axis_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic [31:0] time_i,
    input logic signed [31:0] position_o,
    input logic [31:0] edge_time_o
);

  StampOfTheCount : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && position_o != $past(position_o) |-> edge_time_o == $past(time_i))
  else $error("the count changed without its time");

  CountOfTheStamp : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && edge_time_o != $past(edge_time_o) |-> position_o != $past(position_o))
  else $error("a time was taken without a count");

endmodule

bind drive_axis drive_axis_sva u_sva (.*);
