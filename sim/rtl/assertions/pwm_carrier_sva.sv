// SPDX-License-Identifier: Apache-2.0
// pwm_carrier_sva: the triangle moves by one, turns at its ends, has one window in each half.
module pwm_carrier_sva #(
    parameter int unsigned Width = 12
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [Width-1:0] count_o,
    input logic up_o,
    input logic load_o,
    input logic window_o,
    input logic [Width-1:0] half_o
);

  logic window_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) window_q <= 1'b0;
    else window_q <= !load_o && (window_q || window_o);
  end

  InRange : assert property (@(posedge clk_i) disable iff (!rst_ni) count_o <= half_o)
  else $error("the carrier is above its half period");

  Steps : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !load_o |=> $stable(up_o) && ($stable(count_o)
                  || count_o == (up_o ? $past(count_o) + 1'b1 : $past(count_o) - 1'b1)))
  else $error("the carrier jumped");

  Turns : assert property (@(posedge clk_i) disable iff (!rst_ni)
      load_o |=> up_o == !$past(up_o) && count_o == (up_o ? '0 : half_o))
  else $error("the carrier does not begin its half at the end");

  OneWindow : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (load_o |-> window_q || window_o) and (window_o |-> !window_q))
  else $error("a half period without or with two windows");

endmodule

bind pwm_carrier pwm_carrier_sva #(
    .Width(Width)
) u_sva (.*);
