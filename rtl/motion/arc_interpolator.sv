// SPDX-License-Identifier: Apache-2.0
// arc_interpolator: integer steps along a circle around the origin, decided by the sign of the circle's
// equation at the centre of the grid square being crossed (half-step extrapolation).
// Contract: start_i takes the nodes, start_u^2 + start_v^2 - R^2 and the direction. Every advance_i with
// ready_o gives one step on step_o/negative_o {v, u} with valid_o a clock later; steps take two. It ends
// on its end node; start = end is a whole turn, turns_i more are added. Start and end have N = u^2 + v^2 - R^2
// with -(|u| + |v|) <= N < |u| + |v|: within 1/2 step of the circle along the diagonal, so up to 1/sqrt(2) step
// off. The origin is neither. Elementary steps move one axis, and every node keeps that bound. Combined ones
// may move both; if -m <= N < m, m = max(|u|, |v|), holds for start and end, it holds for every node, which is
// then within 1/2 step of the circle along an axis. If not, nodes keep the bound of start and end alone.
module arc_interpolator #(
    parameter int unsigned Width    = 24,
    parameter int unsigned TurnBits = 8
) (
    input  logic                    clk_i,
    input  logic                    rst_ni,
    input  logic                    flush_i,       // drop the job
    input  logic                    start_i,
    input  logic                    combined_i,
    input  logic                    clockwise_i,
    input  logic [TurnBits-1:0]     turns_i,
    input  logic signed [Width-1:0] start_u_i,
    input  logic signed [Width-1:0] start_v_i,
    input  logic signed [Width-1:0] end_u_i,
    input  logic signed [Width-1:0] end_v_i,
    input  logic signed [Width-1:0] start_error_i,
    input  logic                    advance_i,
    output logic                    ready_o,
    output logic                    active_o,
    output logic                    valid_o,
    output logic [1:0]              step_o,
    output logic [1:0]              negative_o
);

  // A clockwise arc is a counterclockwise one with u and v exchanged. In every quadrant of that one
  // coordinate shrinks (p > 0) and the other grows (q >= 0):
  //   quadrant      0: u > 0, v >= 0   1: v > 0, u <= 0   2: u < 0, v <= 0   3: v < 0, u >= 0
  //   p, q             u, v               v, -u              -u, -v             -v, u
  // so one rule does them all; at p = 0 the next quadrant begins with p = q, q = 0. With
  // N = p^2 + q^2 - R^2:
  //   elementary:         N - p + q >= 0 (the square's centre lies outside): p - 1; else q + 1
  //   combined, p > q:    q + 1, and p - 1 if N - p + 2q + 1 >= 0
  //   combined, p <= q:   p - 1, and q + 1 if N - 2p + q + 1 < 0
  // q - p grows by one with every axis moved; in the last quadrant the arc ends where it is the end's.
  localparam int unsigned Bits = Width + 3;

  typedef enum logic [2:0] {
    StIdle,
    StPlace,
    StCount,
    StDecide,
    StMove
  } state_e;

  function automatic logic [1:0] quadrant(input logic signed [Width-1:0] u, input logic signed [Width-1:0] v);
    logic u_zero, v_zero, u_negative, v_negative;
    u_zero     = u == '0;
    v_zero     = v == '0;
    u_negative = u[Width-1];
    v_negative = v[Width-1];
    if (!u_negative && !u_zero && !v_negative) quadrant = 2'd0;
    else if (!v_negative && !v_zero) quadrant = 2'd1;
    else if (u_negative) quadrant = 2'd2;
    else quadrant = 2'd3;
  endfunction

  function automatic logic [Width-1:0] size(input logic signed [Width-1:0] value);
    size = value[Width-1] ? -value : value;
  endfunction

  // As a signed number of the error's width.
  function automatic logic signed [Bits-1:0] wide(input logic [Width-1:0] value);
    wide = {3'b000, value};
  endfunction

  state_e state_q;
  logic signed [Width-1:0] u_q, v_q, end_u_q, end_v_q;
  logic [Width-1:0] p_q, q_q, end_p_q, end_q_q;
  logic signed [Bits-1:0] error_q, look, change, along, along_end, left_q;
  logic [TurnBits+2:0] borders_q;  // quadrant borders still to pass
  logic [TurnBits-1:0] turns_q;
  logic [1:0] quadrant_q, end_quadrant_q, start_quadrant, end_quadrant, passes;
  logic combined_q, clockwise_q, move_p_q, move_q_q, move_p, move_q;
  logic growing_faster, last, final_step, over, crosses;

  assign start_quadrant = quadrant(u_q, v_q);
  assign end_quadrant   = quadrant(end_u_q, end_v_q);
  assign growing_faster     = p_q > q_q;  // the growing coordinate is the faster one
  assign last       = borders_q == '0;
  assign along      = wide(q_q) - wide(p_q);
  assign along_end  = wide(end_q_q) - wide(end_p_q);
  assign passes     = end_quadrant_q - quadrant_q;
  assign over       = last && left_q <= 0;
  assign final_step = last && left_q == 1;
  assign crosses    = move_p_q && p_q == {{(Width - 1) {1'b0}}, 1'b1};

  always_comb begin
    look = error_q - wide(p_q) + wide(q_q);
    if (combined_q) look = look + {{(Bits - 1) {1'b0}}, 1'b1} + (growing_faster ? wide(q_q) : -wide(p_q));
    if (final_step) begin  // one axis is left to move, whatever the rule says
      move_q = q_q != end_q_q;
      move_p = !move_q;
    end else if (!combined_q) begin
      move_p = !look[Bits-1];
      move_q = !move_p;
    end else begin
      move_p = !growing_faster || !look[Bits-1];
      move_q = growing_faster || look[Bits-1];
    end
    change = '0;
    if (move_p_q) change = change + {{(Bits - 1) {1'b0}}, 1'b1} - (wide(p_q) <<< 1);
    if (move_q_q) change = change + {{(Bits - 1) {1'b0}}, 1'b1} + (wide(q_q) <<< 1);
  end

  always_ff @(posedge clk_i) begin
    case (state_q)
      StIdle: begin
        combined_q  <= combined_i;
        clockwise_q <= clockwise_i;
        turns_q     <= turns_i;
        u_q         <= clockwise_i ? start_v_i : start_u_i;
        v_q         <= clockwise_i ? start_u_i : start_v_i;
        end_u_q     <= clockwise_i ? end_v_i : end_u_i;
        end_v_q     <= clockwise_i ? end_u_i : end_v_i;
        error_q     <= {{3{start_error_i[Width-1]}}, start_error_i};
      end
      StPlace: begin
        quadrant_q     <= start_quadrant;
        end_quadrant_q <= end_quadrant;
        {p_q, q_q}     <= start_quadrant[0] ? {size(v_q), size(u_q)} : {size(u_q), size(v_q)};
        {end_p_q, end_q_q} <= end_quadrant[0] ? {size(end_v_q), size(end_u_q)}
                                              : {size(end_u_q), size(end_v_q)};
      end
      StCount: begin
        // From a node back to itself, or to one after it in its quadrant, is a whole turn.
        if (passes == 2'd0 && along >= along_end) borders_q <= {{1'b0, turns_q} + 1'b1, 2'b00};
        else borders_q <= {1'b0, turns_q, passes};
        left_q <= along_end - along;
      end
      StDecide:
      if (advance_i && !over) begin
        move_p_q <= move_p;
        move_q_q <= move_q;
      end
      default: begin  // StMove
        error_q <= error_q + change;
        if (crosses) begin
          p_q        <= move_q_q ? q_q + 1'b1 : q_q;
          q_q        <= '0;
          quadrant_q <= quadrant_q + 2'd1;
          borders_q  <= borders_q - 1'b1;
          left_q     <= along_end + wide(move_q_q ? q_q + 1'b1 : q_q);
        end else begin
          if (move_p_q) p_q <= p_q - 1'b1;
          if (move_q_q) q_q <= q_q + 1'b1;
          left_q <= left_q - ((move_p_q && move_q_q) ? 2 : 1);
        end
      end
    endcase
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) state_q <= StIdle;
    else if (flush_i) state_q <= StIdle;
    else
      case (state_q)
        StIdle: if (start_i) state_q <= StPlace;
        StPlace: state_q <= StCount;
        StCount: state_q <= StDecide;
        StDecide: if (over) state_q <= StIdle; else if (advance_i) state_q <= StMove;
        default: state_q <= StDecide;
      endcase
  end

  // The shrinking coordinate is u in even quadrants; it is the negative one's size in 2 and 3.
  logic [1:0] plain_step, plain_negative;
  logic p_negative, q_negative;

  assign p_negative = !quadrant_q[1];                    // p - 1 lowers the coordinate itself
  assign q_negative = quadrant_q[1] != quadrant_q[0];
  assign plain_step     = quadrant_q[0] ? {move_p_q, move_q_q} : {move_q_q, move_p_q};
  assign plain_negative = quadrant_q[0] ? {p_negative, q_negative} : {q_negative, p_negative};

  assign ready_o    = state_q == StDecide && !over;
  assign active_o   = state_q != StIdle;
  assign valid_o    = state_q == StMove;
  assign step_o     = clockwise_q ? {plain_step[0], plain_step[1]} : plain_step;
  assign negative_o = clockwise_q ? {plain_negative[0], plain_negative[1]} : plain_negative;

endmodule
