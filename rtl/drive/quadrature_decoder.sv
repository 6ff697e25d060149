// SPDX-License-Identifier: Apache-2.0
// quadrature_decoder: position of an incremental encoder from its lines A, B and Z, four counts a period.
// Contract: each line passes two synchronising registers and a filter that takes over a level which lasted
// filter_i + 1 clocks. position_o follows a line 4 + filter_i clocks later and goes up where A leads B. It is
// exact while each line keeps a level for filter_i + 1 clocks at least and A and B change in different
// clocks: 25 million counts per second need 100 MHz with any jitter below 3 clocks an edge. A and B changing
// at once count nothing and set illegal_o; illegal_count_o stops at its greatest value. The index is where
// A, B and Z are high together. filter_i may change only while the lines rest.
module quadrature_decoder #(
    parameter int unsigned FilterBits = 4
) (
    input  logic                  clk_i,
    input  logic                  rst_ni,
    // encoder, asynchronous
    input  logic                  a_i,
    input  logic                  b_i,
    input  logic                  z_i,
    // registers
    input  logic [FilterBits-1:0] filter_i,
    input  logic                  clear_i,           // forgets illegal transitions and the index
    input  logic [31:0]           time_i,            // clocks
    output logic signed [31:0]    position_o,        // from 0 at reset
    output logic [31:0]           edge_time_o,       // time_i at the last count
    output logic                  index_o,           // an index was passed
    output logic signed [31:0]    index_position_o,  // position at the last one
    output logic                  passes_o,          // a clock before index_position_o changes
    output logic                  illegal_o,
    output logic [7:0]            illegal_count_o
);

  logic [2:0] meta_q, line_q, level_q, prev_q;  // {z, b, a}
  logic [2:0] reached;
  logic [FilterBits-1:0] lasted_q[0:2];  // clocks that a line has differed from its level
  logic [3:0] settled_q;  // all ones: the registers hold what the lines are
  logic settled, moved_a, moved_b, illegal, count, down, at_index, at_index_q;

  assign settled  = settled_q[3];
  assign moved_a  = level_q[0] != prev_q[0];
  assign moved_b  = level_q[1] != prev_q[1];
  assign illegal  = settled && moved_a && moved_b;
  assign count    = settled && (moved_a != moved_b);
  assign down     = level_q[0] == prev_q[1];
  assign at_index = &prev_q;
  assign passes_o = at_index && !at_index_q;

  genvar i;
  generate
    for (i = 0; i < 3; i++) begin : gen_filter
      assign reached[i] = line_q[i] != level_q[i] && (lasted_q[i] >= filter_i || !settled);

      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) lasted_q[i] <= '0;
        else lasted_q[i] <= (line_q[i] != level_q[i] && !reached[i]) ? lasted_q[i] + 1'b1 : '0;
      end
    end
  endgenerate

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      meta_q          <= '0;
      line_q          <= '0;
      level_q         <= '0;
      prev_q          <= '0;
      settled_q       <= '0;
      at_index_q      <= 1'b1;
      index_o         <= 1'b0;
      illegal_o       <= 1'b0;
      illegal_count_o <= '0;
      position_o      <= '0;
    end else begin
      meta_q     <= {z_i, b_i, a_i};
      line_q     <= meta_q;
      level_q    <= level_q ^ reached;
      prev_q     <= level_q;
      settled_q  <= {settled_q[2:0], 1'b1};
      at_index_q <= at_index || !settled;
      index_o    <= !clear_i && (index_o || (at_index && !at_index_q));
      illegal_o  <= !clear_i && (illegal_o || illegal);
      if (clear_i) illegal_count_o <= '0;
      else if (illegal && illegal_count_o != '1) illegal_count_o <= illegal_count_o + 1'b1;
      if (count) position_o <= position_o + {{31{down}}, 1'b1};
    end
  end

  always_ff @(posedge clk_i) begin
    if (count) edge_time_o <= time_i;
    if (at_index && !at_index_q) index_position_o <= position_o;
  end

endmodule
