// SPDX-License-Identifier: Apache-2.0
// ecat_application_sva: one target at a time, reads after the writes before them, a window that holds still.
module ecat_application_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic avs_read_i,
    input logic avs_waitrequest_o,
    input logic valid_o,
    input logic sii_read_o,
    input logic sii_write_o,
    input logic done_i,
    input logic take,
    input logic take_start,
    input logic take_word,
    input logic store_q,
    input logic fetch_q,
    input logic [3:0] inside_q,
    input logic [7:0] back_q,
    input logic [6:0] end_q
);

  OneTarget : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !(valid_o && (sii_read_o || sii_write_o)))
  else $error("controller and SII at once");

  AnswersOnce : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !avs_waitrequest_o |=> avs_waitrequest_o)
  else $error("two answers");

  DoneWereInside : assert property (@(posedge clk_i) disable iff (!rst_ni)
      done_i |-> inside_q != '0)
  else $error("a byte is done that did not go in");

  ReadsAfterWrites : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (take && avs_read_i) || take_start |-> inside_q == '0)
  else $error("a read begins before the writes are done");

  WindowIsWhole : assert property (@(posedge clk_i) disable iff (!rst_ni)
      take_word |-> !store_q)
  else $error("a word is read while one is written");

  FetchEnds : assert property (@(posedge clk_i) disable iff (!rst_ni)
      fetch_q |-> back_q <= {1'b0, end_q})
  else $error("more words than were ordered");

endmodule

bind ecat_application ecat_application_sva u_sva (.*);

bind ecat_application avalon_rules #(
    .AddressWidth(18)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    ({avs_byteenable_i, avs_address_i}),
    .read       (avs_read_i),
    .write      (avs_write_i),
    .writedata  (avs_writedata_i),
    .waitrequest(avs_waitrequest_o)
);
