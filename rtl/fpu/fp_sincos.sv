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

  localparam logic [5:0] LAST = 6'd35;

  // ---- control: step 0 is idle ----
  logic [5:0] step_q;
  logic accept;

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

  logic reduce;  // steps up to 10
  logic split;  // step 11
  logic load_d, load_q;  // a coefficient is loaded, a product begins
  logic [1:0] order_q;  // of the next coefficient
  logic [2:0] byte_base_d, byte_base_q;  // byte of f for the next step
  logic final_d, final_q;  // the next step belongs to the last product,
  logic last_byte_d, last_byte_q;  // .. with its last byte
  logic clear_q;  // the first step of a product, nothing to add yet

  assign reduce = step_q <= 6'd10;
  assign split  = step_q == 6'd11;

  always_comb begin  // in the step before
    load_d      = 1'b0;
    byte_base_d = 3'd1;
    final_d     = 1'b0;
    last_byte_d = 1'b0;
    case (step_q)
      6'd11: begin
        load_d = 1'b1;
        byte_base_d = 3'd2;
      end
      6'd15: begin
        load_d = 1'b1;
        byte_base_d = 3'd3;
      end
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
  logic cos_q;
  logic [31:0] a_q;

  always_ff @(posedge clk_i) begin
    if (accept) begin
      cos_q <= cos_i;
      a_q   <= a_i;
    end
  end

  // ---- multiplier: accumulator / 256 + x * byte, least significant byte first ----
  // y_q is the byte and, below it, the top bit of the byte before. The top bit of the last byte of a
  // factor is zero.
  logic [33:0] x_q;  // S(2.32), or the significand U(24.0)
  logic [8:0] y_q;
  logic [41:0] acc_q, acc_shifted, acc_next;  // S(10.32), in units of x_q

  logic [37:0] low_pair, high_pair;  // of the byte's lower and upper half
  logic [37:0] low_pair_q, high_pair_q;
  logic low_carry, low_carry_q, high_carry, high_carry_q;
  logic [41:0] sum_low;  // acc_shifted + low pair
  logic [37:0] sum_high;  // (sum_low + 16 high pair) / 16
  logic unused_low, unused_high;

  fp_booth_pair u_low_pair (
      .x_i    (x_q),
      .y_i    (y_q[4:0]),
      .sum_o  (low_pair),
      .carry_o(low_carry)
  );

  fp_booth_pair u_high_pair (
      .x_i    (x_q),
      .y_i    (y_q[8:4]),
      .sum_o  (high_pair),
      .carry_o(high_carry)
  );

  always_ff @(posedge clk_i) begin
    low_pair_q   <= low_pair;
    high_pair_q  <= high_pair;
    low_carry_q  <= low_carry;
    high_carry_q <= high_carry;
  end

  assign acc_shifted = {{8{acc_q[41]}}, acc_q[41:8]};
  // The bit appended below each sum carries into it.
  assign {sum_low, unused_low}   = {acc_shifted, 1'b1} + {{4{low_pair_q[37]}}, low_pair_q, low_carry_q};
  assign {sum_high, unused_high} = {sum_low[41:4], 1'b1} + {high_pair_q, high_carry_q};
  assign acc_next = {sum_high, sum_low[3:0]};

  always_ff @(posedge clk_i) acc_q <= clear_q ? 42'd0 : acc_next;

  // ---- reduction ----
  // acc_q has the weights 2^19 .. 2^-22 when it ends and low_q the next 39; q needs 2^1 and 2^0.
  logic [38:0] low_q;  // weights 2^-23 .. 2^-61
  logic [21:0] high_q;  // weights 2^-1 .. 2^-22
  logic sine, sign;
  logic [4:0] segment;  // |f| in 64ths
  logic [1:0] leading;  // see the bytes of f
  logic sine_q, sign_q;  // the quadrant needs the sine of f; of the result
  logic [4:0] segment_q;
  logic [1:0] leading_q;
  logic negative_f;

  fp_sincos_quadrant u_quadrant (
      .turns_i   (acc_q[23:0]),
      .cos_i     (cos_q),
      .negative_i(a_q[31]),
      .sine_o    (sine),
      .sign_o    (sign),
      .segment_o (segment),
      .leading_o (leading)
  );

  assign negative_f = high_q[21];

  always_ff @(posedge clk_i) begin
    if (reduce) low_q <= {acc_q[7:0], low_q[38:8]};
    if (split) begin
      high_q    <= acc_q[21:0];
      segment_q <= segment;
      leading_q <= leading;
      sine_q    <= sine;
      sign_q    <= sign;
    end
  end

  logic [6:0] offset, window, window_q;  // byte of 2/pi for the next step
  logic [7:0] byte_pi;

  fp_two_over_pi u_two_over_pi (
      .exponent_i(a_i[30:23]),
      .offset_o  (offset),
      .window_i  (window),
      .byte_o    (byte_pi)
  );

  assign window = ready_o ? offset : window_q;

  always_ff @(posedge clk_i) window_q <= {window[6:3] + 4'd1, window[2:0]};

  // Bytes of |f|: 0 has weights 2^2 .. 2^-5, 1 has 2^-6 .. 2^-13, .., 7 has 2^-54 .. 2^-61. Bits
  // 2^-2 .. 2^-6 are the segment and the others t, so that t starts in byte 1 without its top bit.
  // The product with f starts at the byte that holds the leading one below its top bit (or has it
  // next to its lowest bit).
  logic [2:0] byte_index;
  logic [7:0] byte_raw, byte_f;

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
    if (final_q && !sine_q) byte_f = last_byte_q ? 8'h40 : 8'h00;  // 2^6, see exp_q
    if (!final_q && byte_base_q == 3'd1) byte_f[7] = 1'b0;  // segment
  end

  always_ff @(posedge clk_i) y_q <= {reduce ? byte_pi : byte_f, y_q[8] && !load_q && !ready_o};

  // ---- cubic: byte 1 has seven bits of t, so a product with t is acc_q / 2^7 ----
  logic [33:0] coefficient;  // S(2.32)

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

  // ---- normalise, round; a_q is stable long before ----
  logic special;
  logic [31:0] special_result;
  fp_pkg::flags_t special_flags;

  fp_sincos_special u_special (
      .cos_i    (cos_q),
      .a_i      (a_q),
      .special_o(special),
      .result_o (special_result),
      .flags_o  (special_flags)
  );

  fp_sincos_result u_result (
      .clk_i,
      .magnitude_i     (acc_q[39:6]),
      .sine_i          (sine_q),
      .leading_i       (leading_q),
      .sign_i          (sign_q),
      .special_i       (special),
      .special_result_i(special_result),
      .special_flags_i (special_flags),
      .result_o,
      .flags_o
  );

endmodule
