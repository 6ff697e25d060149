// SPDX-License-Identifier: Apache-2.0
// ecat_access_sva: a passing frame goes first and stores nothing; what the application asked is done in time.
module ecat_access_sva (
    input logic       clk_i,
    input logic       rst_ni,
    input logic       ready_o,
    input logic       frame_slot,
    input logic       commit_ready_o,
    input logic       app_valid_i,
    input logic       app_ready_o,
    input logic       app_done_o,
    input logic       frame_leaves,  // an access of a frame is at the memory
    input logic [1:0] store
);

  FrameFirst : assert property (@(posedge clk_i) disable iff (!rst_ni)
      frame_slot |-> !commit_ready_o && !app_ready_o)
  else $error("another access was taken in a clock of the frame");

  FrameStoresNothing : assert property (@(posedge clk_i) disable iff (!rst_ni)
      frame_leaves |-> store == 2'b00)
  else $error("a passing frame changed a byte before its check sequence was seen");

  NothingBeforeReset : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !ready_o |-> !app_ready_o)
  else $error("the application was served before the registers had their reset values");

  DoneInEight : assert property (@(posedge clk_i) disable iff (!rst_ni)
      app_done_o |-> $past(app_valid_i && app_ready_o, 8))
  else $error("done without an access of the application 8 clocks before");

endmodule

bind ecat_access ecat_access_sva u_sva (
    .clk_i,
    .rst_ni,
    .ready_o,
    .frame_slot,
    .commit_ready_o,
    .app_valid_i,
    .app_ready_o,
    .app_done_o,
    .frame_leaves(access_8_q.valid && access_8_q.frame),
    .store
);
