// SPDX-License-Identifier: Apache-2.0
// asip_stream_sva: the pointer of a stream moves by what the bundle that issues says, and by nothing else.
module asip_stream_sva #(
    parameter int unsigned AddressWidth = 1,
    parameter int unsigned Lanes = 0
) (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic take_i,
    input logic seek_i,
    input logic [14:0] seek_address_i,
    input logic [Lanes:0] write_q,
    input logic [AddressWidth-1:0] pointer_q,
    input logic [AddressWidth-1:0] read_q,
    input logic fresh_r1_q
);

  HostIdle : assert property (@(posedge clk_i) disable iff (!rst_ni)
      |write_q |-> !take_i && !seek_i)
  else $error("the host writes a stream that a run reads");

  logic [AddressWidth-1:0] at_d, at_q, at_held, at_r1;  // addresses of word_d, word_q, held_q, word_r1_o

  assign at_r1 = fresh_r1_q ? at_q : at_held;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      at_d    <= '0;
      at_q    <= '0;
      at_held <= '0;
    end else begin
      at_d    <= read_q;
      at_q    <= at_d;
      at_held <= at_r1;
    end
  end

  ReadAhead : assert property (@(posedge clk_i) disable iff (!rst_ni)
      take_i |=> at_r1 == $past(pointer_q))
  else $error("the word read for the bundle in Q is not the one that it takes in D");

  Written : assert property (@(posedge clk_i) disable iff (!rst_ni)
      |write_q |=> !take_i)
  else $error("a bundle takes a word that was read while the host wrote");

  NothingIssues : assert property (@(posedge clk_i) disable iff (!rst_ni)
      clear_i |-> !take_i && !seek_i)
  else $error("a bundle issues in the cycle in which fetch begins at an entry");

  FirstWord : assert property (@(posedge clk_i) disable iff (!rst_ni)
      clear_i |=> pointer_q == '0)
  else $error("a run does not begin at the first word");

  Stays : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !clear_i && !take_i && !seek_i |=> $stable(pointer_q))
  else $error("the stream went on without a bundle");

  Steps : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !clear_i && take_i && !seek_i |=> pointer_q == AddressWidth'($past(pointer_q) + 1'b1))
  else $error("a word was taken and the stream did not go on by one");

  Sought : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !clear_i && seek_i |=> pointer_q == $past(seek_address_i[AddressWidth-1:0]))
  else $error("a seek did not set the pointer");

endmodule

bind asip_stream asip_stream_sva #(
    .AddressWidth(AddressWidth),
    .Lanes(Lanes)
) u_sva (.*);
