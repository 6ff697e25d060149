// SPDX-License-Identifier: Apache-2.0
// fp_divsqrt_folded: binary32 quotient a / b or square root of a (sqrt_i), as fp_divsqrt, in less area.
// Contract: latency fp_pkg::FP_DIVSQRT_LATENCY register ranks, no stall; b_i is ignored for roots. An
// operation may start Interval clocks after the one before or later; an earlier one is the caller's
// error: both may give wrong results (simulation stops with a message), later ones are not affected.
// Clock 0 normalises b, clock 1 normalises a; 26 digits, two per clock: 2..8 in the first half of the
// recurrence, 9..14 in the second; clock 15 rounds and packs.
// With SYNTHESIS defined it has no check of the distance, which some synthesis tools refuse.
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
  // Invariant -D <= w < D. The result is exact if at the end w = 0 or what is to be restored makes it
  // zero: w = -D of a quotient, -(Q + 2^-k) of a root of k digits. Numbers w are S(2.25), D U(1.25);
  // digit k of a root is bit 25 - k of D.
  //
  // A quotient has its leading one in digit 0 or 1 and needs 24 digits from there on. The number of digits
  // below the binary point of a subnormal result is less by its distance to the normal numbers:
  // then clocks are left out, from the second one of either half on. The digits of the first one are always
  // made. Digits more than count, one or up to four, only decide whether the result is exact.
  // Roots have 25: they are exact with 13 digits or never, and keep the w of 24.

  localparam int unsigned Interval = 7;  // clocks an operation spends in the first half
  localparam int unsigned Ages = fp_pkg::FP_DIVSQRT_LATENCY;
  localparam int unsigned LoadFirst = 1;  // clocks at whose end a half takes an operation
  localparam int unsigned LoadSecond = LoadFirst + Interval;
  localparam int unsigned Final = 14;  // clock of the last digits

  // The first clock of a half takes w from where it is made, the others from the half's own register; the last
  // digit is the sign in a register, and whether it counts is decided a clock later: so nothing but registers is
  // after the two additions.

  // Clock k after that of the operands: valid_q[k]; root_q[k] if it is a root.
  logic [Ages:1] valid_q;
  logic [Final+1:1] root_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_q <= '0;
      root_q  <= '0;
    end else begin
      valid_q <= {valid_q[Ages-1:1], valid_i};
      root_q  <= {root_q[Final:1], valid_i && sqrt_i};
    end
  end

  // ---- clocks 0 and 1: unpack and normalise b, then a ----
  // A root has the operand b = 2^-126, which gives its exponent and needs no special result. What is not a
  // is taken for b: whether an operation starts, which is known late, decides nothing here. So nothing but a
  // register comes after the normalising of either.
  logic [31:0] a_q, operand;
  logic some_exp_q, all_exp_q;  // of a
  logic some_exp, all_exp, no_fraction, at_b;
  logic [23:0] sig;  // U(1.23), normalised
  logic [4:0] zeros;
  logic nan, snan, infinite, zero;

  always_ff @(posedge clk_i) begin
    a_q        <= a_i;
    some_exp_q <= |a_i[30:23];
    all_exp_q  <= &a_i[30:23];
  end

  assign at_b     = !valid_q[LoadFirst];
  assign operand  = at_b ? (sqrt_i ? 32'h0080_0000 : b_i) : a_q;
  assign some_exp = at_b ? sqrt_i || (|b_i[30:23]) : some_exp_q;
  assign all_exp  = at_b ? !sqrt_i && (&b_i[30:23]) : all_exp_q;

  // The hidden bit of a normal number makes its count zero.
  fp_normalise u_normalise (
      .value_i({some_exp, operand[22:0]}),
      .value_o(sig),
      .count_o(zeros),
      .zero_o (zero)
  );

  assign no_fraction = operand[22:0] == 23'd0;
  assign nan         = all_exp && !no_fraction;
  assign snan        = nan && !operand[22];
  assign infinite    = all_exp && no_fraction;

  // ---- clock 1: special results, start of the recurrence ----
  logic [23:0] sig_q;  // of b in clock 1, of a in clock 2
  logic [7:0] field_q;  // exponent field, 1 for a subnormal number; of b inverted
  logic [4:0] zeros_q;  // of a inverted
  logic of_b;  // exponent: of b in clock 1, of a in clock 2
  logic [9:0] exponent, exponent_b_q;  // S(10.0), biased: of a, less 1; of b, negated, plus 127
  logic sign_b_q, nan_q, snan_q, infinite_q, zero_q;
  logic sign, is_nan, is_invalid, is_inf, by_zero, is_zero;
  logic [26:0] start;  // in clock 2
  logic [23:0] divisor;
  logic field_first;  // first bit of the field
  logic double_q;  // m is twice the significand: the unbiased exponent is odd

  assign field_first = operand[23] || !some_exp;

  always_ff @(posedge clk_i) begin
    sig_q        <= sig;
    double_q     <= !root_q[LoadFirst] || field_first == zeros[0];
    field_q      <= {operand[30:24], field_first} ^ {8{at_b}};
    zeros_q      <= zeros ^ {5{!at_b}};
    exponent_b_q <= exponent;
    sign_b_q     <= operand[31];
    nan_q        <= nan;
    snan_q       <= snan;
    infinite_q   <= infinite;
    zero_q       <= zero;
  end

  assign of_b     = !valid_q[LoadFirst+1];
  assign exponent = {{2{of_b}}, field_q} + {{2{!of_b}}, 1'b1, {2{!of_b}}, zeros_q};

  assign sign       = sign_b_q ^ operand[31];
  assign is_invalid = snan_q || snan || (infinite_q && infinite) || (zero_q && zero)
                   || (root_q[LoadFirst] && operand[31] && !nan && !zero);
  assign is_nan     = nan_q || nan || is_invalid;
  assign is_inf     = infinite || zero_q;
  assign is_zero    = zero || infinite_q;
  assign by_zero    = zero_q && !infinite;

  assign start   = double_q ? {2'b00, sig_q, 1'b0} : {3'b000, sig_q};
  assign divisor = {!root_q[LoadFirst], sig_q[22:0]};

  // ---- clock 2: exponent ----
  // exp: biased exponent of a result with digit 0 = 0. If it is negative, 25 + exp digits count.
  logic [9:0] difference, exp;

  assign difference = exponent_b_q + exponent;
  assign exp        = root_q[LoadFirst+1] ? {difference[9], difference[9:1]} : difference;

  // ---- the two halves of the recurrence; half h holds an operation for Interval clocks ----
  logic [1:0] load, run;
  logic [1:0][26:0] w_q;
  logic [1:0][25:2] divisor_q;  // quotient: D; root: its digits so far
  logic [1:0][25:2] divisor_d;
  logic [1:0] sign_q, nan_s_q, invalid_s_q, inf_s_q, by_zero_s_q, zero_s_q;
  logic [1:0][9:0] exp_q;  // S(10.0)
  logic [1:0][26:0] w;  // of this clock
  logic [1:0][26:0] w_second;
  logic [1:0] previous, first;  // the last digit so far, the first one of this clock
  logic [13:1] digits_first_q;  // of the first half; digit 0 is the sign of w_q
  logic [24:1] digits_q;  // of the second half
  logic negative_q;  // sign of its last digit: digit 0
  logic [13:0] digits_first;
  logic [23:0] digits;
  logic choose_q, chosen_q, guard;  // the last digit that counts is chosen_q, not digit 0
  logic half;  // only the first digit of this clock counts
  logic few;  // fewer than four digits count
  logic [7:0] counted;  // of the four: what counts, what does not
  logic beyond_q;  // a digit that does not count is one ..
  logic spare_q;  // .. or digit 0, which does not count

  assign load = {valid_q[LoadSecond], valid_q[LoadFirst]};

  // Whether the digits of a clock count, of an operation with that exp, after so many clocks that
  // could be left out: 2 skipped + 2 + exp >= 0.
  function automatic logic enough(input logic [9:0] exp_of, input logic [3:0] skipped);
    logic [4:0] more;  // places from high to low: what is skipped suffices
    more[0] = 1'b1;
    for (int i = 0; i < 4; i++) begin
      more[i+1] = (skipped[i] && exp_of[i+1]) || ((skipped[i] || exp_of[i+1]) && more[i]);
    end
    enough = !exp_of[9] || ((&exp_of[8:5]) && more[4]);
  endfunction

  genvar h;
  generate
    for (h = 0; h < 2; h++) begin : gen_half
      localparam int unsigned Begin = h == 0 ? LoadFirst + 1 : LoadSecond + 1;
      localparam int unsigned End = h == 0 ? LoadSecond : Final;

      logic [25:0] place;  // of the first digit of this clock in the divisor of a root
      logic [25:0] known, known_second;  // digits, or D, to which the marks of D are added
      logic [25:0] late;  // the digit before those of this clock
      logic [25:0] addend_first, addend_second;
      logic [26:0] w_first;

      always_comb begin
        place = '0;
        for (int unsigned k = Begin; k <= End; k++) place[25-2*(k-2)] = root_q[k];
      end

      // What is added is D, inverted with a carry to subtract. That of a root is |digits 0..k-1|0|1|0..0|
      // where it is subtracted, |digits 0..k-1|1|1|0..0| where added: at 2^-k it has a one after the
      // inversion. Digit k is whether the next D is subtracted: where it enters, that has a zero.
      // The second digit of a clock enters the register a clock later, as the sign of w.
      assign previous[h]   = !w[h][26];
      assign late          = (place << 1) & {26{previous[h]}};
      assign known         = {divisor_q[h], 2'b00};
      assign addend_first  = (((known | (place >> 1)) ^ {26{previous[h]}}) & ~(place << 1)) | place;
      assign w_first       = {w[h][25:0], previous[h]} + {previous[h], addend_first};
      assign first[h]      = !w_first[26];
      assign known_second  = known | late | (place >> 2);
      assign addend_second = ((known_second ^ {26{first[h]}}) & ~place) | (place >> 1);
      assign w_second[h]   = {w_first[25:0], first[h]} + {first[h], addend_second};
      assign divisor_d[h]  = divisor_q[h] | late[25:2] | (place[25:2] & {24{first[h]}});
    end
  endgenerate

  // First half.
  logic [3:0] skipped_first;  // clocks before this one in which digits may be left out

  assign w[0] = valid_q[LoadFirst+1] ? start : w_q[0];
  assign skipped_first = {1'b0, valid_q[8], valid_q[7] || valid_q[6], valid_q[7] || valid_q[5]};
  assign run[0] = valid_q[LoadFirst+1]
               || (valid_q[3] ? !exp_q[0][9] : enough(exp_q[0], skipped_first));

  always_ff @(posedge clk_i) begin
    if (run[0]) w_q[0] <= w_second[0];
    if (valid_q[LoadFirst+1]) digits_first_q <= {12'd0, first[0]};
    else if (run[0]) digits_first_q <= {digits_first[11:0], first[0]};
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

  assign digits_first = {digits_first_q, !w_q[0][26]};
  assign digits       = {digits_q[23:1], !negative_q};
  assign w[1] = valid_q[LoadSecond+1] ? w_q[0] : w_q[1];
  assign skipped_second = {valid_q[13] || valid_q[14],
                           valid_q[10] || valid_q[11] || valid_q[12],
                           valid_q[11] || valid_q[12],
                           valid_q[10] || valid_q[12] || valid_q[14]};
  assign run[1] = valid_q[LoadSecond+1] || enough(exp_q[1], skipped_second);

  // Digit 0 is in digits[23] if no clock was left out.
  assign half = valid_q[Final]
             && (!exp_q[1][9] && (|exp_q[1][8:0]) ? digits[23] : !exp_q[1][0]);

  // Four digits are always made. Where fewer count, below -21, the others leave digits in the last clock.
  assign few = exp_q[1][9] && exp_q[1][8:0] < 9'h1eb;
  always_comb begin
    case (exp_q[1])
      10'h3ea: counted = {1'b0, digits[3:0], 3'b000};   // -22: three
      10'h3e9: counted = {2'b00, digits[3:0], 2'b00};   // -23: two
      10'h3e8: counted = {3'b000, digits[3:0], 1'b0};   // -24: one
      default: counted = 8'h0f;                           // none, and the result is not exact
    endcase
  end

  always_ff @(posedge clk_i) begin
    if (run[1] && !root_q[Final]) w_q[1] <= w_second[1];
    if (valid_q[LoadSecond+1]) digits_q <= {9'd0, digits_first, first[1]};
    else if (run[1]) digits_q <= half ? digits : {digits[22:0], first[1]};
    else if (valid_q[Final] && few) digits_q[3:1] <= counted[7:5];
    if (run[1]) negative_q <= w_second[1][26];
    choose_q <= run[1] ? half : valid_q[Final] && few;
    chosen_q <= run[1] ? first[1] : counted[4];
    beyond_q <= few && (|counted[3:0]);
    spare_q  <= !few && half && !root_q[Final];
    // The digits that enter in clock LoadSecond are those of bits 14 and 13.
    if (load[1]) begin
      divisor_q[1] <= divisor_q[0] | ({11'd0, previous[0], first[0], 11'd0} & {24{root_q[LoadSecond]}});
    end else begin
      divisor_q[1] <= divisor_d[1];
    end
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
  logic [8:0] exp_round_q;  // U(9.0), biased, 0 for a subnormal result
  logic [26:0] restore;
  logic exact, sticky;
  logic [31:0] rounded, result;
  fp_pkg::flags_t flags;

  always_ff @(posedge clk_i) begin
    exp_round_q <= exp_q[1][9] ? 9'd0 : exp_q[1][8:0] + {8'd0, half};
  end

  // A sum is zero if each of its bits, without the carry, is whether there are ones in the bits below.
  assign restore = {1'b0, divisor_q[1], root_q[Final+1], 1'b0};
  assign exact   = w_q[1] == 27'd0 || (w_q[1] ^ restore) == {w_q[1][25:0] | restore[25:0], 1'b0};

  // Whether the result is exact is known late. So it is rounded as if it were not, and mended: of a tie the
  // last bit becomes zero, which is even, and nothing is raised by a result that is exact.
  assign guard  = choose_q ? chosen_q : digits[0];
  assign sticky = !exact || beyond_q || (spare_q && digits[0]);

  fp_pack u_pack (
      .sign_i   (sign_q[1]),
      .exp_i    (exp_round_q),
      .sig_i    (digits_q),
      .guard_i  (guard),
      .round_i  (1'b0),
      .sticky_i (1'b1),
      .exact_i  (!sticky && !guard && !(exp_round_q[8] || (&exp_round_q[7:0]))),
      .nan_i    (nan_s_q[1]),
      .invalid_i(invalid_s_q[1]),
      .inf_i    (inf_s_q[1]),
      .by_zero_i(by_zero_s_q[1]),
      .zero_i   (zero_s_q[1]),
      .result_o (rounded),
      .flags_o  (flags)
  );

  assign result = {rounded[31:1], rounded[0] && (sticky || !guard)};

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
