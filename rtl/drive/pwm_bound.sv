// SPDX-License-Identifier: Apache-2.0
// pwm_bound: bounds compare values so that no state of a half bridge is ordered for a moment only.
// Contract: a clock after value_i, value_o is 0 for values below minimum_i, half_i for those above
// half_i - minimum_i, else the value. Each half period then has no part or one of minimum_i clocks at
// least, on and off, as long as minimum_i is at most half of half_i; beyond that values are 0 or half_i.
module pwm_bound #(
    parameter int unsigned Width = 12
) (
    input  logic             clk_i,
    input  logic             rst_ni,
    input  logic [Width-1:0] half_i,
    input  logic [Width-1:0] minimum_i,
    input  logic [Width-1:0] value_i,
    output logic [Width-1:0] value_o
);

  logic [Width-1:0] most_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      most_q  <= '0;
      value_o <= '0;
    end else begin
      most_q <= (half_i < minimum_i) ? '0 : half_i - minimum_i;
      if (value_i < minimum_i) value_o <= '0;
      else value_o <= (value_i > most_q) ? half_i : value_i;
    end
  end

endmodule
