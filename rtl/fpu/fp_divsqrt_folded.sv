// SPDX-License-Identifier: Apache-2.0
// fp_divsqrt_folded: binary32 quotient a / b or square root of a (sqrt_i), as fp_divsqrt, in less area.
// Contract: latency fp_pkg::FP_DIVSQRT_LATENCY register ranks, no stall; b_i is ignored for roots. An
// operation may start Interval clocks after the one before or later; an earlier one is the caller's
// error: both may give wrong results (simulation stops with a message), later ones are not affected.
// Clock 0 normalises a, clock 1 normalises b; 26 digits, two per clock: 2..8 in the first half of the
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
  // then clocks are left out, from the first one of either half on. Where the
  // number of digits is odd, one digit more is made, which only tells whether the result is exact.
  // Roots have 25: they are exact with 13 digits or never, and keep the w of 24.

  localparam int unsigned Interval = 7;   // clocks an operation spends in the first half
  localparam int unsigned Ages = fp_pkg::FP_DIVSQRT_LATENCY;
  localparam int unsigned LoadFirst = 1;  // clocks at whose end a half takes an operation
  localparam int unsigned LoadSecond = LoadFirst + Interval;
  localparam int unsigned Final = 14;     // clock of the last digits

  // Clock k after that of the operands: valid_q[k]; root_q[k] if it is a root.
  logic [Ages:1]      valid_q;
  logic [Final+1:1]   root_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_q <= '0;
      root_q  <= '0;
    end else begin
      valid_q <= {valid_q[Ages-1:1], valid_i};
      root_q  <= {root_q[Final:1], valid_i && sqrt_i};
    end
  end

  // ---- clocks 0 and 1: unpack and normalise a, then b ----
  // A root has the operand b = 2^-126, which gives its exponent and needs no special result. What is not b
  // is taken for a: whether an operation starts, which is known late, decides nothing here.
  logic [31:0] b_q, operand;
  logic        some_exp_q, all_exp_q;   // of b
  logic        some_exp, all_exp, no_fraction, at_a;
  logic [23:0] sig, shifted;            // U(1.23), normalised; shifted: of a subnormal number
  logic [4:0]  zeros, places;
  logic        nan, snan, infinite, zero;

  always_ff @(posedge clk_i) begin
    b_q        <= sqrt_i ? 32'h0080_0000 : b_i;
    some_exp_q <= sqrt_i || (|b_i[30:23]);
    all_exp_q  <= !sqrt_i && (&b_i[30:23]);
  end

  assign at_a     = !valid_q[LoadFirst];
  assign operand  = at_a ? a_i : b_q;
  assign some_exp = at_a ? |a_i[30:23] : some_exp_q;
  assign all_exp  = at_a ? &a_i[30:23] : all_exp_q;

  // Without the hidden bit, which is known later: only subnormal numbers are shifted.
  fp_normalise u_normalise (
      .value_i({1'b0, operand[22:0]}),
      .value_o(shifted),
      .count_o(places),
      .zero_o (no_fraction)
  );
  assign sig   = some_exp ? {1'b1, operand[22:0]} : shifted;
  assign zeros = some_exp ? 5'd0 : places;

  assign nan      = all_exp && !no_fraction;
  assign snan     = nan && !operand[22];
  assign infinite = all_exp && no_fraction;
  assign zero     = !some_exp && no_fraction;

  // ---- clock 1: special results, start of the recurrence ----
  logic [23:0] sig_q;
  logic [7:0]  field_q;                 // exponent field, 1 for a subnormal number; of b inverted
  logic [4:0]  zeros_q;                 // of a inverted
  logic        of_a;                    // exponent: of a in clock 1, of b in clock 2
  logic [9:0]  exponent, exponent_a_q;  // S(10.0), biased: of a, less 1; of b, negated, plus 127
  logic        sign_a_q, nan_q, snan_q, infinite_q, zero_q;
  logic        sign, is_nan, is_invalid, is_inf, by_zero, is_zero;
  logic [25:0] start;
  logic [23:0] divisor;
  logic        double;                  // m is twice the significand: the unbiased exponent is odd

  always_ff @(posedge clk_i) begin
    sig_q        <= sig;
    field_q      <= {operand[30:24], operand[23] || !some_exp} ^ {8{!at_a}};
    zeros_q      <= zeros ^ {5{at_a}};
    exponent_a_q <= exponent;
    sign_a_q     <= operand[31];
    nan_q        <= nan;
    snan_q       <= snan;
    infinite_q   <= infinite;
    zero_q       <= zero;
  end

  assign of_a     = !valid_q[LoadFirst+1];
  assign exponent = {{2{!of_a}}, field_q} + {{2{of_a}}, 1'b1, {2{of_a}}, zeros_q};

  assign sign       = sign_a_q ^ operand[31];
  assign is_invalid = snan_q || snan || (infinite_q && infinite) || (zero_q && zero)
                   || (root_q[LoadFirst] && sign_a_q && !nan_q && !zero_q);
  assign is_nan     = nan_q || nan || is_invalid;
  assign is_inf     = infinite_q || zero;
  assign is_zero    = zero_q || infinite;
  assign by_zero    = zero && !infinite_q;

  assign double  = !root_q[LoadFirst] || exponent[0];
  assign start   = double ? {1'b0, sig_q, 1'b0} : {2'b00, sig_q};
  assign divisor = {!root_q[LoadFirst], sig[22:0]};

  // ---- clock 2: exponent ----
  // exp: biased exponent of a result with digit 0 = 0. If it is negative, 25 + exp digits count.
  logic [9:0] difference, exp;

  assign difference = exponent_a_q + exponent;
  assign exp        = root_q[LoadFirst+1] ? {difference[9], difference[9:1]} : difference;

  // ---- the two halves of the recurrence; half h holds an operation for Interval clocks ----
  logic [1:0]       load, run;
  logic [1:0][26:0] w_q;
  logic [1:0][25:2] divisor_q;          // quotient: D; root: its digits so far
  logic [1:0][25:2] divisor_d;
  logic [1:0]       sign_q, nan_s_q, invalid_s_q, inf_s_q, by_zero_s_q, zero_s_q;
  logic [1:0][9:0]  exp_q;              // S(10.0)
  logic [1:0][26:0] w_second;
  logic [1:0]       previous, first, second;  // the last digit so far, those of this clock
  logic [11:0]      digits_first_q;     // of the first half but for the last clock
  logic [24:0]      digits_q;           // of the second half
  logic             half;               // only the first digit of this clock counts
  logic             beyond_q;           // the digit that does not

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

    logic [25:0] place;                 // of the first digit of this clock in the divisor of a root
    logic [25:0] known, known_second;   // digits, or D, to which the marks of D are added
    logic [25:0] late;                  // the digit before those of this clock
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
    assign previous[h]     = !w_q[h][26];
    assign late          = (place << 1) & {26{previous[h]}};
    assign known         = {divisor_q[h], 2'b00};
    assign addend_first  = (((known | (place >> 1)) ^ {26{previous[h]}}) & ~(place << 1)) | place;
    assign w_first       = {w_q[h][25:0], previous[h]} + {previous[h], addend_first};
    assign first[h]      = !w_first[26];
    assign known_second  = known | late | (place >> 2);
    assign addend_second = ((known_second ^ {26{first[h]}}) & ~place) | (place >> 1);
    assign w_second[h]   = {w_first[25:0], first[h]} + {first[h], addend_second};
    assign second[h]     = !w_second[h][26];
    assign divisor_d[h]  = divisor_q[h] | late[25:2] | (place[25:2] & {24{first[h]}});
  end

  // First half: an operation leaves it with the digits of clock LoadSecond, so these are never left out.
  logic [3:0] skipped_first;            // clocks before this one in which digits may be left out

  assign skipped_first = {1'b0, valid_q[7], valid_q[6] || valid_q[5], valid_q[6] || valid_q[4]};
  assign run[0] = valid_q[2] ? !exp[9] : enough(exp_q[0], skipped_first);

  always_ff @(posedge clk_i) begin
    if (load[0]) begin
      w_q[0]         <= {1'b0, start};
      digits_first_q <= 12'd0;
    end else if (run[0]) begin
      w_q[0]         <= w_second[0];
      digits_first_q <= {digits_first_q[9:0], first[0], second[0]};
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

  always_ff @(posedge clk_i) begin
    if (load[1] || (run[1] && !root_q[Final])) w_q[1] <= load[1] ? w_second[0] : w_second[1];
    if (load[1] || run[1]) begin
      if (load[1]) digits_q <= {11'd0, digits_first_q, first[0], second[0]};
      else if (half) digits_q <= {digits_q[23:0], first[1]};
      else digits_q <= {digits_q[22:0], first[1], second[1]};
    end
    beyond_q <= half && !root_q[Final] && second[1];
    // The digits that enter in clock LoadSecond are those of bits 14 and 13.
    if (load[1]) begin
      divisor_q[1] <= divisor_q[0]
                    | ({11'd0, previous[0], first[0], 11'd0} & {24{root_q[LoadSecond]}});
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
  logic [8:0]     exp_round_q;          // U(9.0), biased, 0 for a subnormal result
  logic [26:0]    restore;
  logic           exact, one_digit, no_digit;
  logic [31:0]    result;
  fp_pkg::flags_t flags;

  always_ff @(posedge clk_i) begin
    exp_round_q <= exp_q[1][9] ? 9'd0 : exp_q[1][8:0] + {8'd0, half};
  end

  // A sum is zero if each of its bits, without the carry, is whether there are ones in the bits below.
  assign restore = {1'b0, divisor_q[1], root_q[Final+1], 1'b0};
  assign exact   = w_q[1] == 27'd0 || (w_q[1] ^ restore) == {w_q[1][25:0] | restore[25:0], 1'b0};

  // Two digits are there at least, also where one or none counts.
  assign one_digit = exp_q[1] == 10'h3e8;                                  // -24
  assign no_digit  = exp_q[1][9] && !((&exp_q[1][8:5]) && (|exp_q[1][4:3]));  // less

  fp_pack u_pack (
      .sign_i   (sign_q[1]),
      .exp_i    (exp_round_q),
      .sig_i    ({digits_q[24:2], digits_q[1] && !one_digit && !no_digit}),
      .guard_i  (!no_digit && (one_digit ? digits_q[1] : digits_q[0])),
      .round_i  (1'b0),
      .sticky_i (!exact || beyond_q || no_digit || (one_digit && digits_q[0])),
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
