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
  //    1.. 9  |a| 2/pi = q + f, quadrant q and |f| <= 1/2 quarter turns, f with 61 fraction bits.
  //           The closest a binary32 number in range comes to a multiple of pi/2 is |f| = 2^-28.48
  //           (437ce5f1, 252.898...), which leaves 33 significant bits of f.
  //   10      split f
  //   11..23  Horner's rule for sin(pi/2 f)/f or cos(pi/2 f) on one of 32 segments: steps 11, 14,
  //           18, 23 load the next coefficient; t has 15, 23, 31 bits in the three products
  //   24..28  times f (its five bytes from the leading one on), or times one
  //   29, 30  normalise; round
  // Below 2^-12 the results rounded to nearest are a and 1.

  // 2/pi truncated to 71 fraction bits, and zeros above.
  localparam logic [91:0] TWO_OVER_PI = 92'h00000517cc1b727220a94fe;
  localparam logic [7:0]  EXP_MAX = 8'd135;      // of 256
  localparam logic [7:0]  EXP_MIN = 8'd115;      // of 2^-12
  localparam logic [4:0]  LAST = 5'd30;

  // ---- control: step 0 is idle ----
  logic [4:0] step_q;
  logic       accept;

  assign ready_o = step_q == 5'd0;
  assign accept  = ready_o && valid_i;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      step_q  <= 5'd0;
      valid_o <= 1'b0;
    end else begin
      if (accept || !ready_o) step_q <= (step_q == LAST) ? 5'd0 : step_q + 5'd1;
      valid_o <= step_q == LAST;
    end
  end

  logic       reduce;                            // steps 1..9
  logic       load;                              // a coefficient is loaded, a product begins
  logic [1:0] order;                             // of that coefficient
  logic [2:0] byte_base;                         // byte of f for the next step
  logic       final_product, last_byte;          // for the next step

  assign reduce = step_q <= 5'd9;

  always_comb begin
    load          = 1'b0;
    order         = 2'd0;
    byte_base     = 3'd1;
    final_product = 1'b0;
    last_byte     = 1'b0;
    case (step_q)
      5'd11: begin load = 1'b1; order = 2'd3; byte_base = 3'd2; end
      5'd14: begin load = 1'b1; order = 2'd2; byte_base = 3'd3; end
      5'd15: byte_base = 3'd2;
      5'd18: begin load = 1'b1; order = 2'd1; byte_base = 3'd4; end
      5'd19: byte_base = 3'd3;
      5'd20: byte_base = 3'd2;
      5'd23: begin load = 1'b1; final_product = 1'b1; byte_base = 3'd4; end
      5'd24: begin final_product = 1'b1; byte_base = 3'd3; end
      5'd25: begin final_product = 1'b1; byte_base = 3'd2; end
      5'd26: begin final_product = 1'b1; byte_base = 3'd1; end
      5'd27: begin final_product = 1'b1; byte_base = 3'd0; last_byte = 1'b1; end
      default: ;
    endcase
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
  logic [41:0] sum0;                             // acc_shifted + row0
  logic [36:0] sum12;                            // row1 + 4 row2
  logic [39:0] sum012;                           // (sum0 + 4 sum12) / 4
  logic [35:0] sum;                              // (4 sum012 + 64 row3) / 64
  logic        unused0, unused12, unused012, unused3;

  assign row0 = booth_row(y_q[2:0], x_q);
  assign row1 = booth_row(y_q[4:2], x_q);
  assign row2 = booth_row(y_q[6:4], x_q);
  assign row3 = booth_row(y_q[8:6], x_q);

  // The bit appended below each sum carries into it.
  assign acc_shifted = {{8{acc_q[41]}}, acc_q[41:8]};
  assign {sum0, unused0} = {acc_shifted, 1'b1} + {{7{row0[34]}}, row0, booth_negative(y_q[2:0])};
  assign sum12[1:0] = row1[1:0];
  assign {sum12[36:2], unused12} = {{2{row1[34]}}, row1[34:2], 1'b1}
                                 + {row2, booth_negative(y_q[6:4])};
  assign {sum012, unused012} = {sum0[41:2], 1'b1}
                             + {{3{sum12[36]}}, sum12, booth_negative(y_q[4:2])};
  assign {sum, unused3} = {sum012[39:4], 1'b1} + {row3[34], row3, booth_negative(y_q[8:6])};
  assign acc_next = {sum, sum012[3:0], sum0[1:0]};

  logic clear;
  assign clear = load || step_q == 5'd10 || ready_o;

  always_ff @(posedge clk_i) acc_q <= clear ? 42'd0 : acc_next;

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
    if (step_q == 5'd10) begin
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

  assign byte_index = final_product ? byte_base + {1'b0, leading_q} : byte_base;

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
    if (final_product && !sine_q) byte_f = last_byte ? 8'h40 : 8'h00;   // 2^6, see exp_q
    if (!final_product && byte_base == 3'd1) byte_f[7] = 1'b0;        // segment
  end

  always_ff @(posedge clk_i)
    y_q <= {reduce ? byte_pi : byte_f, y_q[8] && !load && !ready_o};

  // ---- cubic: byte 1 has seven bits of t, so a product with t is acc_q / 2^7 ----
  logic [33:0] coefficient;                      // S(2.32)

  fp_sincos_rom rom (
      .cos_i        (!sine_q),
      .segment_i    (segment_q),
      .order_i      (order),
      .coefficient_o(coefficient)
  );

  always_ff @(posedge clk_i) begin
    if (accept) x_q <= {10'd0, 1'b1, a_i[22:0]};
    else if (load) x_q <= coefficient + acc_q[40:7];
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

  fp_round round (
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
  logic out_of_range, below_min, subnormal;

  assign out_of_range = a_q[30:0] > {EXP_MAX, 23'd0};   // NaN and infinity as well
  assign below_min        = a_q[30:23] < EXP_MIN;
  assign subnormal    = !(|a_q[30:23]);

  always_ff @(posedge clk_i) begin
    if (out_of_range) begin
      result_o <= fp_pkg::CANON_NAN;
      flags_o  <= {!fp_pkg::is_nan(a_q) || fp_pkg::is_snan(a_q), 4'b0000};
    end else if (below_min) begin
      result_o <= cos_q ? fp_pkg::ONE : a_q;
      flags_o  <= {3'b000, !cos_q && subnormal && (|a_q[22:0]), |a_q[30:0]};
    end else begin
      result_o <= rounded;
      flags_o  <= rounded_flags;
    end
  end

endmodule
