// SPDX-License-Identifier: Apache-2.0
// asip_issue: hazard interlocks and write schedules (stages P and D).
// Contract: a bundle issues, all its operations together, in the first cycle in which every source and
// destination has no write in flight (a write ends for a reader latency + 1 cycles after its issue),
// the write port of bank C is free in the cycle its auxiliary result needs it, sine/cosine is idle,
// and no branch is undecided. Any program is therefore correct whatever its schedule.
// The scoreboard is looked up in stage P; in stage D only one wait bit per operand is left, set by the
// lookup or by the bundle that issues just then, cleared when the write it waits for is announced.
module asip_issue #(
    parameter int unsigned FmaPipes = 2,
    parameter int unsigned Slots    = 3
) (
    input  logic                                           clk_i,
    input  logic                                           rst_ni,
    // from fetch; take_d_i: the bundle in P moves to D
    input  logic [Slots*asip_pkg::DECODED_WIDTH-1:0]       ops_p_i,
    input  logic                                           take_d_i,
    input  logic                                           valid_d_i,
    input  logic [Slots*asip_pkg::DECODED_WIDTH-1:0]       ops_d_i,
    // from control
    input  logic                                           enable_i,
    input  logic                                           branch_wait_i,
    // to fetch, control and the operand stage
    output logic                                           issue_o,
    output logic                                           stall_operand_o,
    output logic                                           stall_unit_o,
    output logic                                           stall_port_o,
    output logic [3*Slots-1:0][8:0]                        source_d_o,
    // to the operand stage and write-back: banks A, B, C
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
  localparam int unsigned AuxSlot = Slots - 1;
  localparam int unsigned FmaPlaces = fp_pkg::FP_FMA_LATENCY + 4;
  localparam int unsigned FmaPlaceWidth = $clog2(FmaPlaces);
  localparam int unsigned AuxPlaces = fp_pkg::FP_DIVSQRT_LATENCY + 4;
  localparam int unsigned LatencyWidth = $clog2(AuxPlaces);
  localparam int unsigned SinWidth = $clog2(fp_pkg::FP_SINCOS_LATENCY + 1);

  logic [Ports-1:0][8:0]   source_p, source_d;
  logic [Ports+2:0][8:0]   operand_p, operand_d;  // sources, then destinations A, B, C
  logic [Ports+2:0]        pending_p, starts_p, ends_p, ends_d, wait_d, wait_q;
  logic [Ports+2:0][5:0]   query;
  logic [Ports+2:0]        pending_a, pending_b, pending_c;
  logic [2:0]              starts_write, ends_write;
  logic [2:0][6:0]         start_tag;
  logic [2:0][3:0]         place_valid;
  logic [2:0][6:0]         tag3, tag2, tag1, tag0;
  logic [2:0]              schedule_busy;
  logic                    aux_timed, sin_join, sin_busy_q;
  logic [AuxPlaces-1:0]    taken_c;
  logic [LatencyWidth-1:0] aux_latency;
  logic [SinWidth-1:0]     sin_left_q;
  logic [6:0]              sin_tag_q;
  asip_pkg::decoded_t      aux, aux_p;

  // Whether a write of banks A, B, C given by valid bits and tags is that of an operand.
  function automatic logic hits(input logic [8:0] operand, input logic [2:0] valid,
                                input logic [2:0][6:0] tag);
    case (operand[8:6])
      asip_isa_pkg::BANK_A: hits = valid[0] && tag[0][5:0] == operand[5:0];
      asip_isa_pkg::BANK_B: hits = valid[1] && tag[1][5:0] == operand[5:0];
      asip_isa_pkg::BANK_C: hits = valid[2] && tag[2][5:0] == operand[5:0];
      default: hits = 1'b0;
    endcase
  endfunction

  // ---- what the bundles want; a destination that is not written reads as bank zero
  for (genvar s = 0; s < Slots; s++) begin : gen_slot
    asip_pkg::decoded_t op, op_p;
    assign op = ops_d_i[OpWidth*s+:OpWidth];
    assign op_p = ops_p_i[OpWidth*s+:OpWidth];
    assign source_d[3*s]   = op.a;
    assign source_d[3*s+1] = op.b;
    assign source_d[3*s+2] = op.c;
    assign source_p[3*s]   = op_p.a;
    assign source_p[3*s+1] = op_p.b;
    assign source_p[3*s+2] = op_p.c;
    if (s < FmaPipes) begin : gen_fma
      localparam logic [2:0] Bank = s == 0 ? asip_isa_pkg::BANK_A : asip_isa_pkg::BANK_B;
      assign starts_write[s]    = op.fma;
      assign start_tag[s]       = {1'b0, op.dst};
      assign operand_p[Ports+s] = {op_p.fma ? Bank : asip_isa_pkg::BANK_ZERO, op_p.dst};
      assign operand_d[Ports+s] = {op.fma ? Bank : asip_isa_pkg::BANK_ZERO, op.dst};
    end
  end
  if (FmaPipes < 2) begin : gen_one_pipe
    assign starts_write[1]    = 1'b0;
    assign start_tag[1]       = '0;
    assign operand_p[Ports+1] = '0;
    assign operand_d[Ports+1] = '0;
  end
  assign operand_p[Ports-1:0] = source_p;
  assign operand_d[Ports-1:0] = source_d;
  assign operand_p[Ports+2] = {
    aux_p.writes && !aux_p.fma && !aux_p.to_output ? asip_isa_pkg::BANK_C : asip_isa_pkg::BANK_ZERO,
    aux_p.dst
  };
  assign operand_d[Ports+2] = {
    starts_write[2] && !aux.to_output ? asip_isa_pkg::BANK_C : asip_isa_pkg::BANK_ZERO, aux.dst
  };

  assign aux   = ops_d_i[OpWidth*AuxSlot+:OpWidth];
  assign aux_p = ops_p_i[OpWidth*AuxSlot+:OpWidth];
  assign starts_write[2] = aux.writes && !aux.fma;
  assign start_tag[2]    = {aux.to_output, aux.dst};
  assign source_d_o      = source_d;

  always_comb begin
    aux_latency = LatencyWidth'(fp_pkg::FP_CMP_LATENCY);
    if (aux.divsqrt) aux_latency = LatencyWidth'(fp_pkg::FP_DIVSQRT_LATENCY);
    if (aux.i2f) aux_latency = LatencyWidth'(fp_pkg::FP_I2F_LATENCY);
    if (aux.f2i) aux_latency = LatencyWidth'(fp_pkg::FP_F2I_LATENCY);
    if (aux.load) aux_latency = LatencyWidth'(asip_isa_pkg::MEMORY_LATENCY);
  end
  assign aux_timed = starts_write[2] && !aux.sincos;

  // ---- writes in flight: looked up in P, followed in D
  assign ends_write = {place_valid[2][3] && !tag3[2][6], place_valid[1][3], place_valid[0][3]};

  for (genvar p = 0; p < Ports + 3; p++) begin : gen_operand
    assign query[p]     = operand_p[p][5:0];
    assign pending_p[p] = (operand_p[p][8:6] == asip_isa_pkg::BANK_A && pending_a[p]) ||
                          (operand_p[p][8:6] == asip_isa_pkg::BANK_B && pending_b[p]) ||
                          (operand_p[p][8:6] == asip_isa_pkg::BANK_C && pending_c[p]);
    assign starts_p[p] = hits(operand_p[p], {starts_write[2] && !aux.to_output, starts_write[1:0]},
                              start_tag);
    assign ends_p[p] = hits(operand_p[p], ends_write, tag3);
    assign ends_d[p] = hits(operand_d[p], ends_write, tag3);
    assign wait_d[p] = take_d_i ? (pending_p[p] && !ends_p[p]) || (issue_o && starts_p[p]) :
                       wait_q[p] && !ends_d[p];
  end

  always_ff @(posedge clk_i) wait_q <= wait_d;

  asip_scoreboard #(
      .Queries(Ports + 3)
  ) u_scoreboard_a (
      .clk_i,
      .rst_ni,
      .set_i        (issue_o && starts_write[0]),
      .set_index_i  (start_tag[0][5:0]),
      .clear_i      (place_valid[0][3]),
      .clear_index_i(tag3[0][5:0]),
      .query_i      (query),
      .pending_o    (pending_a)
  );

  if (FmaPipes > 1) begin : gen_scoreboard_b
    asip_scoreboard #(
        .Queries(Ports + 3)
    ) u_scoreboard_b (
        .clk_i,
        .rst_ni,
        .set_i        (issue_o && starts_write[1]),
        .set_index_i  (start_tag[1][5:0]),
        .clear_i      (place_valid[1][3]),
        .clear_index_i(tag3[1][5:0]),
        .query_i      (query),
        .pending_o    (pending_b)
    );
  end else begin : gen_no_scoreboard_b
    logic unused_b;
    assign pending_b = '0;
    assign unused_b  = ^tag3[1];
  end

  asip_scoreboard #(
      .Queries(Ports + 3)
  ) u_scoreboard_c (
      .clk_i,
      .rst_ni,
      .set_i        (issue_o && starts_write[2] && !aux.to_output),
      .set_index_i  (start_tag[2][5:0]),
      .clear_i      (ends_write[2]),
      .clear_index_i(tag3[2][5:0]),
      .query_i      (query),
      .pending_o    (pending_c)
  );

  for (genvar p = 0; p < FmaPipes; p++) begin : gen_schedule
    logic [FmaPlaces-1:0] unused_taken;
    asip_write_schedule #(
        .Places(FmaPlaces)
    ) u_schedule (
        .clk_i,
        .rst_ni,
        .insert_i  (issue_o && starts_write[p]),
        .latency_i (FmaPlaceWidth'(fp_pkg::FP_FMA_LATENCY)),
        .tag_i     (start_tag[p]),
        .join_i    (1'b0),
        .join_tag_i('0),
        .taken_o   (unused_taken),
        .valid_o   (place_valid[p]),
        .tag3_o    (tag3[p]),
        .tag2_o    (tag2[p]),
        .tag1_o    (tag1[p]),
        .tag0_o    (tag0[p]),
        .busy_o    (schedule_busy[p])
    );
  end
  if (FmaPipes < 2) begin : gen_no_schedule_b
    assign place_valid[1]   = '0;
    assign tag3[1]          = '0;
    assign tag2[1]          = '0;
    assign tag1[1]          = '0;
    assign tag0[1]          = '0;
    assign schedule_busy[1] = 1'b0;
  end

  asip_write_schedule #(
      .Places(AuxPlaces)
  ) u_schedule_c (
      .clk_i,
      .rst_ni,
      .insert_i  (issue_o && aux_timed),
      .latency_i (aux_latency),
      .tag_i     (start_tag[2]),
      .join_i    (sin_join),
      .join_tag_i(sin_tag_q),
      .taken_o   (taken_c),
      .valid_o   (place_valid[2]),
      .tag3_o    (tag3[2]),
      .tag2_o    (tag2[2]),
      .tag1_o    (tag1[2]),
      .tag0_o    (tag0[2]),
      .busy_o    (schedule_busy[2])
  );

  // ---- sine and cosine: one at a time, joins the schedule when its result is near
  assign sin_join = sin_left_q == SinWidth'(fp_pkg::FP_DIVSQRT_LATENCY + 2);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sin_left_q <= '0;
      sin_busy_q <= 1'b0;
    end else if (issue_o && aux.sincos) begin
      sin_left_q <= SinWidth'(fp_pkg::FP_SINCOS_LATENCY);
      sin_busy_q <= 1'b1;
    end else if (sin_busy_q) begin
      sin_left_q <= sin_left_q - 1'b1;
      sin_busy_q <= sin_left_q != SinWidth'(1);
    end
  end

  always_ff @(posedge clk_i) begin
    if (issue_o && aux.sincos) sin_tag_q <= start_tag[2];
  end

`ifndef SYNTHESIS
  if (fp_pkg::FP_SINCOS_LATENCY < fp_pkg::FP_DIVSQRT_LATENCY + 2) begin : gen_check
    $error("asip_issue: FP_SINCOS_LATENCY must be at least FP_DIVSQRT_LATENCY + 2");
  end
`endif

  // ---- decision
  assign stall_operand_o = |wait_q;
  assign stall_unit_o    = aux.sincos && sin_busy_q;
  assign stall_port_o    =
      (aux.cmp && taken_c[fp_pkg::FP_CMP_LATENCY+3]) ||
      (aux.i2f && taken_c[fp_pkg::FP_I2F_LATENCY+3]) ||
      (aux.f2i && taken_c[fp_pkg::FP_F2I_LATENCY+3]) ||
      (aux.load && taken_c[asip_isa_pkg::MEMORY_LATENCY+3]) ||
      (aux.divsqrt && taken_c[fp_pkg::FP_DIVSQRT_LATENCY+3]);
  assign issue_o = enable_i && valid_d_i && !branch_wait_i && !stall_operand_o && !stall_unit_o &&
                   !stall_port_o;

  for (genvar b = 0; b < 3; b++) begin : gen_bank
    assign soon_o[b]        = place_valid[b][2] && !tag2[b][6];
    assign soon_index_o[b]  = tag2[b][5:0];
    assign next_o[b]        = place_valid[b][1] && !tag1[b][6];
    assign next_index_o[b]  = tag1[b][5:0];
    assign write_o[b]       = place_valid[b][0] && !tag0[b][6];
    assign write_index_o[b] = tag0[b][5:0];
  end
  assign write_output_o = place_valid[2][0] && tag0[2][6];
  assign busy_o         = (|schedule_busy) || sin_busy_q;

  logic unused_ops;
  assign unused_ops = ^{ops_d_i, ops_p_i, taken_c};

endmodule
