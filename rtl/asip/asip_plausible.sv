// SPDX-License-Identifier: Apache-2.0
// asip_plausible: judges outputs 0 to 7 of a run against least and most value and slew, as the host staged them.
// Contract: when a run has ended, what it wrote last to each output with a record is judged, from output 0 on:
// five clocks an output and seven more, in which checking_o is 1. implausible_o and index_o, of the first bad
// word, stay until the next run begins. The words are in the memory of asip_outputs; one comes two clocks after it
// is asked for. A move is that from the word which the tick before committed to this output; without one,
// and behind a fault, limits alone count. Limits are compared exactly, -0 is 0; a move and the slew in
// units of the last place of the larger word, cut off. An infinity in the record limits nothing.
// Words that are no numbers are for asip_outputs to judge.
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

  (* keep *) logic [Outputs-1:0] off_q;  // of on_q: a flipped bit ends a record, and begins none
  logic [Outputs-1:0] on_q, written_q, shown_q, todo_q, written;
  logic [10:0]        step_q;            // of an output; the next one begins five steps behind
  logic [2:0]         place, place_q, read_q, judged_q, found_q;
  logic               implausible_q, begins;
  logic [31:0]        new_q, word;
  logic [30:0]        large_q, other_q;
  logic               strict, above, outside_q, beyond_q, known_q, narrow_q, limits_q, moves_q, subtract_q, bad;
  logic [8:0]         room;
  logic [4:0]         shift_q;
  logic [1:0]         high_q;
  logic [24:0]        shorter_q, partly_q, shifted_q, move_q;  // units of the last place of the larger word

  function automatic logic [7:0] exponent(input logic [7:0] field);
    exponent = {field[7:1], field[0] || !(|field)};  // a subnormal has that of the least normal
  endfunction

  // ---- which outputs: those that the run wrote and that have a record
  always_comb begin
    written = '0;
    written[index_i[2:0]] = write_i && 32'(index_i) < Outputs;
    place = '0;
    for (int i = Outputs - 1; i >= 0; i--) if (todo_q[i]) place = 3'(i);
  end

  assign begins = !busy_i && (|todo_q) && !(|step_q[3:0]);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      on_q          <= '0;
      off_q         <= '1;
      written_q     <= '0;
      shown_q       <= '0;
      todo_q        <= '0;
      step_q        <= '0;
      implausible_q <= 1'b0;
    end else begin
      if (host_write_i && host_index_i[4:3] == On) begin
        on_q[host_index_i[2:0]]  <= host_on_i;
        off_q[host_index_i[2:0]] <= !host_on_i;
      end
      if (fault_i) shown_q <= '0;
      else if (commit_i) shown_q <= written_q;
      written_q <= written_q | written;
      todo_q    <= todo_q | (written & on_q & ~off_q);
      if (begins) todo_q[place] <= 1'b0;
      step_q <= {step_q[9:0], begins};
      if (step_q[10] && bad) implausible_q <= 1'b1;
      if (run_start_i) begin
        written_q     <= '0;
        todo_q        <= '0;
        step_q        <= '0;
        implausible_q <= 1'b0;
      end
    end
  end

  // ---- steps 0 to 4: ask for the new word, least, most, the word shown, slew; step n + 2 has the answer
  assign read_record_o = step_q[1] || step_q[2] || step_q[4];
  assign read_shown_o  = step_q[3];
  assign read_index_o  = {({2{step_q[1]}} & Least) | ({2{step_q[2]}} & Most) |
                          ({2{step_q[4]}} & Slew), place_q};
  assign word          = {word_i[31] && (|word_i[30:0]), word_i[30:0]};

  // ---- steps 3 to 5: limits; the larger of new word and word shown by magnitude
  // strict: the magnitude of the new word is to be above the other, otherwise at least the other
  assign strict = step_q[3] ? new_q[31] : step_q[4] && !new_q[31];
  assign above  = {new_q[30:0], !strict} >= {word[30:0], 1'b1};

  always_ff @(posedge clk_i) begin
    if (begins) place_q <= place;
    if (step_q[2]) new_q <= word;
    if (step_q[3]) begin
      outside_q <= new_q[31] != word[31] ? new_q[31] : new_q[31] == above;
    end
    if (step_q[4]) begin
      outside_q <= outside_q || (new_q[31] != word[31] ? word[31] : new_q[31] != above);
      read_q    <= place_q;
    end
    if (step_q[5]) begin
      judged_q   <= read_q;
      beyond_q   <= outside_q;
      known_q    <= shown_q[read_q];
      large_q    <= above ? new_q[30:0] : word[30:0];
      subtract_q <= new_q[31] == word[31];
    end
    // the smaller word, then the slew
    other_q <= step_q[6] || above ? word[30:0] : new_q[30:0];
  end

  // ---- steps 6 to 10: both in units of the larger word's last place; how far the output moved
  assign room = {1'b0, exponent(large_q[30:23])} + 9'd1 - {1'b0, exponent(other_q[30:23])};

  always_ff @(posedge clk_i) begin
    shift_q   <= room[4:0] | {5{|room[8:5]}};
    shorter_q <= {|other_q[30:23], other_q[22:0], 1'b0};
    narrow_q  <= !room[8] && !(&other_q[30:23]);  // otherwise no move is so wide
    high_q    <= shift_q[4:3];
    partly_q  <= shorter_q >> shift_q[2:0];
    limits_q  <= known_q && narrow_q;
    // to be subtracted, not the slew
    shifted_q <= (partly_q >> {high_q, 3'd0}) ^ {25{step_q[8] && subtract_q}};
    moves_q   <= limits_q;
    move_q    <= {1'b0, |large_q[30:23], large_q[22:0]} + shifted_q + 25'(subtract_q);
    if (!implausible_q) found_q <= judged_q;
  end

  assign bad = beyond_q || (moves_q && move_q > shifted_q);

  assign checking_o    = (|todo_q) || (|step_q);
  assign implausible_o = implausible_q;
  assign index_o       = {2'd0, found_q};

endmodule
