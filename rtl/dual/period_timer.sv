// SPDX-License-Identifier: Apache-2.0
// period_timer: marks the first clock of every period.
// Contract: the first period starts in the clock after run_i rises, the next ones clocks_i clocks apart
// (1..65535; 0 counts as 65536), taken in the first clock of each. elapsed_o counts from 0 in the first clock;
// clocks_o is the length of the period under way, in its first clock still that of the one before. Without
// run_i that one is counted to its end, where elapsed_o stays at clocks_o.
module period_timer (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        run_i,
    input  logic [15:0] clocks_i,
    output logic        start_o,
    output logic [15:0] elapsed_o,
    output logic [15:0] clocks_o
);

  logic run_q;
  logic [15:0] count_q, clocks_q;
  logic last;

  assign last = count_q == (count_q == 16'd0 ? clocks_i : clocks_q) - 16'd1;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      run_q    <= 1'b0;
      count_q  <= 16'd0;
      clocks_q <= 16'd0;
    end else begin
      run_q <= run_i;
      if (run_i && (!run_q || last)) count_q <= 16'd0;
      else if (start_o || count_q != clocks_q) count_q <= count_q + 16'd1;
      if (start_o) clocks_q <= clocks_i;
    end
  end

  assign start_o   = run_q && count_q == 16'd0;
  assign elapsed_o = count_q;
  assign clocks_o  = clocks_q;

endmodule
