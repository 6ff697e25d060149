// SPDX-License-Identifier: Apache-2.0
// core_bus_sva: one owner of the bus, and none loses it within an access.
module core_bus_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic host_read_i,
    input logic host_write_i,
    input logic host_wait_o,
    input logic sequencer_read_i,
    input logic sequencer_write_i,
    input logic sequencer_wait_o
);

  OneOwner : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (host_read_i || host_write_i) && (sequencer_read_i || sequencer_write_i) |->
      host_wait_o || sequencer_wait_o)
  else $error("two accesses were taken in one cycle");

  NoneLost : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (host_wait_o || host_read_i || host_write_i) &&
      (sequencer_wait_o || sequencer_read_i || sequencer_write_i))
  else $error("an access ended that nobody began");

endmodule

bind core_bus core_bus_sva u_sva (.*);

bind core_bus avalon_rules #(
    .AddressWidth(14)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    (address_o),
    .read       (read_o),
    .write      (write_o),
    .writedata  (data_o),
    .waitrequest(wait_i)
);
