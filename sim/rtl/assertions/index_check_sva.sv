// SPDX-License-Identifier: Apache-2.0
// index_check_sva: an axis without a distance reports nothing, and reports stay until they are cleared.
module index_check_sva #(
    parameter int unsigned Axes = 5
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [24*Axes-1:0] distance_i,
    input logic [Axes-1:0] clear_i,
    input logic [Axes-1:0] lost_o
);

  DistanceZeroIsOff : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && $past(distance_i) == '0 |-> (lost_o & ~$past(lost_o)) == '0)
  else $error("an index is reported of an axis without a distance");

  StaysUntilCleared : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) |-> ($past(lost_o) & ~$past(clear_i) & ~lost_o) == '0)
  else $error("a report is forgotten without a clear");

endmodule

bind index_check index_check_sva #(
    .Axes(Axes)
) u_sva (.*);
