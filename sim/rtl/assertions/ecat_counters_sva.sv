// SPDX-License-Identifier: Apache-2.0
// ecat_counters_sva: a counter goes up by what it counts, stops at 255 and falls only to 0, by a write.
module ecat_counters_sva #(
    parameter int unsigned N = 10
) (
    input logic clk_i,
    input logic rst_ni,
    input ecat_pkg::register_access_t register_i,
    input logic [N-1:0] count_i,
    input logic [8*N-1:0] counters
);

  for (genvar n = 0; n < N; n++) begin : gen_counter
    logic [7:0] before_q;
    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) before_q <= '0;
      else before_q <= counters[8*n+:8];
    end

    CountsByOne : assert property (@(posedge clk_i) disable iff (!rst_ni)
        counters[8*n+:8] > before_q |-> $past(count_i[n]) && counters[8*n+:8] == before_q + 8'd1)
    else $error("a counter went up without its event or by more than one");

    FallsByAWrite : assert property (@(posedge clk_i) disable iff (!rst_ni)
        counters[8*n+:8] < before_q |-> counters[8*n+:8] == '0 && $past(register_i.write))
    else $error("a counter ran over or fell by itself");

    EveryEventCounts : assert property (@(posedge clk_i) disable iff (!rst_ni)
        count_i[n] && !register_i.write && counters[8*n+:8] != '1 |=> counters[8*n+:8] == before_q + 8'd1)
    else $error("an event was not counted");
  end

  PairIsCleared : assert property (@(posedge clk_i) disable iff (!rst_ni)
      register_i.write && register_i.address[11:1] == esc_regmap_pkg::REG_INVALID_FRAMES_0[11:1]
      |=> counters[15:0] == '0)
  else $error("a write cleared one of a port's two counters");

endmodule

bind ecat_counters ecat_counters_sva #(
    .N(N)
) u_sva (.*);
