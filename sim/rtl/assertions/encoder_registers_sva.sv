// SPDX-License-Identifier: Apache-2.0
// encoder_registers_sva: a read takes two clocks, a write one.
module encoder_registers_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic read_i,
    input logic waitrequest_o
);

  ReadInTwoClocks : assert property (@(posedge clk_i) disable iff (!rst_ni)
      waitrequest_o |=> !waitrequest_o)
  else $error("a read takes more than two clocks");

  OnlyReadsWait : assert property (@(posedge clk_i) disable iff (!rst_ni) waitrequest_o |-> read_i)
  else $error("a write waits");

endmodule

bind encoder_registers encoder_registers_sva u_sva (.*);

bind encoder_registers avalon_rules #(
    .AddressWidth(5)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    (address_i),
    .read       (read_i),
    .write      (write_i),
    .writedata  ('0),  // it has none
    .waitrequest(waitrequest_o)
);
