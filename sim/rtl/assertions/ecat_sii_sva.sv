// SPDX-License-Identifier: Apache-2.0
// ecat_sii_sva: a command begins when it may and ends; the image changes by an enabled write or the idle application's.
module ecat_sii_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic idle_i,
    input logic app_read_i,
    input logic app_write_i,
    input logic app_ready_o,
    input logic loaded_o,
    input logic alias_valid_o,
    input logic [15:0] alias_o,
    input logic enable_q,
    input logic checksum_error_q,
    input logic [1:0] write
);

  localparam logic [5:0] Longest = 6'd31;  // seven words of a reload with two bytes each, and the sum

  logic [5:0] clocks_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) clocks_q <= '0;
    else clocks_q <= app_ready_o ? '0 : clocks_q + 1'b1;
  end

  BeginsWhenIdle : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !app_ready_o && $past(app_ready_o) |-> $past(idle_i))
  else $error("a command began while a frame's writes are on their way");

  CommandEnds : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !app_ready_o |-> clocks_q < Longest)
  else $error("a command does not end");

  WriteIfEnabled : assert property (@(posedge clk_i) disable iff (!rst_ni)
      write != '0 && !app_ready_o |-> $past(enable_q))
  else $error("a command wrote to the image without write enable");

  AccessWhenReady : assert property (@(posedge clk_i) disable iff (!rst_ni)
      app_read_i || app_write_i |-> app_ready_o)
  else $error("the application accesses the image while a command is at work");

  AliasOfARightSum : assert property (@(posedge clk_i) disable iff (!rst_ni)
      alias_valid_o |-> app_ready_o && loaded_o && !checksum_error_q && $stable(alias_o))
  else $error("an alias of a reload that is not over or has a wrong check sum");

endmodule

bind ecat_sii ecat_sii_sva u_sva (.*);
