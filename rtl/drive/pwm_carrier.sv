// SPDX-License-Identifier: Apache-2.0
// pwm_carrier: the triangle that the phases of all axes compare with, and the instants that belong to it.
// Contract: a period is two halves of half_period_i clocks each (at least 2^6): up, count_o = 0 .. half - 1,
// and down, half .. 1. load_o is high in the last clock of a half; half_period_i and what the phases
// compare with are taken over at its end. window_o is high in clock window_start_i of each half, counted
// from 0; a start beyond the half is its last clock.
module pwm_carrier #(
    parameter int unsigned Width = 12
) (
    input  logic             clk_i,
    input  logic             rst_ni,
    input  logic [Width-1:0] half_period_i,
    input  logic [Width-1:0] window_start_i,
    output logic [Width-1:0] count_o,
    output logic             up_o,
    output logic             load_o,
    output logic             window_o,
    output logic [Width-1:0] half_o          // clocks of the present half
);

  localparam logic [Width-1:0] LEAST = Width'(64);
  localparam logic [Width-1:0] ONE = Width'(1);

  logic [Width-1:0] count_q, half_q, left_q, since_q, half_next;
  logic up_q, opened_q, last;

  assign last      = left_q == '0;
  assign half_next = (half_period_i < LEAST) ? LEAST : half_period_i;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      up_q     <= 1'b1;
      count_q  <= '0;
      since_q  <= '0;
      opened_q <= 1'b0;
      half_q   <= LEAST;
      left_q   <= LEAST - ONE;
    end else if (last) begin
      up_q     <= !up_q;
      half_q   <= half_next;
      left_q   <= half_next - ONE;
      count_q  <= up_q ? half_next : '0;
      since_q  <= '0;
      opened_q <= 1'b0;
    end else begin
      left_q   <= left_q - ONE;
      count_q  <= up_q ? count_q + ONE : count_q - ONE;
      since_q  <= since_q + ONE;
      opened_q <= opened_q || window_o;
    end
  end

  assign count_o  = count_q;
  assign up_o     = up_q;
  assign load_o   = last;
  assign window_o = (since_q == window_start_i || last) && !opened_q;
  assign half_o   = half_q;

endmodule
