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

  // Indices are decoded in two halves, so that a register is five inputs.
  localparam int unsigned LowWidth = IndexWidth / 2;
  localparam int unsigned HighWidth = IndexWidth - LowWidth;

  logic [2**IndexWidth-1:0] pending_d, pending_q;
  logic [2**HighWidth-1:0] set_high, clear_high;
  logic [2**LowWidth-1:0] set_low, clear_low;

  genvar i, q;
  generate
    for (i = 0; i < 2 ** HighWidth; i++) begin : gen_high
      assign set_high[i]   = set_i && set_index_i[IndexWidth-1:LowWidth] == HighWidth'(i);
      assign clear_high[i] = clear_i && clear_index_i[IndexWidth-1:LowWidth] == HighWidth'(i);
    end
    for (i = 0; i < 2 ** LowWidth; i++) begin : gen_low
      assign set_low[i]   = set_index_i[LowWidth-1:0] == LowWidth'(i);
      assign clear_low[i] = clear_index_i[LowWidth-1:0] == LowWidth'(i);
    end
    for (i = 0; i < 2 ** IndexWidth; i++) begin : gen_register
      localparam int unsigned High = i / 2 ** LowWidth;
      localparam int unsigned Low = i % 2 ** LowWidth;
      assign pending_d[i] = (set_high[High] && set_low[Low]) || (pending_q[i] && !(clear_high[High] && clear_low[Low]));
    end
  endgenerate

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) pending_q <= '0;
    else pending_q <= pending_d;
  end

  generate
    for (q = 0; q < Queries; q++) begin : gen_query
      assign pending_o[q] = pending_q[query_i[q]];
    end
  endgenerate

endmodule
