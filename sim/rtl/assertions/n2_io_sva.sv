// SPDX-License-Identifier: Apache-2.0
// n2_io_sva: the tick block's Avalon-MM agent; a tick that comes while one is pending is reported.
module n2_io_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic tick,
    input logic done,
    input logic pending_o,
    input logic overrun_o
);

  NoTickLost : assert property (@(posedge clk_i) disable iff (!rst_ni)
      tick && pending_o && !done |=> overrun_o)
  else $error("a tick was lost, and nobody told");

  OverrunStays : assert property (@(posedge clk_i) disable iff (!rst_ni) overrun_o |=> overrun_o)
  else $error("an overrun was forgotten");

endmodule

bind n2_io n2_io_sva u_sva (.*);

bind n2_io avalon_rules #(
    .AddressWidth(n2_system_pkg::IO_ADDRESS_WIDTH)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    (avs_address_i),
    .read       (avs_read_i),
    .write      (avs_write_i),
    .writedata  (avs_writedata_i),
    .waitrequest(avs_waitrequest_o)
);
