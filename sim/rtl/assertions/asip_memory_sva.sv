// SPDX-License-Identifier: Apache-2.0
// asip_memory_sva: one access per cycle; an address outside the memory faults and does nothing.
module asip_memory_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic load_i,
    input logic store_i,
    input logic host_select_i,
    input logic fault_e2_o,
    input logic write_e2,
    input logic valid_o
);

  OneAccess : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !(load_i && store_i))
  else $error("a load and a store in one cycle");

  HostIdle : assert property (@(posedge clk_i) disable iff (!rst_ni)
      host_select_i |-> !load_i && !store_i)
  else $error("the host takes the memory from a run");

  FaultWritesNothing : assert property (@(posedge clk_i) disable iff (!rst_ni)
      fault_e2_o |-> !write_e2)
  else $error("an access outside the memory wrote");

  ResultOfALoad : assert property (@(posedge clk_i) disable iff (!rst_ni)
      valid_o |-> $past(load_i, 3))
  else $error("a load's result without a load");

endmodule

bind asip_memory asip_memory_sva u_sva (.*);
