// SPDX-License-Identifier: Apache-2.0
// debug_uart_sva: a bit lasts divider_i clocks, a byte ten of them; a byte that came is good or broken, once.
module debug_uart_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic [15:0] divider_i,
    input logic tx_o,
    input logic send_i,
    input logic ready_o,
    input logic received_o,
    input logic broken_o
);

  logic [15:0] divider_q;
  logic [15:0] held_q;  // clocks for which the line has had its level, up to a bit
  logic [19:0] busy_q;  // clocks of this byte
  logic        same_q;  // the divider has not been changed in it
  logic        same, tx_q, turns;

  assign same  = same_q && divider_i == divider_q;
  assign turns = tx_o != tx_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      divider_q <= '0;
      tx_q      <= 1'b1;
      held_q    <= '0;
      busy_q    <= '0;
      same_q    <= 1'b0;
    end else begin
      divider_q <= divider_i;
      tx_q      <= tx_o;
      held_q    <= turns ? 16'd1 : held_q + 16'(held_q != '1);
      busy_q    <= ready_o ? '0 : busy_q + 20'd1;
      same_q    <= ready_o || same;
    end
  end

  DividerFits : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !ready_o |-> divider_i >= 16'd4)
  else $error("a bit of fewer than four clocks");

  IdleIsHigh : assert property (@(posedge clk_i) disable iff (!rst_ni) ready_o |-> tx_o)
  else $error("the line is low between two bytes");

  BitLasts : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !ready_o && !$past(ready_o) && turns && same |-> held_q >= divider_i)
  else $error("a bit is shorter than divider_i clocks");

  ByteLasts : assert property (@(posedge clk_i) disable iff (!rst_ni)
      same && (ready_o ? busy_q != '0 : busy_q >= 20'd10 * 20'(divider_i))
      |-> ready_o && busy_q == 20'd10 * 20'(divider_i))
  else $error("a byte does not take ten bits");

  TakenOnce : assert property (@(posedge clk_i) disable iff (!rst_ni)
      send_i && ready_o |=> !ready_o && !tx_o)
  else $error("a byte was not taken");

  GoodOrBroken : assert property (@(posedge clk_i) disable iff (!rst_ni)
      received_o || broken_o |=> !received_o && !broken_o && !$past(received_o && broken_o))
  else $error("a byte came twice, or both good and broken");

endmodule

bind debug_uart debug_uart_sva u_sva (.*);
