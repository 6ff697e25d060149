// SPDX-License-Identifier: Apache-2.0
// asip_operands_multiple_sva: a page of the registers is copied, and a word of the host written, while no result is.
module asip_operands_multiple_sva (
    input logic       clk_i,
    input logic       copy,
    input logic [3:0] host_strobe,
    input logic [2:0] write_i
);

  CopyAlone : assert property (@(posedge clk_i) copy |-> write_i == 3'b000)
  else $error("a result is written while its page is copied, and is lost");

  HostAlone : assert property (@(posedge clk_i) host_strobe != 4'd0 |-> write_i == 3'b000)
  else $error("a word of the host and a result go to a bank in the same cycle, one is lost");

endmodule

bind asip_operands_multiple asip_operands_multiple_sva u_sva (
    .clk_i,
    .copy(guard_i.copy),
    .host_strobe,
    .write_i
);
