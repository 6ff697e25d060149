// SPDX-License-Identifier: Apache-2.0
// ecat_datagrams_sva: an answer 18 clocks after its byte, for 8 clocks; accesses only of datagrams that are served.
module ecat_datagrams_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic byte_valid_i,
    input logic [7:0] result_o,
    input logic malformed_o,
    input logic foreign_o,
    input logic serve_i,
    input logic data_begin,  // the byte is the last of a datagram's header
    input logic looped_i,
    input logic cut_foreign_i,
    input logic destroy_o,
    input logic request_o,
    input logic read_o,
    input logic write_o,
    input logic read_done_i,
    input logic write_done_i
);

  localparam int unsigned Apart = 8;    // clocks between two bytes
  localparam int unsigned Access = 17;  // from a byte to what it read

  logic [Access+Apart:0] bytes_q, requests_q;  // bit n: n + 1 clocks ago
  logic                  serve_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      bytes_q    <= '0;
      requests_q <= '0;
      serve_q    <= 1'b0;
    end else begin
      bytes_q    <= {bytes_q[Access+Apart-1:0], byte_valid_i};
      requests_q <= {requests_q[Access+Apart-1:0], request_o};
      if (byte_valid_i && data_begin) serve_q <= serve_i;
    end
  end

  BytesApart : assert property (@(posedge clk_i) disable iff (!rst_ni)
      byte_valid_i |-> bytes_q[Apart-2:0] == '0)
  else $error("a byte comes while the accesses of the one before enter");

  // Clocks 19 to 25 after a byte: it was there before.
  AnswerStands : assert property (@(posedge clk_i) disable iff (!rst_ni)
      bytes_q[Access+Apart-1:Access+1] != '0 |-> $stable(result_o))
  else $error("an answer does not stand for 8 clocks");

  DoneOfARequest : assert property (@(posedge clk_i) disable iff (!rst_ni)
      bytes_q[Access-1] && !requests_q[Access-1] |-> !read_done_i && !write_done_i)
  else $error("a byte was read or written that was not asked for");

  RequestIfServed : assert property (@(posedge clk_i) disable iff (!rst_ni)
      request_o |-> byte_valid_i && serve_q && (read_o || write_o))
  else $error("an access of a datagram that is not served");

  ForeignIsNotMalformed : assert property (@(posedge clk_i) disable iff (!rst_ni)
      foreign_o |-> !malformed_o)
  else $error("a frame of another type is malformed");

  DestroyedForAReason : assert property (@(posedge clk_i) disable iff (!rst_ni)
      destroy_o |-> byte_valid_i && (looped_i || (foreign_o && cut_foreign_i)))
  else $error("a frame was destroyed that did not come from port 1 and may pass");

endmodule

bind ecat_datagrams ecat_datagrams_sva u_sva (
    .data_begin(state_q == StDatagram && count_q == 4'd9),
    .*
);
