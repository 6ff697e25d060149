// SPDX-License-Identifier: Apache-2.0
// ci_slaves_sva: multicycle group: one operation at a time, operands held until done, done once.
module ci_slaves_sva (
    input logic        clk_i,
    input logic        rst_ni,
    input logic        enable,
    input logic        start,
    input logic        done,
    input logic [31:0] dataa,
    input logic [31:0] datab,
    input logic [7:0]  n
);

  logic busy_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) busy_q <= 1'b0;
    else if (enable) busy_q <= (start || busy_q) && !done;
  end

  OneAtATime : assert property (@(posedge clk_i) disable iff (!rst_ni) start && enable |-> !busy_q)
  else $error("an operation was started before the one before was done");

  DoneOfAnOperation : assert property (@(posedge clk_i) disable iff (!rst_ni)
      done && enable |-> start || busy_q)
  else $error("done without an operation");

  OperandsHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      busy_q |-> $stable({dataa, datab, n}))
  else $error("the operands changed before the operation was done");

endmodule

bind ci_slaves ci_slaves_sva u_sva (
    .clk_i (multi_clk_i),
    .rst_ni(!multi_reset_i),
    .enable(multi_clk_en_i),
    .start (multi_start_i),
    .done  (multi_done_o),
    .dataa (multi_dataa_i),
    .datab (multi_datab_i),
    .n     (multi_n_i)
);
