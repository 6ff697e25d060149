// SPDX-License-Identifier: Apache-2.0
// drive_front_end_sva: a processor that is late or at fault takes the gates of every axis away.
module drive_front_end_sva #(
    parameter int unsigned Axes = 5
) (
    input logic clk_i,
    input logic rst_ni,
    input logic late_q,
    input logic fault_q,
    input logic under_q,
    input logic stop_q,
    input logic bus_over_q,
    input logic [Axes-1:0] release_o,
    input logic read_i,
    input logic waitrequest_o,
    input logic [3*Axes-1:0] high_o,
    input logic [3*Axes-1:0] low_o
);

  logic [1:0] without_q;  // one, two clocks ago

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) without_q <= '0;
    else without_q <= {without_q[0], late_q || fault_q || under_q || bus_over_q || stop_q};
  end

  NoGateWithoutTheProcessor : assert property (@(posedge clk_i) disable iff (!rst_ni)
      without_q[1] |-> high_o == '0 && low_o == '0)
  else $error("a gate is on though the processor is late or at fault");

  BrakeClosesWithATrip : assert property (@(posedge clk_i) disable iff (!rst_ni)
      without_q[1] |-> release_o == '0)
  else $error("a brake is open though the axis has no gates");

  ReadInTwoClocks : assert property (@(posedge clk_i) disable iff (!rst_ni)
      read_i && waitrequest_o |=> !waitrequest_o)
  else $error("a read takes more than two clocks");

endmodule

bind drive_front_end drive_front_end_sva #(
    .Axes(Axes)
) u_sva (.*);

bind drive_front_end avalon_rules #(
    .AddressWidth(drive_regmap_pkg::ADDRESS_WIDTH)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    (address_i),
    .read       (read_i),
    .write      (write_i),
    .writedata  (writedata_i),
    .waitrequest(waitrequest_o)
);
