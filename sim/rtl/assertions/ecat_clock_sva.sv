// SPDX-License-Identifier: Apache-2.0
// ecat_clock_sva: time goes on in every clock, jumps only with a new offset, and follows nothing but comparisons.
module ecat_clock_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic done_i,
    input logic shift_q,
    input logic [63:0] time_o,
    input logic signed [16:0] error_q,
    input logic signed [23:0] speed_q
);

  TimeGoesOn : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni, 2) && $past(rst_ni) && !$past(done_i && shift_q, 2)
      |-> time_o - $past(time_o) >= 64'd8 && time_o - $past(time_o) <= 64'd12)
  else $error("system time stands, or jumps without a new offset");

  DifferenceIsBounded : assert property (@(posedge clk_i) disable iff (!rst_ni)
      error_q >= -17'sd32767 && error_q <= 17'sd32767)
  else $error("a comparison corrects by more than 2^15 - 1 ns");

  SpeedOfAComparison : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni, 4) && !$past(done_i) && !$past(done_i, 4) |-> $stable(speed_q))
  else $error("the speed changed without a comparison or a restart");

endmodule

bind ecat_clock ecat_clock_sva u_sva (.*);
