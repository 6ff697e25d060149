// SPDX-License-Identifier: Apache-2.0
// debug_bus_slice_sva: what was requested reaches the agent, once, and ends after it.
module debug_bus_slice_sva #(
    parameter int unsigned AddressWidth = 14
) (
    input logic        clk_i,
    input logic        rst_ni,
    input logic        read_i,
    input logic        write_i,
    input logic [AddressWidth-1:0] address_i,
    input logic [31:0] writedata_i,
    input logic        waitrequest_o,
    input logic        far_read_o,
    input logic        far_write_o,
    input logic [AddressWidth-1:0] far_address_o,
    input logic [31:0] far_writedata_o,
    input logic        far_wait_i
);

  AsAskedFor : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $rose(far_read_o || far_write_o) |->
      far_read_o == $past(read_i) && far_write_o == $past(write_i) &&
      far_address_o == $past(address_i) && far_writedata_o == $past(writedata_i))
  else $error("the agent was asked for something else");

  EndsBehindTheAgent : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !waitrequest_o |-> $past((far_read_o || far_write_o) && !far_wait_i))
  else $error("an access ended that the agent had not done");

  Once : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (far_read_o || far_write_o) && !far_wait_i |=>
      !far_read_o && !far_write_o && !waitrequest_o)
  else $error("the agent was asked twice, or the end of an access was lost");

endmodule

bind debug_bus_slice debug_bus_slice_sva #(
    .AddressWidth(AddressWidth)
) u_sva (.*);

bind debug_bus_slice avalon_rules #(
    .AddressWidth(AddressWidth)
) u_near (
    .clk_i,
    .rst_ni,
    .address    (address_i),
    .read       (read_i),
    .write      (write_i),
    .writedata  (writedata_i),
    .waitrequest(waitrequest_o)
);

bind debug_bus_slice avalon_rules #(
    .AddressWidth(AddressWidth)
) u_far (
    .clk_i,
    .rst_ni,
    .address    (far_address_o),
    .read       (far_read_o),
    .write      (far_write_o),
    .writedata  (far_writedata_o),
    .waitrequest(far_wait_i)
);
