// SPDX-License-Identifier: Apache-2.0
// asip_plausible: checks outputs 0 to 7 of a run against least and most value and slew, as the host staged them.
// Contract: when a run has ended, what it wrote last to each output with a record is checked, from output 0 on: 26
// clocks an output and 13 more, in which checking_o is 1, whatever the words are. implausible_o and index_o, of the
// first bad word, stay until the next run begins. The words are in the memory of asip_outputs; one comes two clocks
// after it is requested. A move is that from the word which the tick before committed to this output; without one,
// and after a fault, limits alone count. Limits are compared exactly, -0 is 0; a move and the slew in
// units of the last place of the larger word, cut off. An infinity in the record limits nothing.
// Words that are no numbers are for asip_outputs to check.
module asip_plausible (
    input  logic        clk_i,
    input  logic        rst_ni,
    // from control
    input  logic        run_start_i,
    input  logic        busy_i,         // a run
    input  logic        commit_i,
    input  logic        fault_i,
    // from write-back
    input  logic        write_i,
    input  logic [4:0]  index_i,
    // to and from the outputs' memory
    output logic        read_record_o,  // least, most or slew; otherwise an output
    output logic        read_shown_o,   // .. of the tick before
    output logic [4:0]  read_index_o,
    input  logic [31:0] word_i,
    // to redundancy
    output logic        checking_o,
    output logic        implausible_o,
    output logic [4:0]  index_o,
    // from the host, while idle only
    input  logic        host_write_i,   // a word of the record
    input  logic [4:0]  host_index_i,
    input  logic        host_on_i
);

  localparam int unsigned Outputs = asip_regmap_pkg::WORDS_PLAUSIBLE_ON;
  localparam logic [1:0] Least = 2'(asip_regmap_pkg::BASE_PLAUSIBLE_LEAST / Outputs);
  localparam logic [1:0] Most = 2'(asip_regmap_pkg::BASE_PLAUSIBLE_MOST / Outputs);
  localparam logic [1:0] Slew = 2'(asip_regmap_pkg::BASE_PLAUSIBLE_SLEW / Outputs);
  localparam logic [1:0] On = 2'(asip_regmap_pkg::BASE_PLAUSIBLE_ON / Outputs);
  localparam int unsigned Next = 25;  // step from which on the next output may begin
  localparam int unsigned Last = 30;  // step of the verdict

  (* keep *) logic [Outputs-1:0] off_q;  // of on_q: a flipped bit ends a record, and begins none
  logic [Outputs-1:0] on_q, written_q, shown_q, written, staged, judged;
  logic [Outputs-1:0] turn_q;  // one bit: the output whose turn it is
  logic [Last:Next] ended_q;  // no output is left; last bit: nor a verdict
  logic [Last:0] step_q;  // of an output
  logic [2:0] place, found_q;
  logic known_q, active_q, implausible_q, scan, chosen, begins, advance, bad;
  logic [6:1] slot_q;
  logic early_q, middle_q, late_q, first_q, second_q, later_q, fours, ones, hold_fours, hold_ones;
  logic mantissas_q, normal;
  logic [31:0] coarse_q, fine_q, sum_q;
  logic coarse_sign_q, fine_sign_q, new_sign_q, not_zero_q, new_larger_q, opposite_q;
  logic sure_q, limit_q, toward_q, unlike_q;
  logic exact, below, beyond, outside_q, moves_q;
  logic [33:0] difference;
  logic [8:0] largest_q;  // exponent of the larger word, and 1
  logic [9:0] room;
  logic [7:2] coarse_by_q;  // inverted, as room is
  logic [1:0] fine_by_q, next_by_q;
  logic unused_low;

  // ---- which outputs: those that the run wrote and that have a record
  always_comb begin
    written = '0;
    written[index_i[2:0]] = write_i && 32'(index_i) < Outputs;
    staged = '0;
    staged[host_index_i[2:0]] = host_write_i && host_index_i[4:3] == On;
  end
  assign judged  = written_q & on_q & ~off_q;
  assign chosen  = |(judged & turn_q);
  assign scan    = !busy_i && !active_q;
  assign begins  = scan && chosen;
  assign advance = (scan && !chosen) || step_q[Next];
  assign place   = {|turn_q[7:4], |{turn_q[7:6], turn_q[3:2]}, |{turn_q[7], turn_q[5], turn_q[3], turn_q[1]}};

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      on_q          <= '0;
      off_q         <= '1;
      known_q       <= 1'b0;
      implausible_q <= 1'b0;
    end else begin
      for (int i = 0; i < Outputs; i++) begin
        if (staged[i]) begin
          on_q[i]  <= host_on_i;
          off_q[i] <= !host_on_i;
        end
      end
      known_q       <= (known_q || commit_i) && !fault_i;
      implausible_q <= (implausible_q || bad) && !run_start_i;
    end
  end

  // Needs no reset: without a record nothing of this acts, and staging one clears written_q.
  always_ff @(posedge clk_i) begin
    for (int i = 0; i < Outputs; i++) if (written[i]) written_q[i] <= 1'b1;
    if (run_start_i || host_write_i) written_q <= '0;
    if (commit_i) shown_q <= written_q;
    if (advance) turn_q <= turn_q << 1;
    if (advance && turn_q[Outputs-1]) ended_q[Next] <= 1'b1;
    ended_q[Last:Next+1] <= ended_q[Last-1:Next];
    if (run_start_i) begin
      turn_q  <= Outputs'(1);
      ended_q <= '0;
    end
    step_q   <= {step_q[Last-1:0], begins};
    active_q <= begins || (active_q && !step_q[Next]);
    if (busy_i) begin
      step_q   <= '0;
      active_q <= 1'b0;
    end
    if (step_q[18] && !implausible_q) found_q <= place;
  end

  // ---- what is read: new word, word shown, least, most; the larger of the first two, the other one, slew
  assign read_record_o = step_q[3] || step_q[4] || step_q[16];
  assign read_shown_o  = step_q[2] || (new_larger_q ? step_q[8] : step_q[7]);
  assign read_index_o  = {({2{step_q[3]}} & Least) | ({2{step_q[4]}} & Most) | ({2{step_q[16]}} & Slew), place};

  // ---- a word comes into coarse_q, there goes right by fours, then in fine_q by ones: always as many clocks. First
  // whole words, from bit 1 on, then mantissas. Any word comes while none is shifted, which nobody looks at.
  assign normal     = |word_i[30:23];
  assign fours      = early_q || middle_q || late_q;
  assign ones       = first_q || later_q;
  assign hold_fours = (early_q && coarse_by_q[3]) || (middle_q && coarse_by_q[4]) || (late_q && coarse_by_q[2]);
  assign hold_ones  = (first_q && fine_by_q[0]) || (later_q && fine_by_q[1]);

  always_ff @(posedge clk_i) begin
    slot_q   <= {slot_q[5:1], step_q[10] || step_q[18]};
    early_q  <= step_q[10] || step_q[18] || slot_q[1];     // two clocks: by 8
    middle_q <= slot_q[2] || (middle_q && !slot_q[6]);     // four clocks: by 16
    late_q   <= slot_q[6];                                 // by 4
    first_q  <= step_q[10] || step_q[18] || step_q[26];    // by 1
    second_q <= first_q;
    later_q  <= first_q || second_q;                       // two clocks: by 2
    if (step_q[7]) mantissas_q <= 1'b1;
    if (step_q[0]) mantissas_q <= 1'b0;
    // the exponent of the larger word, later how far the other goes right in units of that one's last place
    if (step_q[9]) largest_q <= room[9:1];
    if (step_q[0]) largest_q <= '1;
    if (!hold_fours) begin
      coarse_q[24:0] <= fours ? {4'd0, coarse_q[24:4]} : {mantissas_q ? normal : word_i[23], word_i[22:0], 1'b0};
    end
    if (late_q && !(&coarse_by_q[7:5])) coarse_q[24:0] <= '0;
    if (!fours) begin
      coarse_q[31:25] <= word_i[30:24];
      coarse_sign_q   <= word_i[31];
      {coarse_by_q, next_by_q} <= room[8:1];
    end
    if (mantissas_q) coarse_q[31:25] <= '0;
    if (!hold_ones) fine_q[24:0] <= ones ? {1'b0, fine_q[24:1]} : coarse_q[24:0];
    if (!ones) begin
      fine_q[31:25] <= coarse_q[31:25];
      fine_sign_q   <= coarse_sign_q;
      unlike_q      <= coarse_sign_q != new_sign_q;
      fine_by_q     <= next_by_q;
    end
    if (step_q[4] || step_q[12] || step_q[22]) fine_q <= '0;
    if (step_q[10]) fine_by_q <= 2'b10;
  end

  // room is inverted: exponent - largest_q - 1. The exponent of a subnormal is that of the least normal.
  assign room = {1'b0, word_i[30:24], word_i[23] || !normal, 1'b0} - {largest_q, !step_q[9]};

  // ---- one adder: fine_q - sum_q, less one except for exact. Limits: the new word is in sum_q. A move: the larger word,
  // then the other one less that or with it. ~sum_q changes the sign: what is left over 0 less one.
  assign exact = sure_q || (limit_q && toward_q && !unlike_q);
  assign difference = {1'b0, fine_q, 1'b0} - {1'b0, sum_q, !exact};
  assign below  = difference[33];
  // step 7: below least, step 8: above most. toward_q: the sign of the new word points to that limit.
  assign beyond = unlike_q ? toward_q && (not_zero_q || !below) : below == toward_q;
  assign bad = step_q[Last] && (outside_q || (moves_q && below));

  always_ff @(posedge clk_i) begin
    if (step_q[4] || step_q[12] || step_q[22] || (step_q[13] && opposite_q) || (step_q[23] && !opposite_q))
      sum_q <= difference[32:1];
    if (step_q[3] || step_q[10]) sum_q <= '1;
    if (step_q[4]) new_sign_q <= fine_sign_q;
    if (step_q[5]) not_zero_q <= below;
    if (step_q[6]) begin
      new_larger_q <= below;
      opposite_q   <= unlike_q;
    end
    sure_q   <= step_q[4] || step_q[Last-1];
    limit_q  <= step_q[6] || step_q[7];
    toward_q <= new_sign_q ^ step_q[7];
    if (limit_q && beyond) outside_q <= 1'b1;
    if (step_q[6]) outside_q <= 1'b0;
    // otherwise no move is so wide
    if (step_q[18]) moves_q <= known_q && (|(shown_q & turn_q)) && room[9] && !(&word_i[30:23]);
  end

  assign unused_low    = ^{difference[0], room[0]};  // of carries alone
  assign checking_o    = (|judged) && !ended_q[Last];
  assign implausible_o = implausible_q;
  assign index_o       = {2'd0, found_q};

endmodule
