// SPDX-License-Identifier: Apache-2.0
// asip_issue: hazard interlocks and write schedules (stage D).
// Contract: a bundle issues, all its operations together, in the first cycle in which every source and
// destination has no write in flight (a write ends for a reader latency + 1 cycles after its issue),
// the write port of bank C is free in the cycle its auxiliary result needs it, sine/cosine is idle,
// and no branch is undecided. Any program is therefore correct whatever its schedule.
module asip_issue #(
    parameter int unsigned FmaPipes = 2,
    parameter int unsigned Slots    = 3
) (
    input  logic                                           clk_i,
    input  logic                                           rst_ni,
    // from fetch
    input  logic                                           valid_d_i,
    input  logic [Slots*asip_pkg::DECODED_WIDTH-1:0]    ops_d_i,
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
    output logic [2:0]                                     next_valid_o,
    output logic [2:0][5:0]                                next_index_o,
    output logic [2:0]                                     write_o,
    output logic [2:0][5:0]                                write_index_o,
    output logic                                           write_output_o,
    output logic                                           busy_o
);

  localparam int unsigned OpWidth = asip_pkg::DECODED_WIDTH;
  localparam int unsigned Ports = 3 * Slots;
  localparam int unsigned AuxSlot = Slots - 1;
  localparam int unsigned FmaPlaces = fp_pkg::FP_FMA_LATENCY + 3;
  localparam int unsigned FmaPlaceWidth = $clog2(FmaPlaces);
  localparam int unsigned AuxPlaces = fp_pkg::FP_DIVSQRT_LATENCY + 3;
  localparam int unsigned LatencyWidth = $clog2(AuxPlaces);
  localparam int unsigned SinWidth = $clog2(fp_pkg::FP_SINCOS_LATENCY + 1);

  logic [Ports-1:0][8:0]  source;
  logic [Ports-1:0]       source_pending;
  logic [Ports:0][5:0]    query_a, query_b, query_c;
  logic [Ports:0]         pending_a, pending_b, pending_c;
  logic [2:0]             starts_write, dst_pending;
  logic [2:0][6:0]        start_tag;
  logic [2:0][2:0]        place_valid;
  logic [2:0][6:0]        tag2, tag1, tag0;
  logic [2:0]             schedule_busy;
  logic                   collides, aux_timed, sin_join;
  logic [LatencyWidth-1:0] aux_latency;
  logic [SinWidth-1:0]    sin_left_q;
  logic [6:0]             sin_tag_q;
  asip_pkg::decoded_t     aux;

  // ---- what the bundle wants
  for (genvar s = 0; s < Slots; s++) begin : gen_slot
    asip_pkg::decoded_t op;
    assign op = ops_d_i[OpWidth*s+:OpWidth];
    assign source[3*s]   = op.a;
    assign source[3*s+1] = op.b;
    assign source[3*s+2] = op.c;
    if (s < FmaPipes) begin : gen_fma
      assign starts_write[s] = op.fma;
      assign start_tag[s]    = {1'b0, op.dst};
    end
  end
  if (FmaPipes < 2) begin : gen_one_pipe
    assign starts_write[1] = 1'b0;
    assign start_tag[1]    = '0;
  end

  assign aux = ops_d_i[OpWidth*AuxSlot+:OpWidth];
  assign starts_write[2] = aux.writes && !aux.fma;
  assign start_tag[2]    = {aux.to_output, aux.dst};
  assign source_d_o      = source;

  always_comb begin
    aux_latency = LatencyWidth'(fp_pkg::FP_CMP_LATENCY);
    if (aux.divsqrt) aux_latency = LatencyWidth'(fp_pkg::FP_DIVSQRT_LATENCY);
    if (aux.i2f) aux_latency = LatencyWidth'(fp_pkg::FP_I2F_LATENCY);
    if (aux.f2i) aux_latency = LatencyWidth'(fp_pkg::FP_F2I_LATENCY);
    if (aux.load) aux_latency = LatencyWidth'(asip_isa_pkg::MEMORY_LATENCY);
  end
  assign aux_timed = starts_write[2] && !aux.sincos;

  // ---- writes in flight
  for (genvar p = 0; p < Ports; p++) begin : gen_source
    assign query_a[p] = source[p][5:0];
    assign query_b[p] = source[p][5:0];
    assign query_c[p] = source[p][5:0];
    assign source_pending[p] = (source[p][8:6] == asip_isa_pkg::BANK_A && pending_a[p]) ||
                               (source[p][8:6] == asip_isa_pkg::BANK_B && pending_b[p]) ||
                               (source[p][8:6] == asip_isa_pkg::BANK_C && pending_c[p]);
  end
  assign query_a[Ports] = start_tag[0][5:0];
  assign query_b[Ports] = start_tag[1][5:0];
  assign query_c[Ports] = start_tag[2][5:0];
  assign dst_pending[0] = starts_write[0] && pending_a[Ports];
  assign dst_pending[1] = starts_write[1] && pending_b[Ports];
  assign dst_pending[2] = starts_write[2] && !aux.to_output && pending_c[Ports];

  asip_scoreboard #(
      .Queries(Ports + 1)
  ) u_scoreboard_a (
      .clk_i,
      .rst_ni,
      .set_i        (issue_o && starts_write[0]),
      .set_index_i  (start_tag[0][5:0]),
      .clear_i      (place_valid[0][2]),
      .clear_index_i(tag2[0][5:0]),
      .query_i      (query_a),
      .pending_o    (pending_a)
  );

  if (FmaPipes > 1) begin : gen_scoreboard_b
    asip_scoreboard #(
        .Queries(Ports + 1)
    ) u_scoreboard_b (
        .clk_i,
        .rst_ni,
        .set_i        (issue_o && starts_write[1]),
        .set_index_i  (start_tag[1][5:0]),
        .clear_i      (place_valid[1][2]),
        .clear_index_i(tag2[1][5:0]),
        .query_i      (query_b),
        .pending_o    (pending_b)
    );
  end else begin : gen_no_scoreboard_b
    logic unused_b;
    assign pending_b = '0;
    assign unused_b  = ^{query_b, place_valid[1][2], tag2[1]};
  end

  asip_scoreboard #(
      .Queries(Ports + 1)
  ) u_scoreboard_c (
      .clk_i,
      .rst_ni,
      .set_i        (issue_o && starts_write[2] && !aux.to_output),
      .set_index_i  (start_tag[2][5:0]),
      .clear_i      (place_valid[2][2] && !tag2[2][6]),
      .clear_index_i(tag2[2][5:0]),
      .query_i      (query_c),
      .pending_o    (pending_c)
  );

  for (genvar p = 0; p < FmaPipes; p++) begin : gen_schedule
    logic unused_collides;
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
        .collides_o(unused_collides),
        .valid_o   (place_valid[p]),
        .tag2_o    (tag2[p]),
        .tag1_o    (tag1[p]),
        .tag0_o    (tag0[p]),
        .busy_o    (schedule_busy[p])
    );
  end
  if (FmaPipes < 2) begin : gen_no_schedule_b
    assign place_valid[1]   = '0;
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
      .collides_o(collides),
      .valid_o   (place_valid[2]),
      .tag2_o    (tag2[2]),
      .tag1_o    (tag1[2]),
      .tag0_o    (tag0[2]),
      .busy_o    (schedule_busy[2])
  );

  // ---- sine and cosine: one at a time, joins the schedule when its result is near
  assign sin_join = sin_left_q == SinWidth'(fp_pkg::FP_DIVSQRT_LATENCY + 2);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) sin_left_q <= '0;
    else if (issue_o && aux.sincos) sin_left_q <= SinWidth'(fp_pkg::FP_SINCOS_LATENCY);
    else if (sin_left_q != '0) sin_left_q <= sin_left_q - 1'b1;
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
  assign stall_operand_o = (|source_pending) || (|dst_pending);
  assign stall_unit_o    = aux.sincos && sin_left_q != '0;
  assign stall_port_o    = aux_timed && collides;
  assign issue_o = enable_i && valid_d_i && !branch_wait_i && !stall_operand_o && !stall_unit_o &&
                   !stall_port_o;

  for (genvar b = 0; b < 3; b++) begin : gen_bank
    assign next_valid_o[b]  = place_valid[b][1] && !tag1[b][6];
    assign next_index_o[b]  = tag1[b][5:0];
    assign write_o[b]       = place_valid[b][0] && !tag0[b][6];
    assign write_index_o[b] = tag0[b][5:0];
  end
  assign write_output_o = place_valid[2][0] && tag0[2][6];
  assign busy_o         = (|schedule_busy) || sin_left_q != '0;

  logic unused_ops;
  assign unused_ops = ^ops_d_i;

endmodule
