// SPDX-License-Identifier: Apache-2.0
// n2_lsu_sva: a transfer is requested once and A waits for its end; misaligned ones touch no memory.
module n2_lsu_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic wait_a_o,
    input logic avm_read_o,
    input logic avm_write_o,
    input logic [3:0] itcm_we_o,
    input logic [3:0] dtcm_we_o,
    input logic itcm_en_o,
    input logic dtcm_en_o
);

  WaitsForTheBus : assert property (@(posedge clk_i) disable iff (!rst_ni)
      avm_read_o || avm_write_o |-> wait_a_o)
  else $error("the core goes on within a transfer");

  OneMemory : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !(itcm_en_o && itcm_we_o != '0 && dtcm_en_o && dtcm_we_o != '0))
  else $error("one store in two memories");

endmodule

bind n2_lsu n2_lsu_sva u_sva (.*);
