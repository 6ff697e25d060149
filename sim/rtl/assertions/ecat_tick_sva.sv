// SPDX-License-Identifier: Apache-2.0
// ecat_tick_sva: whatever SYNC0 does, two ticks are Period clocks apart, Slew more or less.
module ecat_tick_sva #(
    parameter int unsigned Period = 10000,
    parameter int unsigned Slew   = 8
) (
    input logic clk_i,
    input logic rst_ni,
    input logic run_i,
    input logic tick_o
);

  logic [31:0] since_q;  // clocks since the last tick, or since run_i

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) since_q <= '0;
    else since_q <= !run_i || tick_o ? '0 : since_q + 1'b1;
  end

  NotEarly : assert property (@(posedge clk_i) disable iff (!rst_ni)
      tick_o |-> since_q >= 32'(Period - Slew - 1))
  else $error("a tick comes too early");

  NotLate : assert property (@(posedge clk_i) disable iff (!rst_ni)
      run_i |-> since_q < 32'(Period + Slew))
  else $error("a tick comes too late");

  TicksOfARun : assert property (@(posedge clk_i) disable iff (!rst_ni)
      tick_o |-> run_i)
  else $error("a tick while the application does not run");

endmodule

bind ecat_tick ecat_tick_sva #(
    .Period(Period),
    .Slew  (Slew)
) u_sva (.*);
