// SPDX-License-Identifier: Apache-2.0
// profile_memory_sva: the oldest record is used up, never one that is not there.
module profile_memory_sva #(
    parameter int unsigned Axes = 5
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [Axes-1:0] abort_i,
    input logic [Axes-1:0] waiting_o,
    input logic [Axes-1:0] take_i,
    input logic [4*Axes-1:0] tail_o
);

  for (genvar i = 0; i < Axes; i++) begin : gen_axis
    NothingTakenOfNothing : assert property (@(posedge clk_i) disable iff (!rst_ni)
        take_i[i] && !abort_i[i] |-> waiting_o[i])
    else $error("a record was taken from an empty ring");

    KeptUntilTaken : assert property (@(posedge clk_i) disable iff (!rst_ni)
        !take_i[i] && !abort_i[i] |=> $stable(tail_o[4*i+:4]))
    else $error("a record went without being taken");
  end



endmodule

bind profile_memory profile_memory_sva #(
    .Axes(Axes)
) u_sva (.*);
