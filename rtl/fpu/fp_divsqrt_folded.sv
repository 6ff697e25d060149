// SPDX-License-Identifier: Apache-2.0
// fp_divsqrt_folded: binary32 quotient a / b or square root of a (sqrt_i), as fp_divsqrt, in less area.
// Contract: latency fp_pkg::FP_DIVSQRT_LATENCY register ranks, no stall; b_i is ignored for roots. An
// operation may start Interval clocks after the one before or later; an earlier one is the caller's
// error: both may give wrong results (simulation stops with a message), later ones are not affected.
// Clock 0 normalises a, clock 1 normalises b; 26 digits, two per clock: 2..8 in the first half of the
// recurrence, 9..14 in the second; clock 15 rounds and packs.
module fp_divsqrt_folded (
    input  logic           clk_i,
    input  logic           rst_ni,
    input  logic           valid_i,
    input  logic           sqrt_i,
    input  logic [31:0]    a_i,
    input  logic [31:0]    b_i,
    output logic           valid_o,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  // Recurrence (Ercegovac and Lang, Digital Arithmetic, ch. 5, 6), digit k = 0, 1, .. of weight 2^-k,
  // not restoring: w = 2 w - D for w >= 0, else 2 w + D; the digit is one if the new w >= 0.
  //   quotient: w starts at a/2, D = b with a, b in [1, 2).
  //   root: w starts at m/4, m in [1, 4); Q is the root truncated to the digits before k;
  //         D = Q + 2^-(k+1) where it is subtracted, Q + 3 2^-(k+1) where it is added.
  // Invariant -D <= w < D. w is held as u = w or, for w < 0 (neg), u = -w - 1, w inverted: so
  //   2 u + neg - D = t;  u = t, inverted for t < 0;  neg changes for t < 0
  // takes one subtraction and one inversion of a digit. The result is exact if w = 0 or w = -D at the
  // end. Numbers u, D are U(1.25); digit k of a root is bit 25 - k of D.
  //
  // A quotient has its leading one in digit 0 or 1 and needs 24 digits from there on. The number of digits
  // below the binary point of a subnormal result is less by its distance to the normal numbers:
  // then clocks are left out, from the first one of either half on. An odd number of digits ends with half a step.

  localparam int unsigned Interval = 7;   // clocks an operation spends in the first half
  localparam int unsigned Ages = fp_pkg::FP_DIVSQRT_LATENCY;
  localparam int unsigned LoadFirst = 1;  // clocks at whose end a half takes an operation
  localparam int unsigned LoadSecond = LoadFirst + Interval;
  localparam int unsigned Final = 14;     // clock of the last digits

  // Clock k after that of the operands: valid_q[k]; root_q[k] if it is a root.
  logic [Ages:1]      valid_q;
  logic [Final:1]     root_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_q <= '0;
      root_q  <= '0;
    end else begin
      valid_q <= {valid_q[Ages-1:1], valid_i};
      root_q  <= {root_q[Final-1:1], valid_i && sqrt_i};
    end
  end

  // ---- clocks 0 and 1: unpack and normalise a, then b ----
  // A root has the operand b = 2^-126, which gives its exponent and needs no special result.
  logic [31:0] b_q, operand;
  logic        some_exp, all_exp, no_fraction;
  logic [23:0] sig;                     // U(1.23), normalised
  logic [4:0]  zeros;
  logic [9:0]  exponent;                // S(10.0), biased: of a, less 1; of b, negated, plus 127
  logic        nan, snan, infinite, zero;

  always_ff @(posedge clk_i) b_q <= sqrt_i ? 32'h0080_0000 : b_i;

  assign operand  = valid_i ? a_i : b_q;
  assign some_exp = |operand[30:23];
  assign all_exp  = &operand[30:23];

  // Infinity loses its hidden bit, so that no_fraction tells zero and infinity from other numbers.
  fp_normalise normalise (
      .value_i({some_exp && !all_exp, operand[22:0]}),
      .value_o(sig),
      .count_o(zeros),
      .zero_o (no_fraction)
  );

  assign exponent = ({2'b00, operand[30:24], operand[23] || !some_exp} ^ {10{!valid_i}})
                  + {{2{valid_i}}, 1'b1, {2{valid_i}}, zeros ^ {5{valid_i}}};
  assign nan      = all_exp && !no_fraction;
  assign snan     = nan && !operand[22];
  assign infinite = all_exp && no_fraction;
  assign zero     = !some_exp && no_fraction;

  // ---- clock 1: special results, start of the recurrence ----
  logic [23:0] sig_q;
  logic [9:0]  exponent_q, exponent_a_q;
  logic        sign_a_q, nan_q, snan_q, infinite_q, zero_q;
  logic        sign, is_nan, is_invalid, is_inf, by_zero, is_zero;
  logic [25:0] start, divisor;
  logic        double;                  // m is twice the significand: the unbiased exponent is odd

  always_ff @(posedge clk_i) begin
    sig_q        <= sig;
    exponent_q   <= exponent;
    exponent_a_q <= exponent_q;
    sign_a_q     <= operand[31];
    nan_q        <= nan;
    snan_q       <= snan;
    infinite_q   <= infinite;
    zero_q       <= zero;
  end

  assign sign       = sign_a_q ^ operand[31];
  assign is_invalid = snan_q || snan || (infinite_q && infinite) || (zero_q && zero)
                   || (root_q[LoadFirst] && sign_a_q && !nan_q && !zero_q);
  assign is_nan     = nan_q || nan || is_invalid;
  assign is_inf     = infinite_q || zero;
  assign is_zero    = zero_q || infinite;
  assign by_zero    = zero && !infinite_q;

  assign double  = !root_q[LoadFirst] || exponent_q[0];
  assign start   = double ? {1'b0, sig_q, 1'b0} : {2'b00, sig_q};
  assign divisor = {!root_q[LoadFirst], sig[22] || root_q[LoadFirst], sig[21:0], 2'b00};

  // ---- clock 2: exponent ----
  // exp: biased exponent of a result with digit 0 = 0. If it is negative, 25 + exp digits count.
  logic [9:0] difference, exp;

  assign difference = exponent_a_q + exponent_q;
  assign exp        = root_q[LoadFirst+1] ? {difference[9], difference[9:1]} : difference;

  // ---- the two halves of the recurrence; half h holds an operation for Interval clocks ----
  logic [1:0]       load, run;
  logic [1:0][25:0] u_q, divisor_q, divisor_d;
  logic [1:0]       neg_q, sign_q, nan_s_q, invalid_s_q, inf_s_q, by_zero_s_q, zero_s_q;
  logic [1:0][9:0]  exp_q;              // S(10.0)
  logic [1:0][25:0] u_first;
  logic [1:0][26:0] t_second;           // S(2.25)
  logic [1:0]       neg_first, neg_second;
  logic [11:0]      digits_first_q;     // of the first half but for the last clock
  logic [24:0]      digits_q;           // of the second half
  logic             t_sign;
  logic             half;               // only the first digit of this clock

  assign load = {valid_q[LoadSecond], valid_q[LoadFirst]};

  // Whether the digits of a clock count, of an operation with that exp, after so many clocks that
  // could be left out: 2 skipped + 2 + exp >= 0.
  function automatic logic enough(input logic [9:0] exp_of, input logic [3:0] skipped);
    logic [4:0] more;                   // places from high to low: what is skipped suffices
    more[0] = 1'b1;
    for (int i = 0; i < 4; i++) begin
      more[i+1] = (skipped[i] && exp_of[i+1]) || ((skipped[i] || exp_of[i+1]) && more[i]);
    end
    enough = !exp_of[9] || ((&exp_of[8:5]) && more[4]);
  endfunction

  for (genvar h = 0; h < 2; h++) begin : gen_half
    localparam int unsigned Begin = h == 0 ? LoadFirst + 1 : LoadSecond + 1;
    localparam int unsigned End = h == 0 ? LoadSecond : Final;

    logic [25:0] place, place_second;   // of the digits of this clock in the divisor of a root
    logic [25:0] divisor_second;
    logic [26:0] t_first;               // S(2.25)

    always_comb begin
      place = '0;
      for (int unsigned k = Begin; k <= End; k++) place[25-2*(k-2)] = root_q[k];
      // The last divisor decides whether the result is exact; it gets no second digit.
      place_second    = {1'b0, place[25:1]};
      place_second[0] = 1'b0;
    end

    // Root: D is |digits 0..k-1|neg|1|0..0|, the one at 2^-(k+1). The next one gets digit k in the
    // place of neg, then again neg, then a one. A new digit is the new neg, inverted.
    assign t_first        = {u_q[h], neg_q[h]} - {1'b0, divisor_q[h]};
    assign u_first[h]     = t_first[25:0] ^ {26{t_first[26]}};
    assign neg_first[h]   = neg_q[h] ^ t_first[26];
    assign divisor_second = (divisor_q[h] & ~(place | (place >> 1))) | (place >> 2)
                          | (place & {26{!neg_first[h]}}) | ((place >> 1) & {26{neg_first[h]}});
    assign t_second[h]    = {u_first[h], neg_first[h]} - {1'b0, divisor_second};
    assign neg_second[h]  = neg_first[h] ^ t_second[h][26];
    assign divisor_d[h]   = (divisor_second & ~(place_second | (place >> 2))) | (place >> 3)
                          | (place_second & {26{!neg_second[h]}})
                          | ((place >> 2) & {26{neg_second[h]}});
  end

  // First half: an operation leaves it with the digits of clock LoadSecond, so these are never left out.
  logic [3:0] skipped_first;            // clocks before this one in which digits may be left out

  assign skipped_first = {1'b0, valid_q[7], valid_q[6] || valid_q[5], valid_q[6] || valid_q[4]};
  assign run[0] = valid_q[2] ? !exp[9] : enough(exp_q[0], skipped_first);

  always_ff @(posedge clk_i) begin
    if (load[0]) begin
      u_q[0]         <= start;
      neg_q[0]       <= 1'b0;
      digits_first_q <= 12'd0;
    end else if (run[0]) begin
      u_q[0]         <= t_second[0][25:0] ^ {26{t_second[0][26]}};
      neg_q[0]       <= neg_second[0];
      digits_first_q <= {digits_first_q[9:0], !neg_first[0], !neg_second[0]};
    end
    divisor_q[0] <= load[0] ? divisor : divisor_d[0];
    if (valid_q[2]) exp_q[0] <= exp;
    if (load[0]) begin
      sign_q[0]      <= sign;
      nan_s_q[0]     <= is_nan;
      invalid_s_q[0] <= is_invalid;
      inf_s_q[0]     <= is_inf;
      by_zero_s_q[0] <= by_zero;
      zero_s_q[0]    <= is_zero;
    end
  end

  // Second half.
  logic [3:0] skipped_second;

  assign skipped_second = {valid_q[12] || valid_q[13] || valid_q[14],
                           valid_q[9] || valid_q[10] || valid_q[11],
                           valid_q[10] || valid_q[11] || valid_q[14],
                           valid_q[9] || valid_q[11] || valid_q[13]};
  assign run[1] = enough(exp_q[1], skipped_second);

  // Digit 0 is in digits_q[23] if no clock was left out.
  assign half = valid_q[Final]
             && (!exp_q[1][9] && (|exp_q[1][8:0]) ? digits_q[23] : !exp_q[1][0]);

  assign t_sign = load[1] ? t_second[0][26] : t_second[1][26];

  always_ff @(posedge clk_i) begin
    if (load[1] || run[1]) begin
      u_q[1]   <= half ? u_first[1] : (load[1] ? t_second[0][25:0] : t_second[1][25:0]) ^ {26{t_sign}};
      neg_q[1] <= half ? neg_first[1] : load[1] ? neg_second[0] : neg_second[1];
      if (load[1]) digits_q <= {11'd0, digits_first_q, !neg_first[0], !neg_second[0]};
      else if (half) digits_q <= {digits_q[23:0], !neg_first[1]};
      else digits_q <= {digits_q[22:0], !neg_first[1], !neg_second[1]};
    end
    divisor_q[1] <= load[1] ? divisor_d[0] : divisor_d[1];
    if (load[1]) begin
      exp_q[1]       <= exp_q[0];
      sign_q[1]      <= sign_q[0];
      nan_s_q[1]     <= nan_s_q[0];
      invalid_s_q[1] <= invalid_s_q[0];
      inf_s_q[1]     <= inf_s_q[0];
      by_zero_s_q[1] <= by_zero_s_q[0];
      zero_s_q[1]    <= zero_s_q[0];
    end
  end

  // ---- clock 15: round, pack, special results ----
  logic [8:0]     exp_round_q;          // U(9.0), biased, 0 for a subnormal result
  logic [25:0]    carry;
  logic           exact, one_digit, no_digit;
  logic [31:0]    result;
  fp_pkg::flags_t flags;

  always_ff @(posedge clk_i) begin
    exp_round_q <= exp_q[1][9] ? 9'd0 : exp_q[1][8:0] + {8'd0, half};
  end

  // w = -D if u + 1 = D: there a carry leaves bit i where u has a one and D a zero.
  assign carry = {u_q[1][24:0] & ~divisor_q[1][24:0], 1'b1};
  assign exact = neg_q[1] ? (u_q[1] ^ carry) == divisor_q[1] : u_q[1] == 26'd0;

  // Two digits are there at least, also where one or none counts.
  assign one_digit = exp_q[1] == 10'h3e8;                                  // -24
  assign no_digit  = exp_q[1][9] && !((&exp_q[1][8:5]) && (|exp_q[1][4:3]));  // less

  fp_pack pack (
      .sign_i   (sign_q[1]),
      .exp_i    (exp_round_q),
      .sig_i    ({digits_q[24:2], digits_q[1] && !one_digit && !no_digit}),
      .guard_i  (!no_digit && (one_digit ? digits_q[1] : digits_q[0])),
      .round_i  (1'b0),
      .sticky_i (!exact || no_digit || (one_digit && digits_q[0])),
      .exact_i  (1'b0),
      .nan_i    (nan_s_q[1]),
      .invalid_i(invalid_s_q[1]),
      .inf_i    (inf_s_q[1]),
      .by_zero_i(by_zero_s_q[1]),
      .zero_i   (zero_s_q[1]),
      .result_o (result),
      .flags_o  (flags)
  );

  // Zero while there is no result, so that results of several units can be joined by OR.
  always_ff @(posedge clk_i) begin
    result_o <= valid_q[Ages-1] ? result : 32'd0;
    flags_o  <= valid_q[Ages-1] ? flags : '0;
  end

  assign valid_o = valid_q[Ages];

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (valid_i && (|valid_q[Interval-1:1])) begin
      $error("fp_divsqrt_folded: an operation starts less than %0d clocks after another", Interval);
    end
  end
`endif

endmodule
