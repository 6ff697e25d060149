// SPDX-License-Identifier: Apache-2.0
// asip_operands_sva: the host writes registers and constants through ports that no result needs.
module asip_operands_sva (
    input logic       clk_i,
    input logic [2:0] write_i,
    input logic       host_write_i,
    input logic       host_write_constant_i
);

  HostIdle : assert property (@(posedge clk_i)
      host_write_i || host_write_constant_i |-> write_i == 3'b000)
  else $error("the host and a result write in the same cycle, one of them is lost");

endmodule

bind asip_operands asip_operands_sva u_sva (.*);
