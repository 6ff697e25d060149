// SPDX-License-Identifier: Apache-2.0
// asip_lane_sva: a lane writes what its vector operations compute, in the cycle of the pipe's own write; an operand has
// one limit at most.
module asip_lane_sva #(
    parameter int unsigned Latency = 2
) (
    input logic clk_i,
    input logic rst_ni,
    input logic next_i,
    input logic below_r2_i,
    input logic above_r2_i,
    input logic valid,
    input logic write_q,
    input logic [Latency-1:0] vector_q
);

  OneLimit : assert property (@(posedge clk_i) !(below_r2_i && above_r2_i))
  else $error("an operand has two limits");

  Together : assert property (@(posedge clk_i) disable iff (!rst_ni)
      vector_q[Latency-2] |-> next_i)
  else $error("a lane has a result in the next cycle and the pipe writes none");

  InTime : assert property (@(posedge clk_i) disable iff (!rst_ni)
      valid == vector_q[Latency-1])
  else $error("a lane's result is not there when its write comes");

  OfVectors : assert property (@(posedge clk_i) disable iff (!rst_ni)
      write_q |-> valid)
  else $error("a lane writes without a result of its own");

endmodule

bind asip_lane asip_lane_sva #(
    .Latency(Latency)
) u_sva (.*);
