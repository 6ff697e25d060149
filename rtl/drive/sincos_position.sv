// SPDX-License-Identifier: Apache-2.0
// sincos_position: sine and cosine lines of an encoder as the position within a line, the port of an absolute_position
// with Width = Bits, which counts the lines by the shorter way from sample to sample.
// Contract: sample_i asks for a sample unless busy_o is high: window_o is high in that clock, the window_i of a
// sinc3_timing, and valid_i its done_o, in whose clock sine_i and cosine_i are the slow_o of two filters. done_o is
// high for a clock, Bits + 3 clocks after valid_i, with good_o if the amplitude, the root of sine^2 + cosine^2, is
// within Least .. Most and was for After samples before; position_o holds until the next end. It is the arctangent by
// CORDIC with Bits + 1 rotations, 2^Bits counts a line, cut to whole counts. Error before the cut, for amplitudes within the limits:
// 1/6 + (Bits + 1) / 128 + Bits * 2^Bits / (100 * Least) counts at most. Amplitudes near a limit (0.1 %) may be either.
// Source: J. E. Volder, "The CORDIC Trigonometric Computing Technique", IRE Trans. EC-8, 1959.
module sincos_position #(
    parameter int unsigned Width = 19,     // bits of a sample, 8..24: 3 * log2(SlowRate) + 1 of the filters
    parameter int unsigned Bits  = 10,     // 4..16, and Width at most
    parameter int unsigned Least = 32768,  // amplitude, of the full scale 2^(Width - 2) of the filters
    parameter int unsigned Most  = 98304,  // below 2^(Width - 1)
    parameter int unsigned After = 4       // 0..255; Periods of absolute_position: one wrong amplitude is a fault
) (
    input  logic                    clk_i,
    input  logic                    rst_ni,
    // filters
    output logic                    window_o,
    input  logic                    valid_i,
    input  logic signed [Width-1:0] sine_i,
    input  logic signed [Width-1:0] cosine_i,
    // absolute_position
    input  logic                    sample_i,
    output logic                    busy_o,
    output logic                    done_o,
    output logic                    good_o,
    output logic [Bits-1:0]         position_o  // rises with the angle of the point (cosine, sine)
);

  typedef enum logic [1:0] {
    StIdle   = 2'd0,
    StWindow = 2'd1,
    StRotate = 2'd2,
    StEnd    = 2'd3
  } state_e;

  localparam int unsigned Guard = 4;  // bits below a sample's
  localparam int unsigned AngleGuard = 6;  // bits below a count
  localparam int unsigned PointBits = Width + 2 + Guard;  // the rotations lengthen by 1.6468
  localparam int unsigned AngleBits = Bits + AngleGuard;
  localparam int unsigned StepBits = $clog2(Bits + 1);
  // Limits after the rotations: 1.6467603 = 53961 / 2^15.
  localparam logic [63:0] LEAST = (64'(Least) * 64'd53961) >> (15 - Guard);
  localparam logic [63:0] MOST = (64'(Most) * 64'd53961) >> (15 - Guard);

  state_e state_q;
  logic [StepBits-1:0] step_q;
  logic signed [PointBits-1:0] x_q, y_q, x_start, y_start, x_part, y_part;
  logic [AngleBits-1:0] angle_q, part;
  logic [31:0] turn;
  logic done_q, good_q, right;
  logic [7:0] after_q;  // samples that are to be right
  logic [Bits-1:0] position_q;
  logic unused_turn;

  // Arctangent of 2^-step in turns of 2^-32.
  always_comb begin
    case (5'(step_q))
      5'd0: turn = 32'h2000_0000;
      5'd1: turn = 32'h12E4_051E;
      5'd2: turn = 32'h09FB_385B;
      5'd3: turn = 32'h0511_11D4;
      5'd4: turn = 32'h028B_0D43;
      5'd5: turn = 32'h0145_D7E1;
      5'd6: turn = 32'h00A2_F61E;
      5'd7: turn = 32'h0051_7C55;
      5'd8: turn = 32'h0028_BE53;
      5'd9: turn = 32'h0014_5F2F;
      5'd10: turn = 32'h000A_2F98;
      5'd11: turn = 32'h0005_17CC;
      5'd12: turn = 32'h0002_8BE6;
      5'd13: turn = 32'h0001_45F3;
      5'd14: turn = 32'h0000_A2FA;
      5'd15: turn = 32'h0000_517D;
      5'd16: turn = 32'h0000_28BE;
      default: turn = '0;
    endcase
  end

  assign part        = turn[31-:AngleBits] + AngleBits'(turn[31-AngleBits]);
  assign unused_turn = ^turn;
  assign x_start     = {{2{cosine_i[Width-1]}}, cosine_i, {Guard{1'b0}}};
  assign y_start     = {{2{sine_i[Width-1]}}, sine_i, {Guard{1'b0}}};
  assign x_part      = x_q >>> step_q;
  assign y_part      = y_q >>> step_q;
  assign right       = 64'(x_q) >= LEAST && 64'(x_q) <= MOST;
  assign window_o    = sample_i && !busy_o;
  assign busy_o      = state_q != StIdle || done_q;
  assign done_o      = done_q;
  assign good_o      = good_q;
  assign position_o  = position_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q    <= StIdle;
      done_q     <= 1'b0;
      good_q     <= 1'b0;
      after_q    <= '0;
      position_q <= '0;
    end else begin
      done_q <= state_q == StEnd;
      case (state_q)
        StIdle:   if (window_o) state_q <= StWindow;
        StWindow: if (valid_i) state_q <= StRotate;
        StRotate: if (step_q == StepBits'(Bits)) state_q <= StEnd;
        default: begin
          state_q    <= StIdle;
          good_q     <= right && after_q == '0;
          if (!right) after_q <= 8'(After);
          else if (after_q != '0) after_q <= after_q - 1'b1;
          position_q <= angle_q[AngleBits-1-:Bits];
        end
      endcase
    end
  end

  // The point turns to the positive x axis, angle_q is by how much: half a turn to begin with if x is negative.
  always_ff @(posedge clk_i) begin
    if (state_q == StWindow) begin
      step_q  <= '0;
      x_q     <= cosine_i[Width-1] ? -x_start : x_start;
      y_q     <= cosine_i[Width-1] ? -y_start : y_start;
      angle_q <= {cosine_i[Width-1], {(AngleBits - 1) {1'b0}}};
    end else if (state_q == StRotate) begin
      step_q  <= step_q + 1'b1;
      x_q     <= y_q[PointBits-1] ? x_q - y_part : x_q + y_part;
      y_q     <= y_q[PointBits-1] ? y_q + x_part : y_q - x_part;
      angle_q <= y_q[PointBits-1] ? angle_q - part : angle_q + part;
    end
  end

`ifndef SYNTHESIS
  generate
    if (Width < 8 || Width > 24 || Bits < 4 || Bits > 16 || Bits > Width) begin : gen_check_width
      $error("sincos_position: Width=%0d, Bits=%0d, must be 8..24 and 4..16, Bits at most Width", Width, Bits);
    end
    if (Least < 1 || Least >= Most || Most >= (1 << (Width - 1)) || After > 255) begin : gen_check_limits
      $error(
          "sincos_position: Least=%0d, Most=%0d, must rise from 1 and be below 2^(Width - 1), After=%0d at most 255",
          Least,
          Most,
          After
      );
    end
  endgenerate
`endif

endmodule
