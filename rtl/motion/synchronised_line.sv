// SPDX-License-Identifier: Apache-2.0
// synchronised_line: a straight line in up to eight axes, one step of the longest axis at a time.
// Contract: start_i while not active_o takes the signed lengths; every advance_i with ready_o gives one
// combined step in the same clock: the longest axis moves, each other one when it is half a step after,
// so that all stay within 1/2 step of the ideal line. ready_o comes 2*Axes + 1 clocks after start_i. A
// line of length 0 is over without.
module synchronised_line #(
    parameter int unsigned Axes  = 5,  // 1..8
    parameter int unsigned Width = 24
) (
    input  logic                  clk_i,
    input  logic                  rst_ni,
    input  logic                  flush_i,     // drop the job
    input  logic                  start_i,
    input  logic [Axes*Width-1:0] lengths_i,   // signed, axis 0 lowest, above -2^(Width-1)
    input  logic                  advance_i,
    output logic                  active_o,
    output logic                  ready_o,
    output logic [Axes-1:0]       step_o,
    output logic [Axes-1:0]       negative_o
);

  localparam logic [2:0] LAST_AXIS = 3'(Axes - 1);

  // Each axis: D = 2 length - longest; D >= 0: step, D += 2 length - 2 longest; else D += 2 length.
  // Before the line the axes are gone through twice, with one subtractor and one adder: for the
  // longest, and for `ahead`, longest - length, and D.
  logic [Width-1:0] size, ahead, longest_q, left_q;
  logic signed [Width+1:0] first_behind;
  logic [Axes*Width-1:0] size_q;
  logic [Axes-1:0] negative_q;
  logic [2:0] axis_q;
  logic measure_q, place_q, longer, last;

  always_comb begin
    size = '0;
    for (int unsigned i = 0; i < Axes; i++) if (axis_q == 3'(i)) size = size | size_q[Width*i+:Width];
  end

  assign {longer, ahead} = {1'b0, longest_q} - {1'b0, size};
  assign first_behind    = $signed({2'b00, size}) - $signed({2'b00, ahead});
  assign last            = axis_q == LAST_AXIS;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      left_q    <= '0;
      measure_q <= 1'b0;
      place_q   <= 1'b0;
    end else if (flush_i) begin
      left_q    <= '0;
      measure_q <= 1'b0;
      place_q   <= 1'b0;
    end else begin
      measure_q <= start_i || (measure_q && !last);
      place_q   <= (measure_q || place_q) && (place_q != last);
      if (start_i) left_q <= '0;
      else if (place_q && last) left_q <= longest_q;
      else if (advance_i && ready_o) left_q <= left_q - 1'b1;
    end
  end

  always_ff @(posedge clk_i) begin
    axis_q <= (start_i || last) ? 3'd0 : axis_q + 3'd1;
    if (start_i) longest_q <= '0;
    else if (measure_q && longer) longest_q <= size;
  end

  genvar axis;
  generate
    for (axis = 0; axis < Axes; axis++) begin : gen_axis
      logic signed [Width-1:0] length;
      logic signed [Width+1:0] behind_q;
      logic [Width-1:0] ahead_q;
      logic [Width:0] sum, operand;
      logic turn, unused;

      assign length = lengths_i[Width*axis+:Width];

      always_ff @(posedge clk_i) begin
        if (start_i) begin
          size_q[Width*axis+:Width] <= length[Width-1] ? -length : length;
          negative_q[axis] <= length[Width-1];
        end
        if (place_q && axis_q == 3'(axis)) begin
          ahead_q  <= ahead;
          behind_q <= first_behind;
        end else if (advance_i && ready_o) behind_q <= {sum, behind_q[0]};
      end

      // D changes by an even number: one adder for both, with the carry of a subtraction.
      assign turn    = !behind_q[Width+1];
      assign operand = turn ? {1'b1, ~ahead_q} : {1'b0, size_q[Width*axis+:Width]};
      assign {sum, unused} = {behind_q[Width+1:1], 1'b1} + {operand, turn};
      assign step_o[axis]     = ready_o && turn;
    end
  endgenerate

  assign ready_o    = left_q != '0;
  assign active_o   = measure_q || place_q || ready_o;
  assign negative_o = negative_q;

endmodule
