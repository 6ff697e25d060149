// SPDX-License-Identifier: Apache-2.0
// synchronised_line: a straight line in up to eight axes, one step of the longest axis at a time.
// Contract: start_i takes the signed lengths; every advance_i with active_o gives one combined step in the
// same clock: the longest axis moves, each other one when it is half a step behind, so that all
// stay within 1/2 step of the ideal line. A line of length 0 is over at once.
module synchronised_line #(
    parameter int unsigned Axes  = 5,
    parameter int unsigned Width = 24
) (
    input  logic                  clk_i,
    input  logic                  rst_ni,
    input  logic                  start_i,
    input  logic [Axes*Width-1:0] lengths_i,   // signed, axis 0 lowest, above -2^(Width-1)
    input  logic                  advance_i,
    output logic                  ready_o,     // two clocks after start_i
    output logic [Axes-1:0]       step_o,
    output logic [Axes-1:0]       negative_o
);

  // Each axis: D = 2 length - longest; D >= 0: step, D += 2 length - 2 longest; else D += 2 length.
  logic [Width-1:0] longest, longest_q, left_q;
  logic [Axes*Width-1:0] size_q;
  logic [Axes-1:0] negative_q;
  logic measured_q;

  always_comb begin
    longest = '0;
    for (int unsigned i = 0; i < Axes; i++)
      if (size_q[Width*i+:Width] > longest) longest = size_q[Width*i+:Width];
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      left_q     <= '0;
      measured_q <= 1'b0;
    end else begin
      measured_q <= start_i;
      if (start_i) left_q <= '0;
      else if (measured_q) left_q <= longest;
      else if (advance_i && ready_o) left_q <= left_q - 1'b1;
    end
  end

  always_ff @(posedge clk_i) if (measured_q) longest_q <= longest;

  for (genvar i = 0; i < Axes; i++) begin : gen_axis
    logic signed [Width-1:0] length;
    logic signed [Width+1:0] behind_q, twice;

    assign length = lengths_i[Width*i+:Width];
    assign twice  = {1'b0, size_q[Width*i+:Width], 1'b0};

    always_ff @(posedge clk_i) begin
      if (start_i) begin
        size_q[Width*i+:Width] <= length[Width-1] ? -length : length;
        negative_q[i] <= length[Width-1];
      end
      if (measured_q) behind_q <= twice - $signed({2'b00, longest});
      else if (advance_i && ready_o)
        behind_q <= behind_q + twice - (step_o[i] ? $signed({1'b0, longest_q, 1'b0}) : '0);
    end

    assign step_o[i] = ready_o && !behind_q[Width+1];
  end

  assign ready_o    = left_q != '0;
  assign negative_o = negative_q;

endmodule
