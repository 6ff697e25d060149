// SPDX-License-Identifier: Apache-2.0
// ethercat_slave_sva: the MII's tick is one clock in four, and each register that lives answers alone.
module ethercat_slave_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic mii_tick_i,
    input logic [7:0] hits,
    input logic sm_hit
);

  logic [2:0] ticks_q;  // since the last tick, from its clock on
  logic       ticked_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      ticks_q  <= '0;
      ticked_q <= 1'b0;
    end else begin
      ticks_q  <= mii_tick_i ? 3'd1 : ticks_q + 3'(ticks_q != '1);
      ticked_q <= mii_tick_i || ticked_q;
    end
  end

  OneTickInFour : assert property (@(posedge clk_i) disable iff (!rst_ni)
      ticked_q |-> mii_tick_i == (ticks_q == 3'd4))
  else $error("mii_tick_i is not one clock in four");

  OneAnswers : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $onehot0({hits, sm_hit}))
  else $error("two blocks answer for one register");

endmodule

bind ethercat_slave ethercat_slave_sva u_sva (.*);
