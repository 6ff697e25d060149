// SPDX-License-Identifier: Apache-2.0
// pwm_bound_sva: no value leaves a part of a half period shorter than the minimum.
module pwm_bound_sva #(
    parameter int unsigned Width = 12
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [Width-1:0] half_i,
    input logic [Width-1:0] minimum_i,
    input logic [Width-1:0] value_o
);

  NoMoment : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni, 2) && $stable(half_i) && $past(half_i) == $past(half_i, 2) && $stable(minimum_i)
      && $past(minimum_i) == $past(minimum_i, 2)
      |-> value_o == '0 || value_o == half_i
          || (value_o >= minimum_i && {1'b0, value_o} + {1'b0, minimum_i} <= {1'b0, half_i}))
  else $error("a state would be ordered for less than the minimum");

endmodule

bind pwm_bound pwm_bound_sva #(
    .Width(Width)
) u_sva (.*);
