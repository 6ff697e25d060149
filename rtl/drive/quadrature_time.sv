// SPDX-License-Identifier: Apache-2.0
// quadrature_time: position of an encoder with age and direction of its last count, all of one clock, for
// speeds from the time between counts.
// Contract: position_i is that of a quadrature_decoder, 0 at reset. In a clock with sample_i, position_o and
// stamp_o take from the next clock on what holds in it: the position, and 2 age + 1 half clocks, the middle of
// the clock in which the last count came, negative if that count went down; 0 before the first count. The
// age is 0 in the first clock with a new position and stops at 2^AgeBits - 1. With 22 bits a stamp is exact
// in binary32.
module quadrature_time #(
    parameter int unsigned AgeBits = 22
) (
    input  logic               clk_i,
    input  logic               rst_ni,
    input  logic signed [31:0] position_i,
    input  logic               sample_i,
    output logic signed [31:0] position_o,
    output logic signed [31:0] stamp_o
);

  logic [1:0] before_q, moved;
  logic [AgeBits-1:0] age, age_q;
  logic counted, down, counted_q, down_q;
  logic [31:0] size;

  // Positions follow one another in single counts.
  assign moved   = position_i[1:0] - before_q;
  assign counted = moved != 2'd0;
  assign age     = counted ? '0 : age_q;
  assign down    = counted ? moved[1] : down_q;
  assign size    = 32'({age, 1'b1});

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      before_q   <= '0;
      age_q      <= '0;
      counted_q  <= 1'b0;
      down_q     <= 1'b0;
      position_o <= '0;
      stamp_o    <= '0;
    end else begin
      before_q  <= position_i[1:0];
      age_q     <= (age == '1) ? age : age + 1'b1;
      counted_q <= counted_q || counted;
      down_q    <= down;
      if (sample_i) begin
        position_o <= position_i;
        stamp_o    <= !(counted_q || counted) ? '0 : down ? -size : size;
      end
    end
  end

endmodule
