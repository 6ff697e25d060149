// SPDX-License-Identifier: Apache-2.0
// dual_host_sva: an access goes to one core, or to the system's own registers.
module dual_host_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic read_i,
    input logic write_i,
    input logic [1:0] core_read_o,
    input logic [1:0] core_write_o
);

  OneCore : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $onehot0({core_read_o, core_write_o}))
  else $error("an access reached both cores");

  OnlyIfAsked : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (core_read_o == '0 || read_i) && (core_write_o == '0 || write_i))
  else $error("an access to a core that nobody asked for");

endmodule

bind dual_host dual_host_sva u_sva (.*);
