// SPDX-License-Identifier: Apache-2.0
// asip_plausible_sva: no output is shown before it was checked, or that was found implausible.
module asip_plausible_sva (
    input logic       clk_i,
    input logic       rst_ni,
    input logic       run_start_i,
    input logic       busy_i,
    input logic       commit_i,
    input logic       write_i,
    input logic       checking_o,
    input logic       implausible_o,
    input logic [4:0] index_o,
    input logic       host_write_i
);

  localparam int unsigned Outputs = asip_regmap_pkg::WORDS_PLAUSIBLE_ON;
  localparam int unsigned Longest = 26 * Outputs + 13;

  int unsigned open_q;  // clocks since the run ended in which the verdict was open

  always_ff @(posedge clk_i) open_q <= checking_o && !busy_i ? open_q + 1 : 0;

  CommitOfWhatWasJudged : assert property (@(posedge clk_i) disable iff (!rst_ni)
      commit_i |-> !checking_o && !implausible_o)
  else $error("outputs are shown that were not judged, or that are implausible");

  VerdictStands : assert property (@(posedge clk_i) disable iff (!rst_ni)
      implausible_o && !run_start_i |=> implausible_o && $stable(index_o))
  else $error("a verdict was lost before the next run");

  VerdictInTime : assert property (@(posedge clk_i) disable iff (!rst_ni)
      open_q <= Longest)
  else $error("a verdict is open more than 26 clocks an output and 13 more behind the run");

  OutputOfTheRecord : assert property (@(posedge clk_i) disable iff (!rst_ni)
      implausible_o |-> 32'(index_o) < Outputs)
  else $error("an output without a record was judged");

  RecordIdle : assert property (@(posedge clk_i) disable iff (!rst_ni)
      host_write_i |-> !write_i && !checking_o)
  else $error("the record changes while an output is judged");

endmodule

bind asip_plausible asip_plausible_sva u_sva (.*);
