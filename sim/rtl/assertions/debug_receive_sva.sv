// SPDX-License-Identifier: Apache-2.0
// debug_receive_sva: a request stays, unchanged, until it is done; each frame is handed on or dropped.
module debug_receive_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic received_i,
    input logic [7:0] data_i,
    input logic request_o,
    input logic [5:0] length_o,
    input logic [5:0] index_i,
    input logic [7:0] data_o,
    input logic done_i,
    input logic dropped_o
);

  localparam logic [5:0] Largest = 6'd4 + 6'd2 + 6'(4 * debug_pkg::WRITE_WORDS);

  RequestStands : assert property (@(posedge clk_i) disable iff (!rst_ni)
      request_o && !done_i |=> request_o && $stable(length_o))
  else $error("a request went or changed before it was done");

  DoneOfARequest : assert property (@(posedge clk_i) disable iff (!rst_ni) done_i |-> request_o)
  else $error("an end of no request");

  LengthFits : assert property (@(posedge clk_i) disable iff (!rst_ni)
      request_o |-> length_o >= 6'd4 && length_o <= Largest)
  else $error("a request is too short or too long");

  ByteStands : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(request_o, 2) && request_o && $past(index_i) == $past(index_i, 2) |-> $stable(data_o))
  else $error("a byte of a waiting request was overwritten");

  EndOfAFrame : assert property (@(posedge clk_i) disable iff (!rst_ni)
      dropped_o || (request_o && !$past(request_o)) |-> $past(received_i && data_i == '0))
  else $error("a frame was handed on or dropped before its end");

  HandedOnOrDropped : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !(dropped_o && request_o && !$past(request_o)))
  else $error("a frame was handed on and dropped");

endmodule

bind debug_receive debug_receive_sva u_sva (.*);
