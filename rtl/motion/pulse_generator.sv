// SPDX-License-Identifier: Apache-2.0
// pulse_generator: pulses at a rate given in 1/16 Hz, exact on the grid of a 100 MHz clock.
// After n clocks at a constant rate R since clear_i, floor((Modulus/2 + n R) / Modulus) pulses have
// started: the mean is exact, every edge is on the first clock at or after its ideal instant.
// Contract: pulse_o is high for one clock per pulse, never two in a row; rates above
// Modulus/2 (50 MHz) give a pulse every other clock. A new rate counts from the next clock edge.
module pulse_generator #(
    parameter logic [31:0] Modulus = 32'd1_600_000_000  // 16 x clock frequency in Hz, even
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        clear_i,   // start from half a pulse; one due in the next clock is still given
    input  logic [31:0] rate_i,    // U(28.4) Hz
    output logic        pulse_o,
    output logic [31:0] count_o    // pulses since reset, modulo 2^32
);

  // The phase runs from -Modulus to 0; reaching 0 is a pulse, and the modulus is taken off one clock
  // later together with the next increment, so there is one adder and no comparator.
  // Trailing zeros of the modulus need no adder.
  function automatic int trailing_zeros(input logic [31:0] value);
    trailing_zeros = 31;
    for (int i = 31; i >= 0; i--) if (value[i]) trailing_zeros = i;
  endfunction

  localparam int LOW = trailing_zeros(Modulus);
  localparam logic signed [33:0] WRAP = -$signed({2'd0, Modulus});
  localparam logic signed [33:0] HALF = WRAP >>> 1;

  logic signed [33:0] phase_q, phase_d;
  // Two plain adders are smaller than one of three operands.
  (* keep *) logic [33:LOW] increment_high;
  logic pulse_q, pulse_d, wrap_q, start_q, centre;

  assign increment_high = {2'd0, rate_i[31:LOW]} + (wrap_q ? WRAP[33:LOW] : '0);
  assign phase_d   = phase_q + $signed({increment_high, rate_i[LOW-1:0]});
  assign pulse_d   = !phase_d[33];
  // Not below 0 although the modulus was taken off: the rate is above half a pulse per clock. From
  // the centre such a rate pulses in the next clock.
  assign centre    = clear_i || start_q || (pulse_q && pulse_d);

  always_ff @(posedge clk_i) phase_q <= centre ? HALF : phase_d;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      start_q <= 1'b1;
      pulse_q <= 1'b0;
      wrap_q  <= 1'b0;
      count_o <= '0;
    end else begin
      start_q <= 1'b0;
      pulse_q <= pulse_d && !pulse_q && !start_q;
      wrap_q  <= pulse_d && !centre;  // its modulus is taken off; a centred phase owes none
      if (pulse_q) count_o <= count_o + 32'd1;
    end
  end

  assign pulse_o = pulse_q;

endmodule
