// SPDX-License-Identifier: Apache-2.0
// servo_link_sva: one access at a time, held until taken; values only of a good run.
module servo_link_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic trigger_i,
    input logic value_valid_o,
    input logic done_o,
    input logic [13:0] address_o,
    input logic read_o,
    input logic write_o,
    input logic waitrequest_i,
    input logic busy_o,
    input logic fault_o
);

  OneAccess : assert property (@(posedge clk_i) disable iff (!rst_ni) !(read_o && write_o))
  else $error("read and write at once");

  HeldUntilTaken : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (read_o || write_o) && waitrequest_i |=> $stable(address_o) && $stable(read_o) && $stable(write_o))
  else $error("an access was dropped");

  ValueOfARead : assert property (@(posedge clk_i) disable iff (!rst_ni)
      value_valid_o |-> read_o && !waitrequest_i)
  else $error("a value that was not read");

  StartsWithATrigger : assert property (@(posedge clk_i) disable iff (!rst_ni)
      busy_o && !$past(busy_o) |-> $past(trigger_i))
  else $error("the link started by itself");

  FaultEndsIt : assert property (@(posedge clk_i) disable iff (!rst_ni)
      fault_o || done_o |=> !busy_o)
  else $error("the link goes on behind its end");

endmodule

bind servo_link servo_link_sva u_sva (.*);
