// SPDX-License-Identifier: Apache-2.0
// fp_sincos: sine or (cos_i) cosine of a binary32 angle in radians, iterative, one at a time.
// Contract: accepts while ready_o; latency fp_pkg::FP_SINCOS_LATENCY register ranks. |a| <= 256 has
// an error below 0.532 ulp (sign and symmetry exact); outside, and for infinities, NaN with nv.
// Zero gives +-0 or 1 exactly; all else is inexact, the sine of a subnormal number also underflows.
// One multiplier of 34 x 8 bits per step does all: |a| 2/pi, a cubic, and the product with f.
module fp_sincos (
    input  logic           clk_i,
    input  logic           rst_ni,
    input  logic           valid_i,
    input  logic           cos_i,
    input  logic [31:0]    a_i,
    output logic           ready_o,
    output logic           valid_o,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  // Steps (register ranks after the one that accepts):
  // A product takes a step per byte and one more, as its rows are added in pairs a step earlier.
  //    1..10  |a| 2/pi = q + f, quadrant q and |f| <= 1/2 quarter turns, f with 61 fraction bits.
  //           The closest a binary32 number in range comes to a multiple of pi/2 is |f| = 2^-28.48
  //           (437ce5f1, 252.898...), which leaves 33 significant bits of f.
  //   11      split f
  //   12..27  Horner's rule for sin(pi/2 f)/f or cos(pi/2 f) on one of 32 segments: steps 12, 16,
  //           21, 27 load the next coefficient; t has 15, 23, 31 bits in the three products
  //   28..33  times f (its five bytes from the leading one on), or times one
  //   34, 35  normalise; round
  // Below 2^-12 the results rounded to nearest are a and 1.

  // 2/pi truncated to 71 fraction bits, and zeros above.
  localparam logic [91:0] TWO_OVER_PI = 92'h00000517cc1b727220a94fe;
  localparam logic [7:0]  EXP_MAX = 8'd135;      // of 256
  localparam logic [7:0]  EXP_MIN = 8'd115;      // of 2^-12
  localparam logic [5:0]  LAST = 6'd35;

  // ---- control: step 0 is idle ----
  logic [5:0] step_q;
  logic       accept;

  assign ready_o = step_q == 6'd0;
  assign accept  = ready_o && valid_i;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      step_q  <= 6'd0;
      valid_o <= 1'b0;
    end else begin
      if (accept || !ready_o) step_q <= (step_q == LAST) ? 6'd0 : step_q + 6'd1;
      valid_o <= step_q == LAST;
    end
  end

  logic       reduce;                            // steps up to 10
  logic       split;                             // step 11
  logic       load_d, load_q;                    // a coefficient is loaded, a product begins
  logic [1:0] order_q;                           // of the next coefficient
  logic [2:0] byte_base_d, byte_base_q;          // byte of f for the next step
  logic       final_d, final_q;                  // the next step belongs to the last product,
  logic       last_byte_d, last_byte_q;          // .. with its last byte
  logic       clear_q;                           // the first step of a product, nothing to add yet

  assign reduce = step_q <= 6'd10;
  assign split  = step_q == 6'd11;

  always_comb begin                              // in the step before
    load_d      = 1'b0;
    byte_base_d = 3'd1;
    final_d     = 1'b0;
    last_byte_d = 1'b0;
    case (step_q)
      6'd11: begin load_d = 1'b1; byte_base_d = 3'd2; end
      6'd15: begin load_d = 1'b1; byte_base_d = 3'd3; end
      6'd16: byte_base_d = 3'd2;
      6'd20: begin load_d = 1'b1; byte_base_d = 3'd4; end
      6'd21: byte_base_d = 3'd3;
      6'd22: byte_base_d = 3'd2;
      6'd26: begin load_d = 1'b1; final_d = 1'b1; byte_base_d = 3'd4; end
      6'd27: begin final_d = 1'b1; byte_base_d = 3'd3; end
      6'd28: begin final_d = 1'b1; byte_base_d = 3'd2; end
      6'd29: begin final_d = 1'b1; byte_base_d = 3'd1; end
      6'd30: begin final_d = 1'b1; byte_base_d = 3'd0; last_byte_d = 1'b1; end
      default: ;
    endcase
  end

  always_ff @(posedge clk_i) begin
    load_q      <= load_d;
    byte_base_q <= byte_base_d;
    final_q     <= final_d;
    last_byte_q <= last_byte_d;
    clear_q     <= load_q || ready_o || step_q == 6'd10;
    if (ready_o) order_q <= 2'd3;
    else if (load_q) order_q <= order_q - 2'd1;
  end

  // ---- operand ----
  logic        cos_q;
  logic [31:0] a_q;

  always_ff @(posedge clk_i) begin
    if (accept) begin
      cos_q <= cos_i;
      a_q   <= a_i;
    end
  end

  // ---- multiplier: accumulator / 256 + x * byte, least significant byte first ----
  // Radix-4 Booth rows -2x .. 2x; y_q is the byte and, below it, the top bit of the byte before.
  // The top bit of the last byte of a factor is zero. Carries of negative rows enter the adders.
  logic [33:0] x_q;                              // S(2.32), or the significand U(24.0)
  logic [8:0]  y_q;
  logic [41:0] acc_q, acc_shifted, acc_next;     // S(10.32), in units of x_q

  function automatic logic [34:0] booth_row(input logic [2:0] digit, input logic [33:0] x);
    case (digit)
      3'b000, 3'b111: booth_row = 35'd0;
      3'b001, 3'b010: booth_row = {x[33], x};
      3'b011:         booth_row = {x, 1'b0};
      3'b100:         booth_row = ~{x, 1'b0};
      default:        booth_row = ~{x[33], x};
    endcase
  endfunction

  function automatic logic booth_negative(input logic [2:0] digit);
    booth_negative = digit[2] && !(digit[1] && digit[0]);
  endfunction

  logic [34:0] row0, row1, row2, row3;
  logic [37:0] low_pair, high_pair;              // row0 + 4 row1, row2 + 4 row3
  logic [37:0] low_pair_q, high_pair_q;
  logic        low_carry_q, high_carry_q;        // of row0 and row2
  logic [41:0] sum_low;                          // acc_shifted + low pair
  logic [37:0] sum_high;                         // (sum_low + 16 high pair) / 16
  logic        unused_low_pair, unused_high_pair, unused_low, unused_high;

  assign row0 = booth_row(y_q[2:0], x_q);
  assign row1 = booth_row(y_q[4:2], x_q);
  assign row2 = booth_row(y_q[6:4], x_q);
  assign row3 = booth_row(y_q[8:6], x_q);

  // The bit appended below each sum carries into it.
  assign low_pair[1:0]  = row0[1:0];
  assign high_pair[1:0] = row2[1:0];
  assign {low_pair[37:2], unused_low_pair} = {{3{row0[34]}}, row0[34:2], 1'b1}
                                           + {row1[34], row1, booth_negative(y_q[4:2])};
  assign {high_pair[37:2], unused_high_pair} = {{3{row2[34]}}, row2[34:2], 1'b1}
                                             + {row3[34], row3, booth_negative(y_q[8:6])};

  always_ff @(posedge clk_i) begin
    low_pair_q   <= low_pair;
    high_pair_q  <= high_pair;
    low_carry_q  <= booth_negative(y_q[2:0]);
    high_carry_q <= booth_negative(y_q[6:4]);
  end

  assign acc_shifted = {{8{acc_q[41]}}, acc_q[41:8]};
  assign {sum_low, unused_low}   = {acc_shifted, 1'b1} + {{4{low_pair_q[37]}}, low_pair_q, low_carry_q};
  assign {sum_high, unused_high} = {sum_low[41:4], 1'b1} + {high_pair_q, high_carry_q};
  assign acc_next = {sum_high, sum_low[3:0]};

  always_ff @(posedge clk_i) acc_q <= clear_q ? 42'd0 : acc_next;

  // ---- reduction ----
  // acc_q has the weights 2^19 .. 2^-22 when it ends and low_q the next 39; q needs 2^1 and 2^0.
  // f is negative in the upper half of a quadrant, where q is rounded up. Its magnitude is then the
  // complement of the bits, one unit of 2^-61 less than the negation.
  logic [38:0] low_q;                            // weights 2^-23 .. 2^-61
  logic [21:0] high_q;                           // weights 2^-1 .. 2^-22
  logic [1:0]  quadrant;                         // of a sine: a cosine is a sine a quarter later
  logic        sine_q, sign_q;                   // the quadrant needs the sine of f; of the result
  logic [4:0]  segment_q;                        // |f| in 64ths
  logic [1:0]  leading_q;                        // see the bytes of f
  logic        negative_f;
  logic [20:0] high;                             // of |f|, weights 2^-2 .. 2^-22
  logic [1:0]  leading;

  assign quadrant = acc_q[23:22] + {1'b0, acc_q[21]} + {1'b0, cos_q};
  assign high     = acc_q[20:0] ^ {21{acc_q[21]}};

  always_comb begin
    if (|high[20:16]) leading = 2'd0;
    else if (|high[15:8]) leading = 2'd1;
    else if (|high[7:0]) leading = 2'd2;
    else leading = 2'd3;
  end

  assign negative_f = high_q[21];

  always_ff @(posedge clk_i) begin
    if (reduce) low_q <= {acc_q[7:0], low_q[38:8]};
    if (split) begin
      high_q    <= acc_q[21:0];
      segment_q <= high[20:16];
      leading_q <= leading;
      sine_q    <= !quadrant[0];
      sign_q    <= quadrant[1] ^ (!quadrant[0] && acc_q[21]) ^ (a_q[31] && !cos_q);
    end
  end

  // Byte of 2/pi for the next step: a is the significand times 2^(exponent - 127 - 23), so that the
  // window of 72 bits starts 135 - exponent bits above the end of the constant, and its top bit has
  // the weight 2^8.
  logic [4:0] offset;                            // 0 .. 20
  logic [6:0] window, window_q;
  logic [7:0] byte_pi;

  assign offset  = EXP_MAX[4:0] - a_i[27:23];
  assign window  = ready_o ? {2'b00, offset} : window_q;
  assign byte_pi = 8'(TWO_OVER_PI >> window);

  always_ff @(posedge clk_i) window_q <= {window[6:3] + 4'd1, window[2:0]};

  // Bytes of |f|: 0 has weights 2^2 .. 2^-5, 1 has 2^-6 .. 2^-13, .., 7 has 2^-54 .. 2^-61. Bits
  // 2^-2 .. 2^-6 are the segment and the others t, so that t starts in byte 1 without its top bit.
  // The product with f starts at the byte that holds the leading one below its top bit (or has it
  // next to its lowest bit).
  logic [2:0]  byte_index;
  logic [7:0]  byte_raw, byte_f;

  assign byte_index = final_q ? byte_base_q + {1'b0, leading_q} : byte_base_q;

  always_comb begin
    case (byte_index)
      3'd0:    byte_raw = {{3{negative_f}}, high_q[21:17]};
      3'd1:    byte_raw = high_q[16:9];
      3'd2:    byte_raw = high_q[8:1];
      3'd3:    byte_raw = {high_q[0], low_q[38:32]};
      3'd4:    byte_raw = low_q[31:24];
      3'd5:    byte_raw = low_q[23:16];
      3'd6:    byte_raw = low_q[15:8];
      default: byte_raw = low_q[7:0];
    endcase
  end

  always_comb begin
    byte_f = byte_raw ^ {8{negative_f}};
    if (final_q && !sine_q) byte_f = last_byte_q ? 8'h40 : 8'h00;   // 2^6, see exp_q
    if (!final_q && byte_base_q == 3'd1) byte_f[7] = 1'b0;        // segment
  end

  always_ff @(posedge clk_i)
    y_q <= {reduce ? byte_pi : byte_f, y_q[8] && !load_q && !ready_o};

  // ---- cubic: byte 1 has seven bits of t, so a product with t is acc_q / 2^7 ----
  logic [33:0] coefficient;                      // S(2.32)

  fp_sincos_rom u_rom (
      .cos_i        (!sine_q),
      .segment_i    (segment_q),
      .order_i      (order_q),
      .coefficient_o(coefficient)
  );

  always_ff @(posedge clk_i) begin
    if (accept) x_q <= {10'd0, 1'b1, a_i[22:0]};
    else if (load_q) x_q <= coefficient + acc_q[40:7];
  end

  // ---- normalise, round ----
  // acc_q U(8.32) is in (0.7, 202), the sine times 2^(5 + 8 leading) or the cosine times 2^6.
  logic [3:0]  zeros;                            // of acc_q[39:0], 0 .. 8
  logic [25:0] sig_q;                            // U(1.25)
  logic [7:0]  exp_q;                            // biased

  always_comb begin
    casez (acc_q[39:32])
      8'b1???????: zeros = 4'd0;
      8'b01??????: zeros = 4'd1;
      8'b001?????: zeros = 4'd2;
      8'b0001????: zeros = 4'd3;
      8'b00001???: zeros = 4'd4;
      8'b000001??: zeros = 4'd5;
      8'b0000001?: zeros = 4'd6;
      8'b00000001: zeros = 4'd7;
      default:     zeros = 4'd8;
    endcase
  end

  always_ff @(posedge clk_i) begin
    sig_q <= 26'((acc_q[39:6] << zeros) >> 8);
    exp_q <= 8'd128 + {7'd0, sine_q} - (sine_q ? {3'd0, leading_q, 3'd0} : 8'd0) - {4'd0, zeros};
  end

  logic [31:0]    rounded;
  fp_pkg::flags_t rounded_flags;

  fp_round u_round (
      .sign_i  (sign_q),
      .exp_i   ({1'b0, exp_q}),
      .sig_i   (sig_q[25:2]),
      .guard_i (sig_q[1]),
      .round_i (sig_q[0]),
      .sticky_i(1'b1),                           // transcendental: never exact
      .result_o(rounded),
      .flags_o (rounded_flags)
  );

  // ---- operands outside the reduction ----
  // a_q is stable long before the result.
  logic out_of_range_q, below_min_q, invalid_q, underflow_q, inexact_q;

  always_ff @(posedge clk_i) begin
    out_of_range_q <= a_q[30:0] > {EXP_MAX, 23'd0};     // NaN and infinity as well
    below_min_q    <= a_q[30:23] < EXP_MIN;
    invalid_q      <= !fp_pkg::is_nan(a_q) || fp_pkg::is_snan(a_q);
    underflow_q    <= !cos_q && !(|a_q[30:23]) && (|a_q[22:0]);
    inexact_q      <= |a_q[30:0];
  end

  always_ff @(posedge clk_i) begin
    if (out_of_range_q) begin
      result_o <= fp_pkg::CANON_NAN;
      flags_o  <= {invalid_q, 4'b0000};
    end else if (below_min_q) begin
      result_o <= cos_q ? fp_pkg::ONE : a_q;
      flags_o  <= {3'b000, underflow_q, inexact_q};
    end else begin
      result_o <= rounded;
      flags_o  <= rounded_flags;
    end
  end

endmodule
