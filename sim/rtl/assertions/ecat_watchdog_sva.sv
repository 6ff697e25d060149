// SPDX-License-Identifier: Apache-2.0
// ecat_watchdog_sva: a watchdog runs out its time after the last trigger, once, and lives from the next one on.
module ecat_watchdog_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic [15:0] divider_q,
    input logic unit,
    input logic [15:0] data_time,
    input logic data_trigger_i,
    input logic application_trigger_i,
    input logic expired_o,
    input logic application_alive_o
);

  logic        running_q, last_q, timed_q;
  logic [15:0] time_q, units_q;         // at the last trigger; units since
  logic [18:0] clocks_q, unit_clocks;   // since the last unit
  logic [15:0] divider_last_q;

  assign unit_clocks = {17'(divider_q) + 17'd2, 2'b00};
  assign last_q      = unit && units_q + 1'b1 == time_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      running_q      <= 1'b0;
      time_q         <= '0;
      units_q        <= '0;
      clocks_q       <= 19'd1;
      timed_q        <= 1'b0;
      divider_last_q <= '0;
    end else begin
      divider_last_q <= divider_q;
      clocks_q       <= unit ? 19'd1 : clocks_q + 19'd1;
      timed_q        <= divider_q == divider_last_q && (unit || timed_q);
      if (data_time == '0 || (expired_o && !data_trigger_i)) begin
        running_q <= 1'b0;
      end else if (data_trigger_i) begin
        running_q <= 1'b1;
        time_q    <= data_time;
        units_q   <= '0;
      end else if (unit) begin
        units_q <= units_q + 1'b1;
      end
    end
  end

  RunsOutInTime : assert property (@(posedge clk_i) disable iff (!rst_ni)
      expired_o == (running_q && last_q && !data_trigger_i))
  else $error("a watchdog runs out early, late, twice or without a trigger");

  UnitLength : assert property (@(posedge clk_i) disable iff (!rst_ni)
      timed_q && unit |-> clocks_q == unit_clocks)
  else $error("a unit is not WATCHDOG_DIVIDER + 2 times 40 ns");

  UnitEnds : assert property (@(posedge clk_i) disable iff (!rst_ni)
      timed_q |-> clocks_q <= unit_clocks)
  else $error("a unit does not end");

  TriggerRevives : assert property (@(posedge clk_i) disable iff (!rst_ni)
      application_trigger_i |=> application_alive_o)
  else $error("an application is dead behind its access");

endmodule

bind ecat_watchdog ecat_watchdog_sva u_sva (
    .data_time(gen_watchdog[0].time_q),
    .*
);
