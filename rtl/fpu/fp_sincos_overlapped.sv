// SPDX-License-Identifier: Apache-2.0
// fp_sincos_overlapped: sine or cosine of a binary32 angle, three operations at a time.
// Contract: the results and flags of fp_sincos, bit for bit. Accepts while ready_o, that is every 11
// cycles or less often; latency fp_pkg::FP_SINCOS_OVERLAPPED_LATENCY register ranks.
// |a| <= 256 has an error below 0.532 ulp. Multipliers of 24 x 8 bits for |a| 2/pi and of 34 x 16 bits for
// the rest; an operation takes the second one in eight of eleven steps, so that two take turns in it.
module fp_sincos_overlapped (
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

  // Cycles of an operation after the one that accepts it, and the counter that is 1 .. 10 then:
  //    1..10  reduce_q   |a| 2/pi = q + f, eight bits of 2/pi per cycle, in cycles 1 .. 9
  //   11      split_q    quadrant, |f| <= 1/2 quarter turns with 61 fraction bits
  //   12..21  cubic_q    Horner's rule for sin(pi/2 f)/f or cos(pi/2 f) on one of 32 segments;
  //                      t has 15, 23 and 31 bits in the three products
  //   22..31  last_q     times f (its five bytes from the leading one on), or times one
  //   32, 33             normalise; round
  // Where a factor of fp_sincos has an odd number of bytes, a zero byte is appended. A sum that is cut
  // by 16 bits is the one cut by 8 bits, added to and cut by 8 bits again, so that no bit differs:
  // floor((floor(a / 2^8) + b) / 2^8) = floor((a + 2^8 b) / 2^16).
  //
  // Cycles in which a step of the second multiplier has its factors in x_q and y_q, set the cycle
  // before. Its rows are then added in pairs, a cycle later all together, and another one later
  // accumulated, which completes the sum two cycles after the last step:
  //   c3 t          16, or 26 of the operation before if that is one of its own 13, 14, 15
  //   (c2 + ..) t   19, 20
  //   (c1 + ..) t   23, 24
  //   (c0 + ..) f   27, 28, 29
  // An operation that follows after 11 cycles or more, whatever their number, finds its steps free:
  // its 19 is after 29, and so is its 16 where its 13 is after 26.

  localparam int unsigned Interval = 11;
  localparam logic [3:0] LAST = 4'(Interval - 1);

  // ---- control ----
  logic [3:0] reduce_q, cubic_q, last_q;  // zero is idle
  logic accept, split_q;
  logic [1:0] round_q;  // cycles 32 and 33

  function automatic logic [3:0] next_step(input logic begins, input logic [3:0] step);
    if (begins) next_step = 4'd1;
    else next_step = (step == 4'd0 || step == LAST) ? 4'd0 : step + 4'd1;
  endfunction

  assign ready_o = reduce_q == 4'd0;
  assign accept  = ready_o && valid_i;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      reduce_q <= 4'd0;
      split_q  <= 1'b0;
      cubic_q  <= 4'd0;
      last_q   <= 4'd0;
      round_q  <= 2'b00;
      valid_o  <= 1'b0;
    end else begin
      reduce_q <= next_step(accept, reduce_q);
      split_q  <= reduce_q == LAST;
      cubic_q  <= next_step(split_q, cubic_q);
      last_q   <= next_step(cubic_q == LAST, last_q);
      round_q  <= {round_q[0], last_q == LAST};
      valid_o  <= round_q[1];
    end
  end

  // ---- reduction ----
  logic cos_q;
  logic [31:0] a_q;
  logic [6:0] offset, window, window_q;
  logic [7:0] byte_pi;
  logic [8:0] digits_q;  // a byte of 2/pi, the top bit of the one before
  logic [28:0] low_pair, low_pair_q, high_pair, high_pair_q;
  logic low_carry, low_carry_q, high_carry, high_carry_q;
  logic [32:0] angle_q, angle_sum_low;  // S(.8) in units of the significand
  logic [28:0] angle_sum_high;
  logic [38:0] low_q;  // weights 2^-23 .. 2^-61
  logic unused_angle_low, unused_angle_high;

  always_ff @(posedge clk_i) begin
    if (accept) begin
      cos_q <= cos_i;
      a_q   <= a_i;
    end
  end

  fp_two_over_pi u_two_over_pi (
      .exponent_i(a_i[30:23]),
      .offset_o  (offset),
      .window_i  (window),
      .byte_o    (byte_pi)
  );

  assign window = ready_o ? offset : window_q;

  fp_booth_pair #(
      .Width(25)
  ) u_low_pair (
      .x_i    ({2'b01, a_q[22:0]}),
      .y_i    (digits_q[4:0]),
      .sum_o  (low_pair),
      .carry_o(low_carry)
  );

  fp_booth_pair #(
      .Width(25)
  ) u_high_pair (
      .x_i    ({2'b01, a_q[22:0]}),
      .y_i    (digits_q[8:4]),
      .sum_o  (high_pair),
      .carry_o(high_carry)
  );

  always_ff @(posedge clk_i) begin
    window_q     <= {window[6:3] + 4'd1, window[2:0]};
    digits_q     <= {byte_pi, digits_q[8] && !ready_o};
    low_pair_q   <= low_pair;
    low_carry_q  <= low_carry;
    high_pair_q  <= high_pair;
    high_carry_q <= high_carry;
  end

  // The bit appended below each sum carries into it.
  assign {angle_sum_low, unused_angle_low} = {{8{angle_q[32]}}, angle_q[32:8], 1'b1}
                                           + {{4{low_pair_q[28]}}, low_pair_q, low_carry_q};
  assign {angle_sum_high, unused_angle_high} = {angle_sum_low[32:4], 1'b1}
                                             + {high_pair_q, high_carry_q};

  always_ff @(posedge clk_i) begin
    angle_q <= (reduce_q == 4'd1) ? '0 : {angle_sum_high, angle_sum_low[3:0]};
    if (reduce_q >= 4'd6) low_q <= {angle_q[7:0], low_q[38:8]};  // until cycle 17 of the next
  end

  // ---- split ----
  logic sine, sign, sine_q, sign_q, negative_q;
  logic [4:0] segment, segment_q;
  logic [1:0] leading, leading_q;
  logic special, special_q;
  logic [31:0] special_result;
  fp_pkg::flags_t special_flags, special_flags_q;
  logic [31:0] t_q;  // bytes 1 .. 4 of f, or the special result

  fp_sincos_quadrant u_quadrant (
      .turns_i   (angle_q[23:0]),
      .cos_i     (cos_q),
      .negative_i(a_q[31]),
      .sine_o    (sine),
      .sign_o    (sign),
      .segment_o (segment),
      .leading_o (leading)
  );

  fp_sincos_special u_special (
      .cos_i    (cos_q),
      .a_i      (a_q),
      .special_o(special),
      .result_o (special_result),
      .flags_o  (special_flags)
  );

  always_ff @(posedge clk_i) begin
    if (split_q) begin
      sine_q          <= sine;
      sign_q          <= sign;
      negative_q      <= angle_q[21];
      segment_q       <= segment;
      leading_q       <= leading;
      special_q       <= special;
      special_flags_q <= special_flags;
      t_q             <= special ? special_result : {angle_q[16:0], low_q[38:24]};
    end
  end

  // ---- the first product, c3 t: as soon as the second multiplier is free ----
  logic first_load, first_loaded_q;
  logic [2:0] first_step_q;  // its step, its rows added, its sum complete

  assign first_load = cubic_q != 4'd0 && !first_loaded_q && (last_q == 4'd4 || cubic_q == 4'd4);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      first_loaded_q <= 1'b0;
      first_step_q   <= '0;
    end else begin
      first_loaded_q <= (first_loaded_q || first_load) && cubic_q != LAST;
      first_step_q   <= {first_step_q[1:0], first_load};
    end
  end

  // ---- coefficients, read two cycles before they are added ----
  logic [1:0] order;
  logic [33:0] coefficient, coefficient_q;

  always_comb begin
    if (!first_loaded_q) order = 2'd3;
    else if (!cubic_q[3]) order = 2'd2;
    else order = {1'b0, !cubic_q[1]};  // cycles 19 and 20; 21
  end

  fp_sincos_memory u_memory (
      .clk_i,
      .cos_i        (split_q ? !sine : !sine_q),
      .segment_i    (split_q ? segment : segment_q),
      .order_i      (order),
      .coefficient_o(coefficient)
  );

  always_ff @(posedge clk_i) begin  // c0 from cycle 23 to 26
    if (!(last_q == 4'd2 || last_q == 4'd3 || last_q == 4'd4)) coefficient_q <= coefficient;
  end

  // ---- the last factor: five bytes of |f| from the leading one on, or 2^6 ----
  logic sine_last_q, sign_last_q, negative_last_q, special_last_q;
  logic [1:0] leading_last_q;
  logic [31:0] special_result_q;
  fp_pkg::flags_t special_flags_last_q;
  logic [39:0] factor_q;
  logic [63:0] f;  // bytes 0 .. 7, before the complement

  assign f = {{4{negative_q}}, segment_q[4:1] ^ {4{negative_q}}, t_q, low_q[23:0]};

  always_ff @(posedge clk_i) begin
    if (cubic_q == 4'd6) begin  // the operation before takes its last byte
      if (!sine_q) factor_q <= {8'h40, 32'd0};
      else begin
        case (leading_q)
          2'd0:    factor_q <= f[63:24];
          2'd1:    factor_q <= f[55:16];
          2'd2:    factor_q <= f[47:8];
          default: factor_q <= f[39:0];
        endcase
      end
    end
    if (last_q == 4'd1) begin
      sine_last_q          <= sine_q;
      sign_last_q          <= sign_q;
      negative_last_q      <= negative_q && sine_q;
      leading_last_q       <= leading_q;
      special_last_q       <= special_q;
      special_result_q     <= t_q;
      special_flags_last_q <= special_flags_q;
    end
  end

  // ---- second multiplier: factors ----
  logic load_held, load_sum, overlap;
  logic [33:0] x_q, sum;  // S(2.32)
  logic [21:0] hold_q;  // c2 + c3 t, S(.32), until x_q is free
  logic [14:0] t_word_q;  // t_q may be the next operation's in cycle 23
  logic t_negative_q;
  logic [16:0] y_q;
  logic [15:0] word;

  assign load_held = cubic_q == 4'd7 && !first_step_q[2];
  assign load_sum  = cubic_q == 4'd7 || last_q == 4'd1 || last_q == 4'd5;

  always_ff @(posedge clk_i) begin
    if (first_step_q[2]) hold_q <= sum[21:0];
    if (first_load) x_q <= {21'd0, coefficient[12:0]};
    else if (load_held) x_q <= {{12{hold_q[21]}}, hold_q};
    else if (load_sum) x_q <= sum;
  end

  // Byte 1 of f starts with a bit of the segment, which is not one of t.
  assign overlap = cubic_q == 4'd8 || last_q == 4'd2 || last_q == 4'd6 || last_q == 4'd7;

  always_comb begin
    case (last_q)
      4'd1:    word = t_q[15:0] ^ {16{negative_q}};
      4'd2:    word = {1'b0, t_word_q ^ {15{t_negative_q}}};
      4'd5:    word = {factor_q[7:0] ^ {8{negative_last_q}}, 8'd0};
      4'd6:    word = factor_q[23:8] ^ {16{negative_last_q}};
      4'd7:    word = factor_q[39:24] ^ {16{negative_last_q}};
      default: begin
        if (cubic_q == 4'd7) word = {t_q[15:8] ^ {8{negative_q}}, 8'd0};
        else word = {1'b0, t_q[30:16] ^ {15{negative_q}}};
      end
    endcase
  end

  always_ff @(posedge clk_i) begin
    y_q <= {word, y_q[16] && overlap};
    if (last_q == 4'd1) begin
      t_word_q     <= t_q[30:16];
      t_negative_q <= negative_q;
    end
  end

  // ---- second multiplier: accumulator / 2^16 + x_q * word, least significant word first ----
  logic [3:0][37:0] pair, pair_q;
  logic [3:0] carry, carry_q;
  logic [37:0] low_upper, high_upper;  // pairs 0 and 1, 2 and 3, above their lowest four bits
  logic [41:0] rows_upper;
  logic [49:0] rows_q;  // x_q * word without a carry
  logic rows_carry_q, first_q;
  logic [49:0] total;
  logic [41:0] acc_q;  // its upper part: S(10.32) in units of x_q
  logic unused_rows_low, unused_rows_high, unused_rows, unused_acc, unused_total;

  genvar p;
  generate
    for (p = 0; p < 4; p++) begin : gen_pair
      fp_booth_pair u_pair (
          .x_i    (x_q),
          .y_i    (y_q[4*p+:5]),
          .sum_o  (pair[p]),
          .carry_o(carry[p])
      );
    end
  endgenerate

  assign {low_upper, unused_rows_low} = {{4{pair_q[0][37]}}, pair_q[0][37:4], 1'b1}
                                      + {pair_q[1], carry_q[1]};
  assign {high_upper, unused_rows_high} = {{4{pair_q[2][37]}}, pair_q[2][37:4], 1'b1}
                                        + {pair_q[3], carry_q[3]};
  assign {rows_upper, unused_rows} = {{8{low_upper[37]}}, low_upper[37:4], 1'b1}
                                   + {high_upper, pair_q[2][3:0], carry_q[2]};

  always_ff @(posedge clk_i) begin
    pair_q       <= pair;
    carry_q      <= carry;
    rows_q       <= {rows_upper, low_upper[3:0], pair_q[0][3:0]};
    rows_carry_q <= carry_q[0];
    first_q      <= first_step_q[1] || cubic_q == 4'd9 || last_q == 4'd3 || last_q == 4'd7;
    acc_q        <= total[49:8];
  end

  assign {total, unused_acc} = {{16{acc_q[41] && !first_q}}, acc_q[41:8] & {34{!first_q}}, 1'b1}
                               + {rows_q, rows_carry_q};
  assign sum = coefficient_q + total[48:15];     // seven bits of t in its first byte

  // ---- normalise, round ----
  fp_sincos_result u_result (
      .clk_i,
      .magnitude_i     (acc_q[39:6]),
      .sine_i          (sine_last_q),
      .leading_i       (leading_last_q),
      .sign_i          (sign_last_q),
      .special_i       (special_last_q),
      .special_result_i(special_result_q),
      .special_flags_i (special_flags_last_q),
      .result_o,
      .flags_o
  );

  assign unused_total = ^{total[7:0], acc_q[5:0]};

endmodule
