// SPDX-License-Identifier: Apache-2.0
// asip_plausible: judges outputs 0 to 7 of a run against least and most value and slew, as the host staged them.
// Contract: a word is judged as it is written and checking_o is 1 until the verdict stands, five clocks;
// implausible_o and index_o, of the first bad word, stay until the next run begins. An output moves from its last
// word committed; from reset and from a fault on there is none until its next commit, and limits alone count.
// Limits are compared exactly, -0 is 0; a move and the slew in units of the last place of the larger word, cut
// off. An infinity in the record limits nothing. Words that are no numbers are for asip_outputs to judge.
module asip_plausible (
    input  logic        clk_i,
    input  logic        rst_ni,
    // from control
    input  logic        run_start_i,
    input  logic        commit_i,
    input  logic        fault_i,
    // from write-back
    input  logic        write_i,
    input  logic [4:0]  index_i,
    input  logic [31:0] data_i,
    // to redundancy
    output logic        checking_o,
    output logic        implausible_o,
    output logic [4:0]  index_o,
    // from the host, while idle only
    input  logic [3:0]  host_write_i,   // a word of on, slew, most, least
    input  logic [2:0]  host_index_i,
    input  logic        host_on_i,
    input  logic [31:0] host_data_i
);

  localparam int unsigned Outputs = asip_regmap_pkg::WORDS_PLAUSIBLE_ON;

  logic [31:0]        least[0:Outputs-1];
  logic [31:0]        most [0:Outputs-1];
  logic [30:0]        slew [0:Outputs-1];
  logic [31:0]        last [0:2*Outputs-1];  // two pages: committed, and of this run
  (* keep *) logic [Outputs-1:0] off_q;      // of on_q: a flipped bit ends a record, and begins none
  logic [Outputs-1:0] on_q, page_q, known_q, written_q;
  logic [5:1]         judged_q;              // by stage
  logic [5:1][2:0]    place_q;               // output
  logic               write_1_q, zero;
  logic [31:0]        data_1_q, data_2_q, order_2_q, least_2_q, most_2_q, last_2_q;
  logic [30:0]        slew_2_q;
  logic               known_2_q, outside_3_q, outside_4_q, outside_5_q;
  logic               moves_3_q, moves_4_q, moves_5_q;  // slew counts
  logic               implausible_q, rises, subtract_3_q, subtract_4_q;
  logic [2:0]         found_q;
  logic [31:0]        larger, smaller;
  logic [8:0]         apart, room;
  logic [23:0]        large_3_q, small_3_q, slew_3_q, large_4_q, small_4_q;  // U(1.23)
  logic [4:0]         apart_3_q, room_3_q;
  logic [24:0]        bound_4_q, bound_5_q, difference_5_q;  // units of the last place of the larger

  // A word whose order as an unsigned number is that of the numbers.
  function automatic logic [31:0] ordered(input logic [31:0] a);
    ordered = {!a[31], a[30:0] ^ {31{a[31]}}};
  endfunction

  function automatic logic [7:0] exponent(input logic [7:0] field);
    exponent = {field[7:1], field[0] || !(|field)};  // a subnormal has that of the least normal
  endfunction

  function automatic logic [4:0] at_most_31(input logic [8:0] shift);
    at_most_31 = shift[4:0] | {5{|shift[8:5]}};
  endfunction

  // ---- the record and the words to compare with
  assign zero = !(|host_data_i[30:0]);

  always_ff @(posedge clk_i) begin
    // a limit of 0 is the zero on its far side
    if (host_write_i[0]) least[host_index_i] <= ordered({host_data_i[31] || zero, host_data_i[30:0]});
    if (host_write_i[1]) most[host_index_i] <= ordered({host_data_i[31] && !zero, host_data_i[30:0]});
    if (host_write_i[2]) slew[host_index_i] <= host_data_i[30:0];
    if (write_1_q) last[{!page_q[place_q[1]], place_q[1]}] <= data_1_q;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      on_q          <= '0;
      off_q         <= '1;
      page_q        <= '0;
      known_q       <= '0;
      written_q     <= '0;
      judged_q      <= '0;
      write_1_q     <= 1'b0;
      implausible_q <= 1'b0;
    end else begin
      if (host_write_i[3]) begin
        on_q[host_index_i]  <= host_on_i;
        off_q[host_index_i] <= !host_on_i;
      end
      write_1_q <= write_i && 32'(index_i) < Outputs;
      if (run_start_i) written_q <= '0;
      else if (write_1_q) written_q[place_q[1]] <= 1'b1;
      if (commit_i) page_q <= page_q ^ written_q;
      if (fault_i) known_q <= '0;
      else if (commit_i) known_q <= known_q | written_q;
      judged_q <= {judged_q[4:1], write_i && 32'(index_i) < Outputs && on_q[index_i[2:0]] &&
                                  !off_q[index_i[2:0]]};
      if (run_start_i) begin
        judged_q      <= '0;
        implausible_q <= 1'b0;
      end else if (judged_q[5] && (outside_5_q || (moves_5_q && difference_5_q > bound_5_q))) begin
        implausible_q <= 1'b1;
      end
    end
  end

  // ---- 1, 2: the word, what the record says of it
  always_ff @(posedge clk_i) begin
    place_q   <= {place_q[4:1], index_i[2:0]};
    data_1_q  <= data_i;
    data_2_q  <= data_1_q;
    order_2_q <= ordered(data_1_q);
    least_2_q <= least[place_q[1]];
    most_2_q  <= most[place_q[1]];
    slew_2_q  <= slew[place_q[1]];
    last_2_q  <= last[{page_q[place_q[1]], place_q[1]}];
    known_2_q <= known_q[place_q[1]];
    if (!implausible_q) found_q <= place_q[5];
  end

  // ---- 3: limits; the larger word and the distances of the others' exponents from its own
  assign rises   = data_2_q[30:0] >= last_2_q[30:0];
  assign larger  = rises ? data_2_q : last_2_q;
  assign smaller = rises ? last_2_q : data_2_q;
  assign apart   = {1'b0, exponent(larger[30:23])} - {1'b0, exponent(smaller[30:23])};
  assign room    = {1'b0, exponent(larger[30:23])} + 9'd1 - {1'b0, exponent(slew_2_q[30:23])};

  always_ff @(posedge clk_i) begin
    outside_3_q  <= order_2_q < least_2_q || order_2_q > most_2_q;
    moves_3_q    <= known_2_q && !room[8] && !(&slew_2_q[30:23]);  // beyond: no move is so wide
    subtract_3_q <= larger[31] == smaller[31];
    large_3_q    <= {|larger[30:23], larger[22:0]};
    small_3_q    <= {|smaller[30:23], smaller[22:0]};
    slew_3_q     <= {|slew_2_q[30:23], slew_2_q[22:0]};
    apart_3_q    <= at_most_31(apart);
    room_3_q     <= at_most_31(room);
  end

  // ---- 4, 5: to the larger word's exponent, how far it moved
  always_ff @(posedge clk_i) begin
    outside_4_q    <= outside_3_q;
    moves_4_q      <= moves_3_q;
    subtract_4_q   <= subtract_3_q;
    large_4_q      <= large_3_q;
    small_4_q      <= small_3_q >> apart_3_q;
    bound_4_q      <= {slew_3_q, 1'b0} >> room_3_q;
    outside_5_q    <= outside_4_q;
    moves_5_q      <= moves_4_q;
    bound_5_q      <= bound_4_q;
    difference_5_q <= {1'b0, large_4_q} + {subtract_4_q, small_4_q ^ {24{subtract_4_q}}} +
                      {24'd0, subtract_4_q};
  end

  assign checking_o    = |judged_q;
  assign implausible_o = implausible_q;
  assign index_o       = {2'd0, found_q};

endmodule
