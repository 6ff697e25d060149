// SPDX-License-Identifier: Apache-2.0
// absolute_registers_sva: what a request does, what a read takes and keeps.
module absolute_registers_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic read_i,
    input logic waitrequest_o,
    input logic request_o,
    input logic busy_i,
    input logic done_i,
    input logic lost_i,
    input logic clear,
    input logic missed_q,
    input logic low_read,
    input logic [63:0] position,
    input logic [31:0] high_q,
    input logic [31:0] good_q
);

  ReadInTwoClocks : assert property (@(posedge clk_i) disable iff (!rst_ni)
      read_i && waitrequest_o |=> !waitrequest_o)
  else $error("a read takes more than two clocks");

  RequestBeginsAFrame : assert property (@(posedge clk_i) disable iff (!rst_ni)
      request_o && !busy_i |=> busy_i || (done_i && lost_i))
  else $error("a request neither begins a frame nor ends lost");

  DroppedRequestIsFlagged : assert property (@(posedge clk_i) disable iff (!rst_ni)
      request_o && busy_i |=> missed_q)
  else $error("a request was dropped in silence");

  HighOfTheLow : assert property (@(posedge clk_i) disable iff (!rst_ni)
      low_read |=> high_q == $past(position[63:32]))
  else $error("the high word is not of the frame of the low one");

  HighIsKept : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && !low_read |=> $stable(high_q))
  else $error("the high word changed without a read of the low one");

  CountsFrames : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && !done_i && !clear |=> $stable(good_q))
  else $error("a good frame was counted that did not end");

endmodule

bind absolute_registers absolute_registers_sva u_sva (.*);

bind absolute_registers avalon_rules #(
    .AddressWidth(absolute_regmap_pkg::ADDRESS_WIDTH)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    (address_i),
    .read       (read_i),
    .write      (write_i),
    .writedata  (writedata_i),
    .waitrequest(waitrequest_o)
);
