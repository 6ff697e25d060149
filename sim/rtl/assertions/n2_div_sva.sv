// SPDX-License-Identifier: Apache-2.0
// n2_div_sva: 18 cycles a division, no start within one, the quotient holds.
module n2_div_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic start_i,
    input logic busy_o,
    input logic [31:0] quotient_o
);

  logic [4:0] cycles_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) cycles_q <= 5'd0;
    else cycles_q <= busy_o ? cycles_q + 5'd1 : 5'd0;
  end

  NoStartWhileBusy : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start_i |-> !busy_o)
  else $error("a division was started over another");

  BusyFromStart : assert property (@(posedge clk_i) disable iff (!rst_ni)
      start_i |=> busy_o)
  else $error("a division does not begin");

  EighteenCycles : assert property (@(posedge clk_i) disable iff (!rst_ni)
      cycles_q != 5'd0 && !busy_o |-> cycles_q == 5'd18)
  else $error("a division that is not 18 cycles long");

  QuotientKept : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !busy_o && !start_i |=> $stable(quotient_o))
  else $error("a quotient changed");

endmodule

bind n2_div n2_div_sva u_sva (.*);
