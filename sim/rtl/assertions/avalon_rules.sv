// SPDX-License-Identifier: Apache-2.0
// avalon_rules: both sides of one Avalon-MM connection (Avalon Interface Specifications, section 3.5).
// A host holds its request, unchanged, while waitrequest is high, and never asks for two things at once.
module avalon_rules #(
    parameter int unsigned AddressWidth = 1
) (
    input logic                    clk_i,
    input logic                    rst_ni,
    input logic [AddressWidth-1:0] address,
    input logic                    read,
    input logic                    write,
    input logic [31:0]             writedata,
    input logic                    waitrequest
);

  OneRequest : assert property (@(posedge clk_i) disable iff (!rst_ni) !(read && write))
  else $error("read and write at once");

  ReadHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      read && waitrequest |=> read && $stable(address))
  else $error("a read was withdrawn or changed before it was taken");

  WriteHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      write && waitrequest |=> write && $stable(address) && $stable(writedata))
  else $error("a write was withdrawn or changed before it was taken");

endmodule
