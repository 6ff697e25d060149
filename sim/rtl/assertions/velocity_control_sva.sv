// SPDX-License-Identifier: Apache-2.0
// velocity_control_sva: a record is used up once, by one axis, where one waits; an abort stops at once.
module velocity_control_sva #(
    parameter int unsigned Axes = 5
) (
    input logic clk_i,
    input logic rst_ni,
    input logic tick_i,
    input logic [Axes-1:0] abort_i,
    input logic [Axes-1:0] take_o,
    input logic [Axes-1:0] running_o,
    input logic [Axes-1:0] underrun_o,
    input logic [Axes-1:0] waiting_i,
    input logic [32*Axes-1:0] rate_o
);

  localparam logic [7:0] APART = 8'(8 * Axes + 8);  // ticks, at least
  logic [7:0] since_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) since_q <= APART;
    else if (tick_i) since_q <= 8'd1;
    else if (since_q != APART) since_q <= since_q + 8'd1;
  end

  for (genvar i = 0; i < Axes; i++) begin : gen_axis
    AbortStops : assert property (@(posedge clk_i) disable iff (!rst_ni)
        abort_i[i] |=> !running_o[i] && !underrun_o[i] && rate_o[32*i+:32] == '0)
    else $error("an axis went on after an abort");
  end

  TicksApart : assert property (@(posedge clk_i) disable iff (!rst_ni)
      tick_i |-> since_q == APART)
  else $error("ticks closer than the round of all axes");

  OneRecord : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $onehot0(take_o))
  else $error("two axes took a record in one clock");

  RecordWaits : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (take_o & ~waiting_i & ~abort_i) == '0)
  else $error("a record was taken that is not there");

endmodule

bind velocity_control velocity_control_sva #(
    .Axes(Axes)
) u_sva (.*);
