// SPDX-License-Identifier: Apache-2.0
// ecat_reset_sva: a reset follows the third byte, and another byte or none does not come near it.
module ecat_reset_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic [1:0] state_q,
    input logic done_i,
    input logic written_q,
    input logic reset_no
);

  OneByteAFrame : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && state_q > $past(state_q) |-> state_q == $past(state_q) + 2'd1 && $past(done_i && written_q))
  else $error("a byte of the sequence counted without its frame");

  ResetAfterThree : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $fell(reset_no) |-> state_q == 2'd3)
  else $error("a reset without its sequence");

endmodule

bind ecat_reset ecat_reset_sva u_sva (
    .state_q(2'(state_q)),
    .*
);
