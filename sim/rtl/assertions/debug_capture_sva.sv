// SPDX-License-Identifier: Apache-2.0
// debug_capture_sva: the words of a run are whole until the channels have them.
module debug_capture_sva (
    input logic       clk_i,
    input logic       rst_ni,
    input logic       ended_i,
    input logic       walk_q,
    input logic [2:0] channel_o,
    input logic [3:0] write_i
);

  WordsOfOneRun : assert property (@(posedge clk_i) disable iff (!rst_ni)
      walk_q |-> write_i == '0)
  else $error("the core writes a word of the next run before channel %0d has its own", channel_o);

  EachChannel : assert property (@(posedge clk_i) disable iff (!rst_ni)
      walk_q && channel_o != 3'd7 |=> walk_q && channel_o == $past(channel_o) + 3'd1)
  else $error("a channel has no word of its own");

  FirstChannel : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(ended_i) |=> walk_q && channel_o == 3'd0)
  else $error("the first channel has no word of its own");

endmodule

bind debug_capture debug_capture_sva u_sva (.*);
