// SPDX-License-Identifier: Apache-2.0
// index_check: the index of an encoder must come where the counts say, and must not be missing.
// Contract: the first index of axis n after a clear is its reference. Each later index must be at the
// reference or at distance_i from it, either way, within tolerance_i counts; the reference then moves by
// distance_i, so errors add up. lost_o[n] is set if an index is elsewhere, or if a position is further from the
// reference (before an index: from where it was cleared) than distance_i + tolerance_i, and stays until
// clear_i[n]. Of each axis the last index or the position is looked at once in 4 Axes clocks; lost_o follows
// 4 Axes + 4 clocks after an index at most. distance_i 0: never. Positions count modulo 2^24: distance_i is
// at most 2^22, tolerance_i below half of it.
module index_check #(
    parameter int unsigned Axes = 5  // 1..8
) (
    input  logic               clk_i,
    input  logic               rst_ni,
    // quadrature_decoder, of each axis
    input  logic [32*Axes-1:0] position_i,
    input  logic [32*Axes-1:0] index_position_i,
    input  logic [Axes-1:0]    passes_i,          // index_position_i changes with this clock's end
    // registers
    input  logic [24*Axes-1:0] distance_i,
    input  logic [8*Axes-1:0]  tolerance_i,
    input  logic [Axes-1:0]    clear_i,
    output logic [Axes-1:0]    lost_o
);

  localparam int unsigned Width = 24;
  localparam logic [2:0] LastAxis = 3'(Axes - 1);

  logic [2:0] axis_q;
  logic [3:0] step_q;  // one of four clocks of an axis
  logic [Axes-1:0] pending_q, fresh_q, seen_q;
  logic [Width*Axes-1:0] reference_q;
  logic [Width-1:0] at, from, distance, at_q, from_q, distance_q, apart, size_q, next_q;
  logic signed [Width:0] beyond_q;
  logic [7:0] tolerance, tolerance_q;
  logic signed [Width:0] spare;
  logic pending, pending_now_q, fresh, seen, is_same_q, is_next, is_far;

  always_comb begin
    at        = '0;
    from      = '0;
    distance  = '0;
    tolerance = '0;
    pending   = 1'b0;
    fresh     = 1'b0;
    seen      = 1'b0;
    for (int unsigned i = 0; i < Axes; i++)
    if (axis_q == 3'(i)) begin
      at        = pending_q[i] ? index_position_i[32*i+:Width] : position_i[32*i+:Width];
      from      = reference_q[Width*i+:Width];
      distance  = distance_i[24*i+:24];
      tolerance = tolerance_i[8*i+:8];
      pending   = pending_q[i];
      fresh     = fresh_q[i];
      seen      = seen_q[i];
    end
  end

  assign apart   = at_q - from_q;
  assign spare   = $signed({17'd0, tolerance_q});
  assign is_next = beyond_q <= spare && beyond_q >= -spare;
  assign is_far  = beyond_q > spare;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      step_q <= 4'd1;
      axis_q <= '0;
    end else begin
      step_q <= {step_q[2:0], step_q[3]};
      if (step_q[3]) axis_q <= (axis_q == LastAxis) ? '0 : axis_q + 3'd1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (step_q[0]) begin
      at_q          <= at;
      from_q        <= from;
      distance_q    <= distance;
      tolerance_q   <= tolerance;
      pending_now_q <= pending;
    end
    size_q    <= apart[Width-1] ? -apart : apart;
    next_q    <= apart[Width-1] ? from_q - distance_q : from_q + distance_q;
    beyond_q  <= $signed({1'b0, size_q}) - $signed({1'b0, distance_q});
    is_same_q <= size_q <= Width'(tolerance_q);
  end

  genvar n;
  generate
    for (n = 0; n < Axes; n++) begin : gen_axis
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) begin
          pending_q[n]                 <= 1'b0;
          fresh_q[n]                   <= 1'b1;
          seen_q[n]                    <= 1'b0;
          lost_o[n]                    <= 1'b0;
          reference_q[Width*n+:Width] <= '0;
        end else if (clear_i[n] || distance_i[24*n+:24] == '0) begin
          pending_q[n] <= 1'b0;
          fresh_q[n]   <= 1'b1;
          seen_q[n]    <= 1'b0;
          if (clear_i[n]) lost_o[n] <= 1'b0;
        end else begin
          pending_q[n] <= passes_i[n] || (pending_q[n] && !(step_q[0] && axis_q == 3'(n)));
          if (step_q[3] && axis_q == 3'(n)) begin
            if (fresh || (pending_now_q && !seen)) begin
              reference_q[Width*n+:Width] <= at_q;
              fresh_q[n]                  <= 1'b0;
              seen_q[n]                   <= pending_now_q;
            end else if (pending_now_q && !is_same_q) begin
              if (is_next) reference_q[Width*n+:Width] <= next_q;
              else lost_o[n] <= 1'b1;
            end else if (!pending_now_q && is_far) lost_o[n] <= 1'b1;
          end
        end
      end
    end
  endgenerate

endmodule
