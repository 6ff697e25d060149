// SPDX-License-Identifier: Apache-2.0
// sinc3_timing: clock of the sigma-delta modulators, and what their filters do when.
// Contract: mclk_o has a period of ClocksPerBit clocks; strobe_o is high in the last clock of each, when the
// modulators' bits are taken. fast_o shifts a bit through the three clocks after every FastRate-th strobe,
// corner_o the same after the four corners of a window: the first strobe from window_i on and three more,
// SlowRate bits apart. fast_valid_o and, for the fourth corner, done_o are high in the fourth clock after
// the strobe. A window_i within a window begins again.
module sinc3_timing #(
    parameter int unsigned ClocksPerBit = 6,   // even, at least 4
    parameter int unsigned SlowRate     = 64,  // power of two
    parameter int unsigned FastRate     = 8    // power of two
) (
    input  logic       clk_i,
    input  logic       rst_ni,
    input  logic       window_i,
    output logic       mclk_o,
    output logic       strobe_o,
    output logic [2:0] corner_o,
    output logic       done_o,
    output logic [2:0] fast_o,
    output logic       fast_valid_o
);

  localparam int unsigned PhaseBits = $clog2(ClocksPerBit);
  localparam int unsigned SlowBits = $clog2(SlowRate);
  localparam int unsigned FastBits = $clog2(FastRate);
  localparam logic [PhaseBits-1:0] LAST = PhaseBits'(ClocksPerBit - 1);
  localparam logic [PhaseBits-1:0] HALF = PhaseBits'(ClocksPerBit / 2);

  logic [PhaseBits-1:0] phase_q;
  logic [FastBits-1:0] fast_q;
  logic [SlowBits-1:0] bits_q;  // since the last corner
  logic [1:0] count_q;  // corners that are to come
  logic [2:0] corner_q;
  logic [3:0] step_q;
  logic armed_q, fourth_q, done_q, begins, corner;

  assign begins = armed_q || window_i;
  assign corner = strobe_o && (begins || (count_q != '0 && bits_q == '1));

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      phase_q  <= '0;
      fast_q   <= '0;
      bits_q   <= '0;
      count_q  <= '0;
      corner_q <= '0;
      step_q   <= '0;
      armed_q  <= 1'b0;
      fourth_q <= 1'b0;
      done_q   <= 1'b0;
    end else begin
      phase_q  <= strobe_o ? '0 : phase_q + 1'b1;
      armed_q  <= begins && !strobe_o;
      corner_q <= {corner_q[1:0], corner};
      step_q   <= {step_q[2:0], strobe_o && fast_q == '1};
      done_q   <= corner_q[2] && fourth_q;
      if (strobe_o) begin
        fast_q <= fast_q + 1'b1;
        bits_q <= corner ? '0 : bits_q + 1'b1;
      end
      if (corner) begin
        count_q  <= begins ? 2'd3 : count_q - 2'd1;
        fourth_q <= !begins && count_q == 2'd1;
      end
    end
  end

  assign corner_o     = corner_q;
  assign done_o       = done_q;
  assign fast_o       = step_q[2:0];
  assign fast_valid_o = step_q[3];
  assign strobe_o     = phase_q == LAST;
  assign mclk_o       = phase_q >= HALF;

endmodule
