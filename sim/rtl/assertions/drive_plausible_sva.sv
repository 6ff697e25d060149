// SPDX-License-Identifier: Apache-2.0
// drive_plausible_sva: only values that persist are reported, of axes that run, and reports stay until cleared.
module drive_plausible_sva #(
    parameter int unsigned Axes = 5
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [Axes-1:0] run_i,
    input logic [Axes-1:0] clear_i,
    input logic [7:0] persist_i,
    input logic [Axes-1:0] lost_o
);

  PersistZeroIsOff : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && $past(persist_i) == '0 |-> (lost_o & ~$past(lost_o)) == '0)
  else $error("a current is reported though nothing need persist");

  OfAxesThatRun : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) |-> (lost_o & ~$past(lost_o) & ~$past(run_i)) == '0)
  else $error("a current is reported of an axis that does not run");

  StaysUntilCleared : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) |-> ($past(lost_o) & ~$past(clear_i) & ~lost_o) == '0)
  else $error("a report is forgotten without a clear");

endmodule

bind drive_plausible drive_plausible_sva #(
    .Axes(Axes)
) u_sva (.*);
