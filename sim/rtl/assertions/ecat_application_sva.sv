// SPDX-License-Identifier: Apache-2.0
// ecat_application_sva: a byte at a time, only while the access is there.
module ecat_application_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic avs_read_i,
    input logic avs_write_i,
    input logic avs_waitrequest_o,
    input logic valid_o,
    input logic sii_read_o,
    input logic sii_write_o
);

  OnlyWhenAsked : assert property (@(posedge clk_i) disable iff (!rst_ni)
      valid_o || sii_read_o || sii_write_o |-> avs_read_i || avs_write_i)
  else $error("an access that nobody asked for");

  OneTarget : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !(valid_o && (sii_read_o || sii_write_o)))
  else $error("controller and SII at once");

  AnswersOnce : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !avs_waitrequest_o |=> avs_waitrequest_o)
  else $error("two answers");

endmodule

bind ecat_application ecat_application_sva u_sva (.*);

bind ecat_application avalon_rules #(
    .AddressWidth(18)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    ({avs_byteenable_i, avs_address_i}),
    .read       (avs_read_i),
    .write      (avs_write_i),
    .writedata  (avs_writedata_i),
    .waitrequest(avs_waitrequest_o)
);
