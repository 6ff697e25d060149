// SPDX-License-Identifier: Apache-2.0
// asip_write_schedule_sva: no write is lost: an operation joins at a place that is free. A register has one result at a
// time in the three places that decide the bypass.
module asip_write_schedule_sva #(
    parameter int unsigned Places = 10
) (
    input logic clk_i,
    input logic rst_ni,
    input logic insert_i,
    input logic [$clog2(Places)-1:0] place,
    input logic [Places-1:0] taken_o,
    input logic [4:0] valid_o,
    input asip_pkg::tag_t tag2_o,
    input asip_pkg::tag_t tag1_o,
    input asip_pkg::tag_t tag0_o
);

  logic [2:0] register;  // places that write one
  assign register = valid_o[2:0] & {!tag2_o.to_output, !tag1_o.to_output, !tag0_o.to_output};

  OneResult : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !(register[2] && register[1] && tag2_o.index == tag1_o.index) &&
      !(register[2] && register[0] && tag2_o.index == tag0_o.index) &&
      !(register[1] && register[0] && tag1_o.index == tag0_o.index))
  else $error("a register has two results at a time, and the bypass gives their OR");

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
