// SPDX-License-Identifier: Apache-2.0
// asip_issue_multiple: asip_issue for bundles of several operations, with scoreboards.
// Contract: that of asip_issue. The scoreboards are looked up in P; in Q and D one wait bit per operand
// is left, set by the lookup or by the bundle that issues just then, cleared when its write is announced.
module asip_issue_multiple #(
    parameter int unsigned FmaPipes = 2,
    parameter int unsigned Slots    = 3
) (
    input  logic                                           clk_i,
    input  logic                                           rst_ni,
    // from fetch
    input  logic                                           flush_i,   // P, Q and D are void
    input  logic [Slots*asip_pkg::DECODED_WIDTH-1:0]       ops_p_i,
    input  logic                                           valid_q_i,
    input  logic                                           bad_q_i,   // must not issue
    input  logic [Slots*asip_pkg::DECODED_WIDTH-1:0]       ops_q_i,
    input  logic                                           valid_d_i,
    input  logic                                           bad_d_i,
    input  logic [Slots*asip_pkg::DECODED_WIDTH-1:0]       ops_d_i,
    // from control: the core runs, it will run in the next cycle
    input  logic                                           run_i,
    input  logic                                           run_next_i,
    // to fetch, control and the operand stage
    output logic                                           advance_o,
    output logic                                           issue_o,
    output logic                                           branch_wait_o,
    output logic                                           branch_e1_o,
    output logic                                           stall_operand_o,
    output logic                                           stall_unit_o,
    output logic [3*Slots-1:0][8:0]                        source_d_o,
    // to the operand stage and write-back: banks A, B, C in two cycles, in the next cycle, now
    output logic [2:0]                                     soon_o,
    output logic [2:0][5:0]                                soon_index_o,
    output logic [2:0]                                     next_o,
    output logic [2:0][5:0]                                next_index_o,
    output logic [2:0]                                     write_o,
    output logic [2:0][5:0]                                write_index_o,
    output logic                                           write_output_o,
    output logic                                           busy_o
);

  localparam int unsigned OpWidth = asip_pkg::DECODED_WIDTH;
  localparam int unsigned Ports = 3 * Slots;
  localparam int unsigned Operands = Ports + 3;  // sources, then destinations A, B, C
  localparam int unsigned AuxSlot = Slots - 1;
  localparam int unsigned FmaPlaces = fp_pkg::FP_FMA_LATENCY + 4;
  localparam int unsigned FmaPlaceWidth = $clog2(FmaPlaces);
  localparam int unsigned AuxPlaces = fp_pkg::FP_DIVSQRT_LATENCY + 4;
  localparam int unsigned LatencyWidth = $clog2(AuxPlaces);
  localparam int unsigned SinInterval = asip_isa_pkg::FAST_SINCOS_INTERVAL;
  localparam int unsigned SinWidth = $clog2(SinInterval);
  // Cycles from the end of the interval to where a sine joins the schedule of bank C.
  localparam int unsigned SinRest = fp_pkg::FP_SINCOS_OVERLAPPED_LATENCY - fp_pkg::FP_DIVSQRT_LATENCY - SinInterval;
  localparam int unsigned SinRestWidth = $clog2(SinRest + 1);

  logic issue, issue_d, issue_q, advance_d, advance_q;
  logic valid_next, free_q, free_d, branch_next;
  logic branch_r1_q, branch_r2_q, branch_e1_q, branch_e2_q;
  logic [Ports-1:0][8:0] source_d;
  logic [Operands-1:0][8:0] operand_p, operand_q, operand_d;
  logic [Operands-1:0][5:0] query;
  logic [Operands-1:0] pending_a, pending_b, pending_c, pending_p;
  logic [Operands-1:0] match_q_q, ends_q_d, ends_q_q;  // stage Q
  logic [Operands-1:0] early_q_d, early_q_q, late_q_d, late_q_q, wait_q;
  logic [Operands-1:0] wait_d_d, wait_d_q, ends_d_d, ends_d_q;  // stage D
  logic [2:0] starts_q, starts_d, starts_bank, ends_write;
  logic [2:0][6:0] start_tag_q, start_tag, end_tag;
  logic [2:0][4:0] place_valid;
  logic [2:0][6:0] tag4, tag2, tag1, tag0;
  logic [2:0] schedule_busy;
  logic aux_timed, sin_join, sin_busy_d, sin_busy_q, sin_waits_q, clash_q_q;
  logic port_q, port_d;
  logic [AuxPlaces-1:0] taken_c;
  logic [LatencyWidth-1:0] aux_latency;
  logic [SinWidth-1:0] sin_left_q;
  logic [SinRestWidth-1:0] sin_rest_q;
  logic [6:0] sin_tag_q, sin_join_tag_q;
  asip_pkg::decoded_t aux_p, aux_q, aux;

  // Whether a write of banks A, B, C given by valid bits and tags is that of an operand.
  function automatic logic hits(input logic [8:0] operand, input logic [2:0] valid, input logic [2:0][6:0] tag);
    case (operand[8:6])
      asip_isa_pkg::BANK_A: hits = valid[0] && tag[0][5:0] == operand[5:0];
      asip_isa_pkg::BANK_B: hits = valid[1] && tag[1][5:0] == operand[5:0];
      asip_isa_pkg::BANK_C: hits = valid[2] && tag[2][5:0] == operand[5:0];
      default: hits = 1'b0;
    endcase
  endfunction

  // Whether an auxiliary operation that issues in the next cycle finds bank C's port taken.
  function automatic logic port_taken(input asip_pkg::decoded_t op, input logic [AuxPlaces-1:0] taken);
    port_taken = (op.cmp && taken[fp_pkg::FP_CMP_LATENCY+3]) ||
                 (op.i2f && taken[fp_pkg::FP_I2F_LATENCY+3]) ||
                 (op.f2i && taken[fp_pkg::FP_F2I_LATENCY+3]) ||
                 (op.load && taken[asip_isa_pkg::MEMORY_LATENCY+3]) ||
                 (op.divsqrt && taken[fp_pkg::FP_DIVSQRT_LATENCY+3]);
  endfunction

  function automatic logic [LatencyWidth-1:0] latency_of(input asip_pkg::decoded_t op);
    latency_of = LatencyWidth'(fp_pkg::FP_CMP_LATENCY);
    if (op.divsqrt) latency_of = LatencyWidth'(fp_pkg::FP_DIVSQRT_LATENCY);
    if (op.i2f) latency_of = LatencyWidth'(fp_pkg::FP_I2F_LATENCY);
    if (op.f2i) latency_of = LatencyWidth'(fp_pkg::FP_F2I_LATENCY);
    if (op.load) latency_of = LatencyWidth'(asip_isa_pkg::MEMORY_LATENCY);
  endfunction

  assign aux_p = ops_p_i[OpWidth*AuxSlot+:OpWidth];
  assign aux_q = ops_q_i[OpWidth*AuxSlot+:OpWidth];
  assign aux   = ops_d_i[OpWidth*AuxSlot+:OpWidth];

  // Sources, then destinations, of a bundle; a destination that is not written reads as bank zero.
  genvar s, port, b;
  generate
    for (s = 0; s < Slots; s++) begin : gen_slot
      asip_pkg::decoded_t op_p, op_q, op_d;
      assign op_p = ops_p_i[OpWidth*s+:OpWidth];
      assign op_q = ops_q_i[OpWidth*s+:OpWidth];
      assign op_d = ops_d_i[OpWidth*s+:OpWidth];
      assign operand_p[3*s+:3] = {op_p.c, op_p.b, op_p.a};
      assign operand_q[3*s+:3] = {op_q.c, op_q.b, op_q.a};
      assign operand_d[3*s+:3] = {op_d.c, op_d.b, op_d.a};
      if (s < FmaPipes) begin : gen_fma
        localparam logic [2:0] Bank = s == 0 ? asip_isa_pkg::BANK_A : asip_isa_pkg::BANK_B;
        assign operand_p[Ports+s] = {op_p.fma ? Bank : asip_isa_pkg::BANK_ZERO, op_p.dst};
        assign operand_q[Ports+s] = {op_q.fma ? Bank : asip_isa_pkg::BANK_ZERO, op_q.dst};
        assign operand_d[Ports+s] = {op_d.fma ? Bank : asip_isa_pkg::BANK_ZERO, op_d.dst};
        assign starts_q[s]        = op_q.fma;
        assign starts_d[s]        = op_d.fma;
        assign start_tag_q[s]     = {1'b0, op_q.dst};
        assign start_tag[s]       = {1'b0, op_d.dst};
      end
    end
    if (FmaPipes < 2) begin : gen_one_pipe
      assign operand_p[Ports+1] = '0;
      assign operand_q[Ports+1] = '0;
      assign operand_d[Ports+1] = '0;
      assign starts_q[1]        = 1'b0;
      assign starts_d[1]        = 1'b0;
      assign start_tag_q[1]     = '0;
      assign start_tag[1]       = '0;
    end
  endgenerate

  function automatic logic [8:0] destination_c(input asip_pkg::decoded_t op);
    destination_c = {op.writes && !op.fma && !op.to_output ? asip_isa_pkg::BANK_C : asip_isa_pkg::BANK_ZERO, op.dst};
  endfunction

  assign operand_p[Ports+2] = destination_c(aux_p);
  assign operand_q[Ports+2] = destination_c(aux_q);
  assign operand_d[Ports+2] = destination_c(aux);
  assign starts_q[2]        = aux_q.writes && !aux_q.fma;
  assign starts_d[2]        = aux.writes && !aux.fma;
  assign start_tag_q[2]     = {aux_q.to_output, aux_q.dst};
  assign start_tag[2]       = {aux.to_output, aux.dst};

  assign source_d    = operand_d[Ports-1:0];
  assign source_d_o  = source_d;
  assign starts_bank = {starts_d[2] && !aux.to_output, starts_d[1:0]};
  assign aux_latency = latency_of(aux);
  assign aux_timed   = starts_d[2] && !aux.sincos;

  // ---- writes in flight: looked up in P, followed in Q and D. A write is announced from place 4: the
  // scoreboard forgets it, and in the next cycle no bundle of Q and D waits for it any more.
  assign ends_write = {place_valid[2][4] && !tag4[2][6], place_valid[1][4], place_valid[0][4]};
  assign end_tag    = tag4;

  always_comb begin
    for (int unsigned p = 0; p < Operands; p++) begin
      query[p]     = operand_p[p][5:0];
      pending_p[p] = (operand_p[p][8:6] == asip_isa_pkg::BANK_A && pending_a[p]) ||
                     (operand_p[p][8:6] == asip_isa_pkg::BANK_B && pending_b[p]) ||
                     (operand_p[p][8:6] == asip_isa_pkg::BANK_C && pending_c[p]);
      ends_d_d[p]  = advance_q ? hits(operand_q[p], ends_write, end_tag) :
                                 hits(operand_d[p], ends_write, end_tag);
      ends_q_d[p]  = advance_q ? hits(operand_p[p], ends_write, end_tag) :
                                 hits(operand_q[p], ends_write, end_tag);
      // for what was in flight when the bundle left P; for what the bundle in D started then
      early_q_d[p] = advance_q ? pending_p[p] : early_q_q[p] && !ends_q_q[p];
      late_q_d[p]  = advance_q ? issue_q && hits(operand_p[p], starts_bank, start_tag) :
                                 late_q_q[p] && !ends_q_q[p];
      wait_q[p]    = early_q_q[p] || late_q_q[p];
      wait_d_d[p]  = advance_q ? (wait_q[p] && !ends_q_q[p]) || (issue_q && match_q_q[p]) :
                                 wait_d_q[p] && !ends_d_q[p];
    end
  end

  always_ff @(posedge clk_i) begin
    early_q_q <= early_q_d;
    late_q_q  <= late_q_d;
    wait_d_q  <= wait_d_d;
    ends_q_q  <= ends_q_d;
    ends_d_q  <= ends_d_d;
    if (advance_q) begin
      // what the bundle in D will start that the one in Q wants
      for (int unsigned p = 0; p < Operands; p++) begin
        match_q_q[p] <= hits(operand_p[p], {starts_q[2] && !aux_q.to_output, starts_q[1:0]}, start_tag_q);
      end
      // verilog_format: off - it breaks calls inside their parentheses
      clash_q_q <= aux_p.writes && !aux_p.fma && !aux_p.sincos && starts_q[2] && !aux_q.sincos &&
                   latency_of(aux_p) + 1'b1 == latency_of(aux_q);
      // verilog_format: on
    end
  end

  // ---- decision for the next cycle
  assign branch_next = (issue_q && (aux.jump || aux.branch_zero || aux.branch_nonzero)) ||
                       branch_r1_q || branch_r2_q || branch_e1_q;
  assign port_q = port_taken(aux_q, taken_c) || (issue_q && clash_q_q);
  assign port_d = port_taken(aux, taken_c);
  assign free_q = valid_q_i && !bad_q_i && !port_q && !(aux_q.sincos && sin_busy_d);
  assign free_d = !bad_d_i && !port_d && !(aux.sincos && sin_busy_d);
  assign issue_d = run_next_i && !flush_i && !branch_next && (advance_q ? free_q : free_d) &&
                   !(|wait_d_d);
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
      branch_r1_q <= issue && (aux.jump || aux.branch_zero || aux.branch_nonzero);
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
  assign stall_operand_o = |wait_d_q;
  assign stall_unit_o    = aux.sincos && sin_busy_q;

  // ---- scoreboards
  asip_scoreboard #(
      .Queries(Operands)
  ) u_scoreboard_a (
      .clk_i,
      .rst_ni,
      .set_i        (issue && starts_bank[0]),
      .set_index_i  (start_tag[0][5:0]),
      .clear_i      (ends_write[0]),
      .clear_index_i(end_tag[0][5:0]),
      .query_i      (query),
      .pending_o    (pending_a)
  );

  generate
    if (FmaPipes > 1) begin : gen_scoreboard_b
      asip_scoreboard #(
          .Queries(Operands)
      ) u_scoreboard_b (
          .clk_i,
          .rst_ni,
          .set_i        (issue && starts_bank[1]),
          .set_index_i  (start_tag[1][5:0]),
          .clear_i      (ends_write[1]),
          .clear_index_i(end_tag[1][5:0]),
          .query_i      (query),
          .pending_o    (pending_b)
      );
    end else begin : gen_no_scoreboard_b
      assign pending_b = '0;
    end
  endgenerate

  asip_scoreboard #(
      .Queries(Operands)
  ) u_scoreboard_c (
      .clk_i,
      .rst_ni,
      .set_i        (issue && starts_bank[2]),
      .set_index_i  (start_tag[2][5:0]),
      .clear_i      (ends_write[2]),
      .clear_index_i(end_tag[2][5:0]),
      .query_i      (query),
      .pending_o    (pending_c)
  );

  // ---- write schedules
  generate
    for (port = 0; port < FmaPipes; port++) begin : gen_schedule
      logic [FmaPlaces-1:0] unused_taken;
      asip_write_schedule #(
          .Places(FmaPlaces)
      ) u_schedule (
          .clk_i,
          .rst_ni,
          .insert_i  (issue && starts_d[port]),
          .latency_i (FmaPlaceWidth'(fp_pkg::FP_FMA_LATENCY)),
          .tag_i     (start_tag[port]),
          .join_i    (1'b0),
          .join_tag_i('0),
          .taken_o   (unused_taken),
          .valid_o   (place_valid[port]),
          .tag4_o    (tag4[port]),
          .tag2_o    (tag2[port]),
          .tag1_o    (tag1[port]),
          .tag0_o    (tag0[port]),
          .busy_o    (schedule_busy[port])
      );
    end
    if (FmaPipes < 2) begin : gen_no_schedule_b
      assign place_valid[1]   = '0;
      assign tag4[1]          = '0;
      assign tag2[1]          = '0;
      assign tag1[1]          = '0;
      assign tag0[1]          = '0;
      assign schedule_busy[1] = 1'b0;
    end
  endgenerate

  asip_write_schedule #(
      .Places(AuxPlaces)
  ) u_schedule_c (
      .clk_i,
      .rst_ni,
      .insert_i  (issue && aux_timed),
      .latency_i (aux_latency),
      .tag_i     (start_tag[2]),
      .join_i    (sin_join),
      .join_tag_i(sin_join_tag_q),
      .taken_o   (taken_c),
      .valid_o   (place_valid[2]),
      .tag4_o    (tag4[2]),
      .tag2_o    (tag2[2]),
      .tag1_o    (tag1[2]),
      .tag0_o    (tag0[2]),
      .busy_o    (schedule_busy[2])
  );

  // ---- sine and cosine: the unit is busy for its interval, then the write waits until it is near
  // enough to join the schedule, while the next operation may be in its interval
  assign sin_join   = sin_rest_q == SinRestWidth'(1);
  assign sin_busy_d = (issue_q && aux.sincos) || (sin_busy_q && sin_left_q != SinWidth'(1));

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sin_left_q  <= '0;
      sin_busy_q  <= 1'b0;
      sin_rest_q  <= '0;
      sin_waits_q <= 1'b0;
    end else begin
      if (issue && aux.sincos) begin
        sin_left_q <= SinWidth'(SinInterval - 1);
        sin_busy_q <= 1'b1;
      end else if (sin_busy_q) begin
        sin_left_q <= sin_left_q - 1'b1;
        sin_busy_q <= sin_left_q != SinWidth'(1);
      end
      if (sin_busy_q && sin_left_q == SinWidth'(1)) begin
        sin_rest_q  <= SinRestWidth'(SinRest);
        sin_waits_q <= 1'b1;
      end else if (sin_waits_q) begin
        sin_rest_q  <= sin_rest_q - 1'b1;
        sin_waits_q <= !sin_join;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (issue && aux.sincos) sin_tag_q <= start_tag[2];
    if (sin_busy_q && sin_left_q == SinWidth'(1)) sin_join_tag_q <= sin_tag_q;
  end

`ifndef SYNTHESIS
  generate
    if (SinRest < 1 || SinRest > SinInterval) begin : gen_check_sincos
      $error("asip_issue_multiple: a sine must join the schedule within the interval after its own");
    end
    if (fp_pkg::FP_CMP_LATENCY < 2 || fp_pkg::FP_I2F_LATENCY < 2 || fp_pkg::FP_F2I_LATENCY < 2) begin : gen_check_short
      $error("asip_issue_multiple: a latency below 2 is never announced");
    end
  endgenerate
`endif

  generate
    for (b = 0; b < 3; b++) begin : gen_bank
      assign soon_o[b]        = place_valid[b][2] && !tag2[b][6];
      assign soon_index_o[b]  = tag2[b][5:0];
      assign next_o[b]        = place_valid[b][1] && !tag1[b][6];
      assign next_index_o[b]  = tag1[b][5:0];
      assign write_o[b]       = place_valid[b][0] && !tag0[b][6];
      assign write_index_o[b] = tag0[b][5:0];
    end
  endgenerate
  assign write_output_o = place_valid[2][0] && tag0[2][6];
  assign busy_o         = (|schedule_busy) || sin_busy_q || sin_waits_q;

  logic unused_ops;
  assign unused_ops = ^{ops_d_i, ops_q_i, ops_p_i, taken_c, place_valid};

endmodule
