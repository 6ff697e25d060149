// SPDX-License-Identifier: Apache-2.0
// period_sequencer_sva: no core is started while it works, commands are complete when they change.
module period_sequencer_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic bus_read_o,
    input logic bus_write_o,
    input logic command_o,
    input logic store_o,
    input logic start_i,
    input logic late_o,
    input logic copying_o,
    input logic [1:0] overrun_o
);

  OverrunOfACore : assert property (@(posedge clk_i) disable iff (!rst_ni)
      overrun_o != 2'b00 |-> start_i)
  else $error("an overrun away from the start of a period");

  LateAtTheStart : assert property (@(posedge clk_i) disable iff (!rst_ni)
      late_o |-> start_i)
  else $error("a period was found late away from its start");

  CopyIsAnnounced : assert property (@(posedge clk_i) disable iff (!rst_ni)
      bus_read_o || bus_write_o |-> copying_o)
  else $error("the bus is used unannounced");

  OneWordOneUse : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !(command_o && store_o))
  else $error("a word became a command and a set-point");

endmodule

bind period_sequencer period_sequencer_sva u_sva (.*);

bind period_sequencer avalon_rules #(
    .AddressWidth(15)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    ({bus_core_o, bus_address_o}),
    .read       (bus_read_o),
    .write      (bus_write_o),
    .writedata  (bus_data_o),
    .waitrequest(bus_wait_i)
);
