// SPDX-License-Identifier: Apache-2.0
// ecat_buffers_sva: writer and reader never share a buffer; a reader's changes only when it opens one.
module ecat_buffers_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic opens_i,
    input logic [1:0] writer_q,
    input logic [1:0] reader_q,
    input logic [1:0] middle_q
);

  ThreeDifferent : assert property (@(posedge clk_i) disable iff (!rst_ni)
      writer_q != reader_q && writer_q != middle_q && reader_q != middle_q && writer_q != 2'd3
      && reader_q != 2'd3 && middle_q != 2'd3)
  else $error("two of the three are one buffer");

  ReaderKeeps : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !opens_i && !clear_i |=> $stable(reader_q))
  else $error("the reader's buffer changed while it reads");


endmodule

bind ecat_buffers ecat_buffers_sva u_sva (.*);
