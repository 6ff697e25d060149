// SPDX-License-Identifier: Apache-2.0
// ecat_buffers_sva: writer and reader never share a buffer; a reader's changes only when it opens one; an area is
// handed over only by an access that began at its first byte; an event stays until its side's access.
module ecat_buffers_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic opens,
    input logic passing_i,
    input logic commit_i,
    input logic reads_i,
    input logic writes_i,
    input logic first_i,
    input logic ends_i,
    input logic is_written_o,
    input logic [1:0] writer_q,
    input logic [1:0] reader_q,
    input logic [1:0] middle_q,
    input logic [1:0] settle_q,
    input logic new_q,
    input logic written_q,
    input logic read_q
);

  ThreeDifferent : assert property (@(posedge clk_i) disable iff (!rst_ni)
      writer_q != reader_q && writer_q != middle_q && reader_q != middle_q && writer_q != 2'd3
      && reader_q != 2'd3 && middle_q != 2'd3)
  else $error("two of the three are one buffer");

  ReaderKeeps : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !opens && !clear_i |=> $stable(reader_q))
  else $error("the reader's buffer changed while it reads");

  // The writer's first byte since its last one.
  logic first_seen_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) first_seen_q <= 1'b0;
    else if (clear_i) first_seen_q <= 1'b0;
    else if (writes_i && !passing_i) first_seen_q <= (first_seen_q || first_i) && !ends_i;
  end

  HandedOverWhole : assert property (@(posedge clk_i) disable iff (!rst_ni)
      is_written_o && !clear_i |-> first_i || first_seen_q)
  else $error("a buffer was handed over that did not begin at its first byte");

  WriterLeavesTwoClocks : assert property (@(posedge clk_i) disable iff (!rst_ni)
      settle_q != '0 && !clear_i |-> !(writes_i && !passing_i))
  else $error("a write in the two clocks after the last byte");

  NewIsAnnounced : assert property (@(posedge clk_i) disable iff (!rst_ni) new_q |-> written_q)
  else $error("a complete buffer that the reader has not opened has no event");

  WrittenStays : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $fell(written_q) |-> $past(clear_i || (reads_i && !passing_i && (first_i || (commit_i && ends_i)))))
  else $error("an event of the reader ended without its access");

  ReadStays : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $fell(read_q) |-> $past(clear_i || (writes_i && !passing_i && (first_i || (commit_i && ends_i)))))
  else $error("an event of the writer ended without its access");

  WrittenBegins : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $rose(written_q) |-> $past(is_written_o, 3))
  else $error("an event of the reader began without a complete buffer");

  ReadBegins : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $rose(read_q) |-> $past(reads_i && ends_i && !passing_i))
  else $error("an event of the writer began without a read to the end");

  OneSide : assert property (@(posedge clk_i) disable iff (!rst_ni) !(passing_i && commit_i))
  else $error("an access of two kinds");

endmodule

bind ecat_buffers ecat_buffers_sva u_sva (.*);
