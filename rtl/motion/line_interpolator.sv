// SPDX-License-Identifier: Apache-2.0
// line_interpolator: integer steps along a straight line in a plane, decided by the sign of the line's
// equation at the centre of the grid square being crossed (half-step extrapolation).
// Contract: start_i takes the end relative to the start; every advance_i with active_o gives
// one step on step_o/negative_o {v, u} in the same clock. Elementary steps move one axis, |u| + |v| of
// them, each node within 1/2 step per axis of the ideal point; combined ones move the longer axis
// always, max(|u|, |v|) of them, within 1/2 step of the line. A line to itself is over at once.
module line_interpolator #(
    parameter int unsigned Width = 24
) (
    input  logic                    clk_i,
    input  logic                    rst_ni,
    input  logic                    flush_i,    // drop the job
    input  logic                    start_i,
    input  logic                    combined_i,
    input  logic signed [Width-1:0] end_u_i,    // above -2^(Width-1)
    input  logic signed [Width-1:0] end_v_i,
    input  logic                    advance_i,
    output logic                    active_o,
    output logic [1:0]              step_o,
    output logic [1:0]              negative_o
);

  // With A >= B the lengths of the longer and the shorter axis:
  //   elementary: E = A - B;  E > 0: longer, E -= 2B;  else shorter, E += 2A;  A + B steps
  //   combined:   E = 2B - A; E >= 0: both, E += 2B - 2A;  else longer, E += 2B;  A steps
  // (E is twice the value of the line's equation at the extrapolated point.)
  logic [Width-1:0] size_u, size_v, long_q, short_q;
  logic signed [Width+1:0] error_q, change;
  logic [Width:0] left_q;
  logic [1:0] negative_q;
  logic combined_q, swapped_q, swap, turn, move_long, move_short;

  assign size_u = end_u_i[Width-1] ? -end_u_i : end_u_i;
  assign size_v = end_v_i[Width-1] ? -end_v_i : end_v_i;
  assign swap   = size_v > size_u;

  // The elementary rule treats u and v unlike at E = 0, so it does not swap.
  assign turn       = combined_q ? !error_q[Width+1] : !error_q[Width+1] && error_q != '0;
  assign move_long  = combined_q || turn;
  assign move_short = combined_q ? turn : !turn;

  always_comb begin
    change = '0;
    if (combined_q || turn)
      change = change + (combined_q ? $signed({1'b0, short_q, 1'b0}) : -$signed({1'b0, short_q, 1'b0}));
    if (combined_q ? turn : !turn)
      change = change + (combined_q ? -$signed({1'b0, long_q, 1'b0}) : $signed({1'b0, long_q, 1'b0}));
  end

  always_ff @(posedge clk_i) begin
    if (start_i) begin
      combined_q <= combined_i;
      swapped_q  <= combined_i && swap;
      long_q     <= (combined_i && swap) ? size_v : size_u;
      short_q    <= (combined_i && swap) ? size_u : size_v;
      negative_q <= {end_v_i[Width-1], end_u_i[Width-1]};
      if (!combined_i) error_q <= $signed({2'b00, size_u}) - $signed({2'b00, size_v});
      else if (swap) error_q <= $signed({1'b0, size_u, 1'b0}) - $signed({2'b00, size_v});
      else error_q <= $signed({1'b0, size_v, 1'b0}) - $signed({2'b00, size_u});
    end else if (advance_i && active_o) begin
      error_q <= error_q + change;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) left_q <= '0;
    else if (flush_i) left_q <= '0;
    else if (start_i) begin
      if (!combined_i) left_q <= {1'b0, size_u} + {1'b0, size_v};
      else left_q <= {1'b0, swap ? size_v : size_u};
    end else if (advance_i && active_o) left_q <= left_q - 1'b1;
  end

  assign active_o   = left_q != '0;
  assign step_o     = active_o ? (swapped_q ? {move_long, move_short} : {move_short, move_long})
                               : 2'b00;
  assign negative_o = negative_q;

endmodule
