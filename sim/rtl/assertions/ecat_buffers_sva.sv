// SPDX-License-Identifier: Apache-2.0
// ecat_buffers_sva: writer and reader never share a buffer; a reader's changes only when it opens one; an area is
// handed over only by an access that began at its first byte.
module ecat_buffers_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic opens,
    input logic passing_i,
    input logic commit_i,
    input logic writes_i,
    input logic first_i,
    input logic ends_i,
    input logic is_written_o,
    input logic [1:0] writer_q,
    input logic [1:0] reader_q,
    input logic [1:0] middle_q
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

  OneSide : assert property (@(posedge clk_i) disable iff (!rst_ni) !(passing_i && commit_i))
  else $error("an access of two kinds");

endmodule

bind ecat_buffers ecat_buffers_sva u_sva (.*);
