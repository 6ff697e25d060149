// SPDX-License-Identifier: Apache-2.0
// asip_units_sva: an exception of a run stays until the next run clears it; the host writes between runs.
module asip_units_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_flags_i,
    input logic valid_e1_i,
    input logic host_select_i,
    input logic host_write_i,
    input logic [4:0] flags_o
);

  ExceptionStays : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !clear_flags_i |=> ($past(flags_o) & ~flags_o) == '0)
  else $error("an exception was forgotten within a run");

  ClearClears : assert property (@(posedge clk_i) disable iff (!rst_ni)
      clear_flags_i |=> flags_o == '0)
  else $error("an exception of the run before is there after the clear");

  HostBetweenRuns : assert property (@(posedge clk_i) disable iff (!rst_ni)
      host_select_i && host_write_i |-> !valid_e1_i)
  else $error("the host writes while an operation enters a unit");

endmodule

bind asip_units asip_units_sva u_sva (.*);
