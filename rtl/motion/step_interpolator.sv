// SPDX-License-Identifier: Apache-2.0
// step_interpolator: lines and arcs in the planes G17 (X, Y), G18 (Z, X) and G19 (Y, Z), step by step.
// Contract: start_i while not active_o takes a job of line_interpolator or arc_interpolator (arc_i), both
// with u, v being the plane's axes in that order; every advance_i with ready_o gives one step on
// step_o/negative_o {z, y, x} with valid_o, a clock later for arcs as for lines.
module step_interpolator #(
    parameter int unsigned Width    = 24,
    parameter int unsigned TurnBits = 8
) (
    input  logic                    clk_i,
    input  logic                    rst_ni,
    input  logic                    flush_i,        // drop the job
    input  logic                    start_i,
    input  logic                    arc_i,
    input  logic [1:0]              plane_i,        // 0: X Y, 1: Z X, 2: Y Z
    input  logic                    combined_i,
    input  logic                    clockwise_i,
    input  logic [TurnBits-1:0]     turns_i,
    input  logic signed [Width-1:0] start_u_i,      // arcs: from the centre; lines: unused
    input  logic signed [Width-1:0] start_v_i,
    input  logic signed [Width-1:0] end_u_i,        // arcs: from the centre; lines: from the start
    input  logic signed [Width-1:0] end_v_i,
    input  logic signed [Width-1:0] start_error_i,
    input  logic                    advance_i,
    output logic                    active_o,
    output logic                    ready_o,
    output logic                    valid_o,
    output logic [2:0]              step_o,
    output logic [2:0]              negative_o
);

  logic arc_q, line_valid_q, line_active, arc_active, arc_ready, arc_valid;
  logic [1:0] plane_q, line_step, line_negative, line_step_q, arc_step, arc_negative, step, negative;

  line_interpolator #(
      .Width(Width)
  ) u_line (
      .clk_i,
      .rst_ni,
      .flush_i,
      .start_i   (start_i && !arc_i),
      .combined_i,
      .end_u_i,
      .end_v_i,
      .advance_i (advance_i && !arc_q),
      .active_o  (line_active),
      .step_o    (line_step),
      .negative_o(line_negative)
  );

  arc_interpolator #(
      .Width   (Width),
      .TurnBits(TurnBits)
  ) u_arc (
      .clk_i,
      .rst_ni,
      .flush_i,
      .start_i      (start_i && arc_i),
      .combined_i,
      .clockwise_i,
      .turns_i,
      .start_u_i,
      .start_v_i,
      .end_u_i,
      .end_v_i,
      .start_error_i,
      .advance_i    (advance_i && arc_q),
      .ready_o      (arc_ready),
      .active_o     (arc_active),
      .valid_o      (arc_valid),
      .step_o       (arc_step),
      .negative_o   (arc_negative)
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      arc_q        <= 1'b0;
      plane_q      <= 2'd0;
      line_valid_q <= 1'b0;
    end else if (flush_i) begin
      arc_q        <= 1'b0;
      plane_q      <= 2'd0;
      line_valid_q <= 1'b0;
    end else begin
      if (start_i) begin
        arc_q   <= arc_i;
        plane_q <= plane_i;
      end
      line_valid_q <= advance_i && !arc_q && line_active;
    end
  end

  always_ff @(posedge clk_i) line_step_q <= line_step;

  assign step     = arc_q ? arc_step : line_step_q;
  assign negative = arc_q ? arc_negative : line_negative;
  assign active_o = arc_active || line_active || line_valid_q;
  assign ready_o  = arc_q ? arc_ready : line_active;
  assign valid_o  = arc_q ? arc_valid : line_valid_q;

  always_comb begin
    case (plane_q)
      2'd0: begin
        step_o     = {1'b0, step};
        negative_o = {1'b0, negative};
      end
      2'd1: begin
        step_o     = {step[0], 1'b0, step[1]};
        negative_o = {negative[0], 1'b0, negative[1]};
      end
      default: begin
        step_o     = {step, 1'b0};
        negative_o = {negative, 1'b0};
      end
    endcase
    if (!valid_o) step_o = 3'd0;
  end

endmodule
