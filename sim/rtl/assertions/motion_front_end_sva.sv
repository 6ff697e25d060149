// SPDX-License-Identifier: Apache-2.0
// motion_front_end_sva: the front-end's Avalon-MM port; writes take one cycle, reads two.
module motion_front_end_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic read_i,
    input logic write_i,
    input logic waitrequest_o
);

  WriteInOneCycle : assert property (@(posedge clk_i) disable iff (!rst_ni) write_i |-> !waitrequest_o)
  else $error("a write waited");

  ReadInTwoCycles : assert property (@(posedge clk_i) disable iff (!rst_ni)
      read_i && waitrequest_o |=> !waitrequest_o)
  else $error("a read took more than two cycles");

endmodule

bind motion_front_end motion_front_end_sva u_sva (.*);

bind motion_front_end avalon_rules #(
    .AddressWidth(motion_regmap_pkg::ADDRESS_WIDTH)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    (address_i),
    .read       (read_i),
    .write      (write_i),
    .writedata  (writedata_i),
    .waitrequest(waitrequest_o)
);
