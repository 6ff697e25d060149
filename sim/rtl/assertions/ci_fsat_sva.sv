// SPDX-License-Identifier: Apache-2.0
// ci_fsat_sva: operands are held for three cycles; a value limited to -|b| .. |b| lies there.
module ci_fsat_sva (
    input logic clk_i,
    input logic reset_i,
    input logic clk_en_i,
    input logic start_i,
    input logic [31:0] dataa_i,
    input logic [31:0] datab_i,
    input logic readra_i,
    input logic readrb_i,
    input logic writerc_i,
    input logic [31:0] result_o
);

  logic [1:0] begun_q;  // bit n: an instruction was started n + 1 clocks ago
  always_ff @(posedge clk_i or posedge reset_i) begin
    if (reset_i) begun_q <= '0;
    else begun_q <= {begun_q[0], start_i && clk_en_i};
  end

  OperandsHeld : assert property (@(posedge clk_i) disable iff (reset_i)
      begun_q != '0 |-> $stable({dataa_i, datab_i, readra_i, readrb_i, writerc_i}))
  else $error("operands changed within the three cycles");

  WithinBounds : assert property (@(posedge clk_i) disable iff (reset_i)
      begun_q[1] && writerc_i && readra_i && readrb_i
      |-> result_o == fp_pkg::CANON_NAN || result_o[30:0] <= datab_i[30:0])
  else $error("a limited value lies beyond its bound");

  WriteGivesZero : assert property (@(posedge clk_i) disable iff (reset_i)
      begun_q[1] && !writerc_i |-> result_o == '0)
  else $error("an instruction without a result has one");

endmodule

bind ci_fsat ci_fsat_sva u_sva (.*);
