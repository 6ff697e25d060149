// SPDX-License-Identifier: Apache-2.0
// asip_scoreboard: which registers of one bank have a write in flight.
// Contract: a register set in cycle t reads as pending from t+1; cleared in cycle t, from t+1 not any
// more. The issue logic never sets a register that is pending. Combinational queries.
module asip_scoreboard #(
    parameter int unsigned IndexWidth = 6,
    parameter int unsigned Queries    = 10
) (
    input  logic                               clk_i,
    input  logic                               rst_ni,
    input  logic                               set_i,
    input  logic [IndexWidth-1:0]              set_index_i,
    input  logic                               clear_i,
    input  logic [IndexWidth-1:0]              clear_index_i,
    input  logic [Queries-1:0][IndexWidth-1:0] query_i,
    output logic [Queries-1:0]                 pending_o
);

  logic [2**IndexWidth-1:0] pending_d, pending_q;

  always_comb begin
    pending_d = pending_q;
    if (clear_i) pending_d[clear_index_i] = 1'b0;
    if (set_i) pending_d[set_index_i] = 1'b1;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) pending_q <= '0;
    else pending_q <= pending_d;
  end

  for (genvar q = 0; q < Queries; q++) begin : gen_query
    assign pending_o[q] = pending_q[query_i[q]];
  end

endmodule
