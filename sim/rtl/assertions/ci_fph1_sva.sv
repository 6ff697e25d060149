// SPDX-License-Identifier: Apache-2.0
// ci_fph1_sva: done in the cycle promised, once for each start, one operation at a time.
module ci_fph1_sva (
    input logic clk_i,
    input logic reset_i,
    input logic clk_en_i,
    input logic start_i,
    input logic [1:0] n_i,
    input logic done_o,
    input logic [31:0] result_o
);

  logic       busy_q;
  logic [5:0] cycle_q, last_q;  // this cycle, from 1 at the start; that of done_o

  always_ff @(posedge clk_i or posedge reset_i) begin
    if (reset_i) begin
      busy_q  <= 1'b0;
      cycle_q <= '0;
      last_q  <= '0;
    end else if (clk_en_i) begin
      if (start_i) begin
        busy_q  <= 1'b1;
        cycle_q <= 6'd2;
        last_q  <= n_i == ci_pkg::FPGA1_N_FMUL[1:0] ? 6'(ci_pkg::FPGA1_FPH1_FMUL_CYCLES) :
                   n_i == ci_pkg::FPGA1_N_FDIV[1:0] ? 6'(ci_pkg::FPGA1_FPH1_FDIV_CYCLES) :
                                                      6'(ci_pkg::FPGA1_FPH1_FADD_CYCLES);
      end else begin
        busy_q  <= busy_q && cycle_q != last_q;
        cycle_q <= cycle_q + 6'd1;
      end
    end
  end

  OneAtATime : assert property (@(posedge clk_i) disable iff (reset_i)
      start_i && clk_en_i |-> !busy_q)
  else $error("an operation was started before the one before was done");

  DoneInTime : assert property (@(posedge clk_i) disable iff (reset_i)
      !start_i |-> done_o == (busy_q && cycle_q == last_q))
  else $error("done early, late, twice or without a start");

  NoSubnormal : assert property (@(posedge clk_i) disable iff (reset_i)
      done_o |-> result_o[30:23] != '0 || result_o[22:0] == '0)
  else $error("a result is subnormal");

endmodule

bind ci_fph1 ci_fph1_sva u_sva (.*);
