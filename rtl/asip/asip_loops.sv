// SPDX-License-Identifier: Apache-2.0
// asip_loops: loops that take no cycle, decided where bundles are fetched.
// Contract: a bundle with the operation `loop` opens the loop of a level, whose body begins with the bundle
// after it. The end mark of a level is in the bundle two before the last one of the body: if rounds are left, the
// body's first bundle follows its last one. The mark of the highest level with a round left counts, and no
// mark in the two bundles after one that counted. turn_o informs fetch in the cycle in which the marked bundle is in
// F2, so the last bundle of the body is the one that pc_q reads.
// Two copies of the state: that of F2 runs ahead, that of D follows the bundles that issue. A redirection of
// fetch copies the second to the first, so a branch or a debug block may void what was fetched. The copy of F2 takes
// a `loop` from P, where it is already decoded, in time for a mark in the bundle after it.
module asip_loops #(
    parameter int unsigned Loops = 3  // levels
) (
    input  logic             clk_i,
    input  logic             rst_ni,
    // from fetch and control
    input  logic             clear_i,     // fetch begins at an entry: no loop is open
    input  logic             branch_i,    // fetch goes on at the target of a branch
    input  logic             resume_i,    // fetch goes on at the bundle in D
    input  logic             advance_i,
    input  logic             valid_f2_i,
    input  logic [15:0]      pc_f2_i,
    input  logic [Loops-1:0] ends_f2_i,
    // from stage P
    input  logic             loop_p_i,
    input  logic [15:0]      imm_p_i,     // {level, rounds - 1}
    // from stage D
    input  logic             issue_i,
    input  logic [15:0]      pc_d_i,
    input  logic             loop_d_i,
    input  logic [15:0]      imm_d_i,
    input  logic [Loops-1:0] ends_d_i,
    // to fetch: the bundle after the one that is read now
    output logic             turn_o,
    output logic [15:0]      turn_pc_o
);

  localparam int unsigned CountWidth = asip_isa_pkg::LOOP_COUNT_WIDTH;

  // Of F2 (0) and D (1).
  logic [1:0] step, turns;
  logic [1:0][15:0] turn_pc;
  logic [15:0] next_p_q;  // address of the bundle after the one in P
  logic [1:0][Loops-1:0] ends, count;  // marks; that of the level that counts
  logic [Loops-1:0][CountWidth-1:0] left;  // of F2: rounds after this one
  logic [1:0][Loops-1:0] more;  // they are not 0
  logic [1:0][Loops-1:0][15:0] first;  // bundle of the body
  logic [1:0][1:0] turning;  // a mark counted: one, two bundles ago
  logic [15:0] target_q;  // of the mark that counted in D
  logic [1:0] late_q;  // fetch resumed between a mark and its turn
  logic redirect;

  assign redirect = clear_i || branch_i || resume_i;
  assign step     = {issue_i, advance_i && valid_f2_i};
  assign ends     = {ends_d_i, ends_f2_i};

  genvar c, l;
  generate
    for (c = 0; c < 2; c++) begin : gen_copy
      logic [Loops-1:0] ready;
      logic [1:0] turning_q;

      assign ready      = turning_q == 2'b00 ? ends[c] & more[c] : '0;
      assign turns[c]   = |ready;
      assign turning[c] = turning_q;

      always_comb begin
        count[c]   = '0;
        turn_pc[c] = '0;
        for (int unsigned i = 0; i < Loops; i++) begin
          if (ready[i]) begin
            count[c]    = '0;
            count[c][i] = 1'b1;
            turn_pc[c]  = first[c][i];
          end
        end
      end

      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) turning_q <= 2'b00;
        else if (clear_i || branch_i) turning_q <= 2'b00;
        else if (c == 0 && resume_i) turning_q <= turning[1];
        else if (step[c]) turning_q <= {turning_q[0], turns[c]};
      end
    end

    for (l = 0; l < Loops; l++) begin : gen_level
      logic [CountWidth-1:0] left_q, left_d_q;
      logic [15:0] first_q, first_d_q;
      logic more_q, more_d_q, opens, opens_d, round;

      // The bundle in P is the one before that in F2.
      assign opens       = loop_p_i && imm_p_i[15:CountWidth] == (16 - CountWidth)'(l);
      assign opens_d     = issue_i && loop_d_i && imm_d_i[15:CountWidth] == (16 - CountWidth)'(l);
      assign round       = valid_f2_i && count[0][l];
      assign left[l]     = opens ? imm_p_i[CountWidth-1:0] : left_q;
      assign more[0][l]  = opens ? |imm_p_i[CountWidth-1:0] : more_q;
      assign first[0][l] = opens ? next_p_q : first_q;
      assign more[1][l]  = more_d_q;
      assign first[1][l] = first_d_q;

      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) more_q <= 1'b0;
        else if (clear_i) more_q <= 1'b0;
        else if (redirect) more_q <= more_d_q;
        else if (advance_i) more_q <= round ? left[l] != CountWidth'(1) : more[0][l];
      end

      always_ff @(posedge clk_i) begin
        if (redirect) begin
          left_q  <= left_d_q;
          first_q <= first_d_q;
        end else if (advance_i) begin
          left_q  <= round ? left[l] - 1'b1 : left[l];
          first_q <= first[0][l];
        end
      end

      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) more_d_q <= 1'b0;
        else if (clear_i) more_d_q <= 1'b0;
        else if (opens_d) more_d_q <= |imm_d_i[CountWidth-1:0];
        else if (issue_i && count[1][l]) more_d_q <= left_d_q != CountWidth'(1);
      end

      always_ff @(posedge clk_i) begin
        if (opens_d) begin
          left_d_q  <= imm_d_i[CountWidth-1:0];
          first_d_q <= pc_d_i + 16'd1;
        end else if (issue_i && count[1][l]) begin
          left_d_q <= left_d_q - 1'b1;
        end
      end
    end
  endgenerate

  always_ff @(posedge clk_i) if (advance_i) next_p_q <= pc_f2_i + 16'd1;

  // Fetch that resumes at one of the two bundles after a mark that counted has yet to turn after the second.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) late_q <= 2'b00;
    else if (clear_i || branch_i) late_q <= 2'b00;
    else if (resume_i) late_q <= turning[1];
    else if (advance_i) late_q <= {late_q[0], 1'b0};
  end

  always_ff @(posedge clk_i) if (issue_i && turns[1]) target_q <= turn_pc[1];

  assign turn_o    = late_q[1] || (step[0] && turns[0]);
  assign turn_pc_o = late_q[1] ? target_q : turn_pc[0];

  logic unused_state;
  assign unused_state = ^turning[0];

endmodule
