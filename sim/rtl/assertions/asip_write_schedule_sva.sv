// SPDX-License-Identifier: Apache-2.0
// asip_write_schedule_sva: no write is lost: an operation joins at a place that is free.
module asip_write_schedule_sva #(
    parameter int unsigned Places = 10
) (
    input logic clk_i,
    input logic rst_ni,
    input logic insert_i,
    input logic [$clog2(Places)-1:0] place,
    input logic [Places-1:0] taken_o
);

  PlaceIsFree : assert property (@(posedge clk_i) disable iff (!rst_ni)
      insert_i |-> !taken_o[place])
  else $error("two writes of a bank in the same cycle, one of them lost");

  PlaceExists : assert property (@(posedge clk_i) disable iff (!rst_ni)
      insert_i |-> 32'(place) < Places)
  else $error("a write beyond the schedule");

endmodule

bind asip_write_schedule asip_write_schedule_sva #(
    .Places(Places)
) u_sva (.*);
