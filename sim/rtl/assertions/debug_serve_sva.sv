// SPDX-License-Identifier: Apache-2.0
// debug_serve_sva: requests go first, packets are whole, records go in order or are counted as lost.
module debug_serve_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic stream_i,
    input logic request_i,
    input logic done_o,
    input logic put_o,
    input logic [7:0] data_o,
    input logic end_o,
    input logic ring_taken_i,
    input logic takes,        // ring_data_i
    input logic record_sent,
    input logic restart,      // the scope has been armed
    input logic [31:0] tail_q,
    input logic [15:0] lost_o
);

  logic        inside_q;   // a packet
  logic        anew_q;     // no samples have gone since the scope was armed
  logic [15:0] lost_q;     // then
  logic        sent_q;
  logic        first, samples;

  assign first   = put_o && !inside_q;
  assign samples = first && data_o == debug_pkg::TYPE_SAMPLES;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      inside_q <= 1'b0;
      sent_q   <= 1'b0;
      anew_q   <= 1'b0;
      lost_q   <= '0;
    end else begin
      sent_q   <= record_sent;
      inside_q <= !end_o && (put_o || inside_q);
      anew_q   <= stream_i && (restart || (anew_q && !samples));
      if (restart) lost_q <= lost_o;
    end
  end

  RequestsFirst : assert property (@(posedge clk_i) disable iff (!rst_ni)
      samples || (first && data_o == debug_pkg::TYPE_EVENT) |-> !$past(request_i))
  else $error("an event or samples went before a request");

  EndOfAPacket : assert property (@(posedge clk_i) disable iff (!rst_ni)
      end_o |-> inside_q && !put_o)
  else $error("an end of no packet, or with a byte");

  DoneWithItsAnswer : assert property (@(posedge clk_i) disable iff (!rst_ni)
      done_o |-> request_i && end_o)
  else $error("a request is done without the end of its answer");

  RingWhenFree : assert property (@(posedge clk_i) disable iff (!rst_ni)
      takes |-> !$past(ring_taken_i))
  else $error("a word of the ring was taken that was not read");

  RecordsInOrder : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni && stream_i && !restart) && !$stable(tail_q)
      |-> tail_q == $past(tail_q) + 32'd1 && (sent_q || lost_o == $past(lost_o) + 16'd1))
  else $error("records are sent out of order, or left out without being counted");

  RestartsAtZero : assert property (@(posedge clk_i) disable iff (!rst_ni)
      samples && anew_q && lost_o == lost_q |-> tail_q == '0)
  else $error("samples behind an arming do not begin with record 0");

endmodule

bind debug_serve debug_serve_sva u_sva (
    .takes      (state_q == StNowHere || state_q == StBeforeHere),
    .record_sent(state_q == StRecord),
    .restart    (restart_q),
    .*
);

bind debug_serve avalon_rules #(
    .AddressWidth(15)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    (address_o),
    .read       (read_o),
    .write      (write_o),
    .writedata  (writedata_o),
    .waitrequest(wait_i)
);
