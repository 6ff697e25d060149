// SPDX-License-Identifier: Apache-2.0
// asip_issue_single: asip_issue for one slot and one multiply-add pipe, without scoreboards.
// Contract: that of asip_issue, cycle by cycle, with the banks A and C. With one operation per cycle the
// writes in flight are few, so a bundle in P is compared with each of them, with the bundle in Q and
// with the one in D. How long it then waits is known: a write in place r of its schedule ends for
// readers when it reaches place 3. So Q and D have one wait bit per place, which moves down with the
// write, one per division in flight and one for the sine.
module asip_issue_single (
    input  logic                               clk_i,
    input  logic                               rst_ni,
    // from fetch
    input  logic                               flush_i,   // P, Q and D are void
    input  logic [asip_pkg::DECODED_WIDTH-1:0] ops_p_i,
    input  logic                               valid_q_i,
    input  logic                               bad_q_i,   // must not issue
    input  logic [asip_pkg::DECODED_WIDTH-1:0] ops_q_i,
    input  logic                               valid_d_i,
    input  logic                               bad_d_i,
    input  logic [asip_pkg::DECODED_WIDTH-1:0] ops_d_i,
    // from control: the core runs, it will run in the next cycle
    input  logic                               run_i,
    input  logic                               run_next_i,
    // to fetch, control and the operand stage
    output logic                               advance_o,
    output logic                               issue_o,
    output logic                               branch_wait_o,
    output logic                               branch_e1_o,
    output logic                               stall_operand_o,
    output logic                               stall_unit_o,
    output logic [2:0][8:0]                    source_d_o,
    // to the operand stage and write-back: banks A, B, C in two cycles, in the next cycle, now
    output logic [2:0]                         soon_o,
    output logic [2:0][5:0]                    soon_index_o,
    output logic [2:0]                         next_o,
    output logic [2:0][5:0]                    next_index_o,
    output logic [2:0]                         write_o,
    output logic [2:0][5:0]                    write_index_o,
    output logic                               write_output_o,
    output logic                               busy_o
);

  // A write of latency L that issues now is in place L + 2 in the next cycle, and in 0 at write-back.
  localparam int unsigned CmpPlace = fp_pkg::FP_CMP_LATENCY + 2;
  localparam int unsigned I2fPlace = fp_pkg::FP_I2F_LATENCY + 2;
  localparam int unsigned F2iPlace = fp_pkg::FP_F2I_LATENCY + 2;
  localparam int unsigned LoadPlace = asip_isa_pkg::MEMORY_LATENCY + 2;
  localparam int unsigned FmaPlace = fp_pkg::FP_FMA_LATENCY + 2;  // the last but division and sine
  localparam int unsigned DivPlace = fp_pkg::FP_DIVSQRT_LATENCY + 2;
  localparam int unsigned Top = DivPlace + 1;  // where a sine joins
  localparam int unsigned Announced = 4;
  localparam int unsigned DivInterval = asip_isa_pkg::SMALL_DIVSQRT_INTERVAL;
  // Divisions in flight above the announced places.
  localparam int unsigned Divs = (DivPlace - Announced + DivInterval - 1) / DivInterval;
  localparam int unsigned DivWidth = $clog2(DivInterval + 1);
  localparam int unsigned SinWidth = $clog2(fp_pkg::FP_SINCOS_LATENCY + 1);

  logic issue, issue_d, issue_q, advance_d, advance_q;
  logic valid_next, free_q, free_d, branch_next, blocked;
  logic branch_r1_q, branch_r2_q, branch_e1_q, branch_e2_q;
  logic stall_operand_q, sin_join, sin_busy_d, sin_busy_q, clash_q_q;
  logic div_busy_d, div_busy;
  logic [3:0][6:0] operand_p;  // sources and destination {bank C, index}
  logic [3:0] register_p;  // .. that are registers of A or C
  logic starts_p, starts_q, starts_d;  // a register of A or C
  logic hit_q, hit_d, match_q_q;
  logic [FmaPlace:Announced+1] hit_a, hit_c, hit_place;
  logic [Divs-1:0] hit_div, div_next, div_oldest, div_next_q, div_oldest_q;
  logic [Divs-1:0] div_valid_q, div_ends;
  logic [Divs-1:0][5:0] div_index_q;
  logic hit_sin, sin_ends, sin_waited_q;
  logic [FmaPlace:Announced] start_place, wait_place_q_q, wait_place_d_q, left_q, left_d;
  logic ends_q, ends_d;
  logic [Divs-1:0] wait_div_q_q, wait_div_d_q;
  logic wait_sin_q_q, wait_sin_d_q;
  logic [FmaPlace:0] valid_a_q;
  logic [FmaPlace:0][5:0] index_a_q;
  logic [Top:0] insert_c, valid_c_d, valid_c_q, div_c_d, div_c_q, taken_c;
  logic [Top:0][6:0] tag_c_d, tag_c_q;
  logic [SinWidth-1:0] sin_left_q;
  logic [6:0] sin_tag_q, tag_c;
  asip_pkg::decoded_t op_p, op_q, op_d;

  // Whether an auxiliary operation other than a sine has this place in the next cycle if it issues.
  function automatic logic places(input asip_pkg::decoded_t op, input int unsigned place);
    places = (op.cmp && place == CmpPlace) || (op.i2f && place == I2fPlace) ||
             (op.f2i && place == F2iPlace) || (op.load && place == LoadPlace) ||
             (op.divsqrt && place == DivPlace);
  endfunction

  function automatic logic starts(input asip_pkg::decoded_t op);
    starts = op.writes && !op.to_output;
  endfunction

  function automatic logic branches(input asip_pkg::decoded_t op);
    branches = op.jump || op.branch_zero || op.branch_nonzero;
  endfunction

  assign op_p     = ops_p_i;
  assign op_q     = ops_q_i;
  assign op_d     = ops_d_i;
  assign starts_p = starts(op_p);
  assign starts_q = starts(op_q);
  assign starts_d = starts(op_d);

  assign source_d_o = {op_d.c, op_d.b, op_d.a};

  // ---- what the bundle in P waits for. Bank codes: A is 001, C is 011.
  assign operand_p  = {{!op_p.fma, op_p.dst}, {op_p.c[7], op_p.c[5:0]}, {op_p.b[7], op_p.b[5:0]},
                       {op_p.a[7], op_p.a[5:0]}};
  assign register_p = {starts_p, !op_p.c[8] && op_p.c[6], !op_p.b[8] && op_p.b[6],
                       !op_p.a[8] && op_p.a[6]};

  function automatic logic hits(input logic [3:0][6:0] operand, input logic [3:0] is_register,
                                input logic [6:0] written);
    hits = 1'b0;
    for (int unsigned p = 0; p < 4; p++) hits = hits || (is_register[p] && operand[p] == written);
  endfunction

  assign hit_q = starts_q && hits(operand_p, register_p, {!op_q.fma, op_q.dst});
  assign hit_d = starts_d && hits(operand_p, register_p, {!op_d.fma, op_d.dst});

  // In places above those of i2f and load, bank C's schedule holds divisions and sines only; these wait in
  // registers of their own until they reach the place below.
  genvar rank, n;
  generate
    for (rank = Announced + 1; rank <= FmaPlace; rank++) begin : gen_hit
      assign hit_a[rank] = valid_a_q[rank] && hits(operand_p, register_p, {1'b0, index_a_q[rank]});
      if (rank <= CmpPlace || rank <= I2fPlace || rank <= F2iPlace || rank <= LoadPlace) begin : gen_c
        assign hit_c[rank] = valid_c_q[rank] && !tag_c_q[rank][6] && hits(
            operand_p, register_p, {1'b1, tag_c_q[rank][5:0]}
        );
      end else begin : gen_no_c
        assign hit_c[rank] = 1'b0;
      end
      assign hit_place[rank] = hit_a[rank] || hit_c[rank];
    end
    for (n = 0; n < Divs; n++) begin : gen_hit_div
      assign hit_div[n] = div_valid_q[n] && hits(operand_p, register_p, {1'b1, div_index_q[n]});
    end
  endgenerate
  assign hit_sin = sin_waited_q && hits(operand_p, register_p, {1'b1, sin_tag_q[5:0]});

  // Place in the next cycle of what the bundle in D writes.
  generate
    for (rank = Announced; rank <= FmaPlace; rank++) begin : gen_start
      assign start_place[rank] = (op_d.fma && rank == FmaPlace) || (places(op_d, rank) && !op_d.divsqrt);
    end
  endgenerate
  assign div_ends = div_oldest_q & {Divs{valid_c_q[Announced+1] && div_c_q[Announced+1]}};
  assign sin_ends = sin_left_q == SinWidth'(Announced - 1);

  // A division or sine that reaches the last place that is waited for.
  assign ends_q = (|(wait_div_q_q & div_ends)) || (wait_sin_q_q && sin_ends);
  assign ends_d = (|(wait_div_d_q & div_ends)) || (wait_sin_d_q && sin_ends);
  assign left_q = (wait_place_q_q >> 1) | (FmaPlace-Announced+1)'(ends_q);
  assign left_d = (wait_place_d_q >> 1) | (FmaPlace-Announced+1)'(ends_d);

  always_ff @(posedge clk_i) begin
    if (advance_q) begin
      wait_place_q_q <= {1'b0, hit_place} | ({FmaPlace-Announced+1{issue_q && hit_d}} & start_place);
      wait_div_q_q   <= (hit_div & ~div_ends) |
                        ({Divs{issue_q && hit_d && op_d.divsqrt}} & div_next_q);
      wait_sin_q_q   <= (hit_sin && !sin_ends) || (issue_q && hit_d && op_d.sincos);
      wait_place_d_q <= left_q | ({FmaPlace-Announced+1{issue_q && match_q_q}} & start_place);
      wait_div_d_q   <= (wait_div_q_q & ~div_ends) |
                        ({Divs{issue_q && match_q_q && op_d.divsqrt}} & div_next_q);
      wait_sin_d_q   <= (wait_sin_q_q && !sin_ends) || (issue_q && match_q_q && op_d.sincos);
      // what the bundle in Q, then in D, will start that the one in P, then in Q, wants
      match_q_q      <= hit_q;
      clash_q_q      <= port_clash(op_p, op_q);
    end else begin
      wait_place_q_q <= left_q;
      wait_div_q_q   <= wait_div_q_q & ~div_ends;
      wait_sin_q_q   <= wait_sin_q_q && !sin_ends;
      wait_place_d_q <= left_d;
      wait_div_d_q   <= wait_div_d_q & ~div_ends;
      wait_sin_d_q   <= wait_sin_d_q && !sin_ends;
    end
    stall_operand_q <= blocked;
  end

  // Whether `later`, issued in the cycle after `first`, wants bank C's port in the same cycle.
  function automatic logic port_clash(input asip_pkg::decoded_t later, input asip_pkg::decoded_t first);
    port_clash = 1'b0;
    for (int unsigned r = Announced; r < DivPlace; r++) begin
      port_clash = port_clash || (places(later, r) && places(first, r + 1));
    end
  endfunction

  function automatic logic port_taken(input asip_pkg::decoded_t op, input logic [Top:0] taken);
    port_taken = 1'b0;
    for (int unsigned r = Announced; r <= DivPlace; r++) begin
      port_taken = port_taken || (places(op, r) && taken[r+1]);
    end
  endfunction

  // ---- decision for the next cycle
  assign blocked = advance_q ?
      (|wait_place_q_q) || (|wait_div_q_q) || wait_sin_q_q || (issue_q && match_q_q) :
      (|wait_place_d_q) || (|wait_div_d_q) || wait_sin_d_q;
  assign branch_next = (issue_q && branches(op_d)) || branch_r1_q || branch_r2_q || branch_e1_q;
  assign free_q = valid_q_i && !bad_q_i && !port_taken(op_q, taken_c) && !(issue_q && clash_q_q) &&
                  !(op_q.sincos && sin_busy_d) && !(op_q.divsqrt && div_busy_d);
  assign free_d = !bad_d_i && !port_taken(op_d, taken_c) && !(op_d.sincos && sin_busy_d) &&
                  !(op_d.divsqrt && div_busy_d);
  assign issue_d = run_next_i && !flush_i && !branch_next && (advance_q ? free_q : free_d) &&
                   !blocked;
  assign valid_next = !flush_i && (advance_q ? valid_q_i : valid_d_i);
  assign advance_d  = issue_d || !valid_next;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      issue_q     <= 1'b0;
      advance_q   <= 1'b1;
      branch_r1_q <= 1'b0;
      branch_r2_q <= 1'b0;
      branch_e1_q <= 1'b0;
      branch_e2_q <= 1'b0;
    end else begin
      issue_q     <= issue_d;
      advance_q   <= advance_d;
      branch_r1_q <= issue && branches(op_d);
      branch_r2_q <= branch_r1_q;
      branch_e1_q <= branch_r2_q;
      branch_e2_q <= branch_e1_q;
    end
  end

  // A fault stops the core after the decision for this cycle.
  assign issue           = issue_q && run_i;
  assign issue_o         = issue;
  assign advance_o       = advance_q;
  assign branch_wait_o   = branch_r1_q || branch_r2_q || branch_e1_q || branch_e2_q;
  assign branch_e1_o     = branch_e1_q;
  assign stall_operand_o = stall_operand_q;
  assign stall_unit_o    = (op_d.sincos && sin_busy_q) || (op_d.divsqrt && div_busy);

  // ---- write schedules: every cycle all places move down by one
  assign tag_c   = {op_d.to_output, op_d.dst};
  assign taken_c = {sin_join, valid_c_q[Top:1]};

  always_comb begin
    valid_c_d = taken_c;
    div_c_d   = {1'b0, div_c_q[Top:1]};
    tag_c_d   = {sin_tag_q, tag_c_q[Top:1]};
    for (int unsigned r = 0; r <= Top; r++) begin
      insert_c[r] = issue && places(op_d, r);
      if (insert_c[r]) begin
        valid_c_d[r] = 1'b1;
        tag_c_d[r]   = tag_c;
      end
    end
    div_c_d[DivPlace] = insert_c[DivPlace];
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_a_q <= '0;
      valid_c_q <= '0;
    end else begin
      valid_a_q <= {issue && op_d.fma, valid_a_q[FmaPlace:1]};
      valid_c_q <= valid_c_d;
    end
  end

  always_ff @(posedge clk_i) begin
    index_a_q <= {op_d.dst, index_a_q[FmaPlace:1]};
    tag_c_q   <= tag_c_d;
    div_c_q   <= div_c_d;
  end

  // ---- divisions in flight: a ring
  assign div_next   = (div_next_q << 1) | (div_next_q >> (Divs - 1));
  assign div_oldest = (div_oldest_q << 1) | (div_oldest_q >> (Divs - 1));

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      div_next_q   <= Divs'(1);
      div_oldest_q <= Divs'(1);
      div_valid_q  <= '0;
    end else begin
      if (issue && op_d.divsqrt) div_next_q <= div_next;
      if (|div_ends) div_oldest_q <= div_oldest;
      div_valid_q <= (div_valid_q & ~div_ends) | ({Divs{issue && op_d.divsqrt && !op_d.to_output}} & div_next_q);
    end
  end

  generate
    for (n = 0; n < Divs; n++) begin : gen_div
      always_ff @(posedge clk_i) begin
        if (issue && op_d.divsqrt && div_next_q[n]) div_index_q[n] <= op_d.dst;
      end
    end

    if (DivInterval > 1) begin : gen_div_busy
      logic [DivWidth-1:0] div_left_q;

      assign div_busy   = |div_left_q;
      assign div_busy_d = (issue_q && op_d.divsqrt) || (|div_left_q[DivWidth-1:1]);

      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) div_left_q <= '0;
        else if (issue && op_d.divsqrt) div_left_q <= DivWidth'(DivInterval - 1);
        else if (div_busy) div_left_q <= div_left_q - 1'b1;
      end
    end else begin : gen_div_free
      assign div_busy   = 1'b0;
      assign div_busy_d = 1'b0;
    end
  endgenerate

  // ---- sine and cosine: one at a time, joins the schedule when its result is near
  assign sin_join   = sin_left_q == SinWidth'(Top - 1);
  assign sin_busy_d = (issue_q && op_d.sincos) || (sin_busy_q && sin_left_q != SinWidth'(1));

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sin_left_q   <= '0;
      sin_busy_q   <= 1'b0;
      sin_waited_q <= 1'b0;
    end else if (issue && op_d.sincos) begin
      sin_left_q   <= SinWidth'(fp_pkg::FP_SINCOS_LATENCY);
      sin_busy_q   <= 1'b1;
      sin_waited_q <= !op_d.to_output;
    end else if (sin_busy_q) begin
      sin_left_q   <= sin_left_q - 1'b1;
      sin_busy_q   <= sin_left_q != SinWidth'(1);
      sin_waited_q <= sin_waited_q && !sin_ends;
    end
  end

  always_ff @(posedge clk_i) begin
    if (issue && op_d.sincos) sin_tag_q <= tag_c;
  end

`ifndef SYNTHESIS
  generate
    if (fp_pkg::FP_SINCOS_LATENCY < DivPlace || FmaPlace < I2fPlace || FmaPlace < LoadPlace ||
      FmaPlace < CmpPlace || FmaPlace < F2iPlace || DivPlace <= FmaPlace) begin : gen_check_order
      $error("asip_issue_single: latencies must rise from short units to fma, divsqrt and sincos");
    end
    if (asip_isa_pkg::SMALL_SINCOS_INTERVAL != fp_pkg::FP_SINCOS_LATENCY + 1) begin : gen_check_sincos
      $error("asip_issue_single: a sine takes FP_SINCOS_LATENCY + 1 cycles, state that in isa.toml");
    end
    if (CmpPlace < Announced || I2fPlace < Announced || F2iPlace < Announced ||
      LoadPlace < Announced) begin : gen_check_short
      $error("asip_issue_single: a latency below 2 is never announced");
    end
  endgenerate
`endif

  // ---- write-back
  assign soon_o         = {valid_c_q[2] && !tag_c_q[2][6], 1'b0, valid_a_q[2]};
  assign next_o         = {valid_c_q[1] && !tag_c_q[1][6], 1'b0, valid_a_q[1]};
  assign write_o        = {valid_c_q[0] && !tag_c_q[0][6], 1'b0, valid_a_q[0]};
  assign soon_index_o   = {tag_c_q[2][5:0], 6'd0, index_a_q[2]};
  assign next_index_o   = {tag_c_q[1][5:0], 6'd0, index_a_q[1]};
  assign write_index_o  = {tag_c_q[0][5:0], 6'd0, index_a_q[0]};
  assign write_output_o = valid_c_q[0] && tag_c_q[0][6];
  assign busy_o         = (|valid_a_q[FmaPlace:1]) || (|valid_c_q[Top:1]) || sin_busy_q;

  logic unused_ops;
  assign unused_ops = ^{op_d, op_q, op_p, taken_c, div_c_q};

endmodule
