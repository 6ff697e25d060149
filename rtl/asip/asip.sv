// SPDX-License-Identifier: Apache-2.0
// asip: the floating-point ASIP with its Avalon-MM host port. Top level.
// Contract: one clock, asynchronous active-low reset. FmaPipes = 2, Slots = 3 is configuration `fast`,
// FmaPipes = 1, Slots = 1 is `small`. StreamWords other than 0 makes a constant memory of that size for each
// multiply-add pipe of `fast`, whose words are operands; Loops other
// than 0 makes as many levels of loops (configuration `stream`), Lanes as many further lanes of each pipe (`wide`). Pipeline: F1 F2 fetch, P Q hazards, D issue, R1 R2 register
// read, E1.. units, W write-back; see docs/architecture.md. The trace ports report every bundle issued and
// every register or output written; leave them open in hardware.
module asip #(
    parameter int unsigned FmaPipes  = 2,
    parameter int unsigned Slots     = 3,
    parameter int unsigned Bundles   = asip_isa_pkg::PROGRAM_BUNDLES,
    parameter int unsigned DataWords = asip_isa_pkg::DATA_WORDS,
    parameter int unsigned Debug     = 0,  // 1: the hooks of a debug block (rtl/debug) are there
    parameter int unsigned Resilience = 0,  // 1: survives a flipped bit (docs/upsets.md); `fast` only
    parameter int unsigned Plausible  = 1,   // 1: with Resilience, a plausibility record of outputs
    parameter int unsigned StreamWords = 0,  // of the stream of each multiply-add pipe; 0: none
    parameter int unsigned Loops       = 0,  // levels of loops
    parameter int unsigned Lanes       = 0   // of each multiply-add pipe, besides the first
) (
    input  logic                                      clk_i,
    input  logic                                      rst_ni,
    // Avalon-MM agent
    input  logic [asip_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic                                      read_i,
    input  logic                                      write_i,
    input  logic [31:0]                               writedata_i,
    output logic [31:0]                               readdata_o,
    output logic                                      waitrequest_o,
    output logic                                      irq_o,
    // trace: issue in stage D; write-back of banks A, B, C and outputs
    output logic                                      trace_issue_o,
    output logic [15:0]                               trace_pc_o,
    output logic [3:0]                                trace_write_o,
    output logic [2:0][5:0]                           trace_index_o,
    output logic [2:0][31:0]                          trace_data_o,
    // of a debug block; tied to zero and open without one
    input  asip_pkg::hook_in_t                        hook_i,
    output asip_pkg::hook_out_t                       hook_o
);

  localparam int unsigned OpWidth = asip_pkg::DECODED_WIDTH;
  localparam int unsigned ConstantBits = $clog2(asip_regmap_pkg::WORDS_CONSTANTS);
  localparam int unsigned WordWidth = asip_isa_pkg::OP_WIDTH;
  localparam int unsigned ControlWidth = asip_isa_pkg::CONTROL_WIDTH;
  localparam int unsigned BundleWidth = Slots * WordWidth + ControlWidth;
  localparam int unsigned DecodedWidth = Slots * OpWidth + 2 + Loops;  // {ends of loops, reserved, halt, operations}
  localparam int unsigned Ports = 3 * Slots;
  localparam int unsigned LaneBits = 2;  // addresses of a bundle in program memory: four

  // ---- stages F and D
  logic [BundleWidth-1:0] bundle_f2;
  logic [ControlWidth-1:0] control_f2;
  logic [DecodedWidth-1:0] decoded_f2, decoded_p, decoded_q, decoded_d;
  logic [Slots-1:0] illegal_op_p;
  logic [Slots*OpWidth-1:0] ops_f2, ops_p, ops_q, ops_d;
  logic reserved_p, halt_p, illegal_p, valid_q, bad_q;
  logic valid_d, halt_d, bad_d, pc_bad_d, flush, advance, issue;
  logic [15:0] pc_d;
  logic run, run_next, branch_wait, stall_operand, stall_unit, issue_busy;
  logic [Ports-1:0][8:0] source_d;
  logic valid_f2, valid_p, turn;
  logic [15:0] pc_f2, turn_pc;
  // ---- stages R1, R2 and E1
  logic valid_r1_q, valid_r2_q, valid_e1_q;
  logic branch_e1, branch_taken, redirect_q;
  logic [15:0] target_q;
  logic [15:0] pc_r1_q, pc_r2_q, pc_e1_q, pc_e2_q;
  logic [Slots*OpWidth-1:0] ops_r1_q, ops_r2_q, ops_e1_q;
  logic [Ports-1:0][31:0] early_r2, operand_e1;
  logic [Ports-1:0][31:0] own_r2;  // of the slot's own bank or stream
  logic [Ports-1:0] late_r2;  // the operand is C's result
  logic [Ports-1:0] fresh_r2;  // .. the slot's own
  asip_pkg::decoded_t aux_p, aux_d, aux_e1;
  logic address_fault;
  // ---- write-back
  logic [2:0] soon, next, write;
  logic [2:0][5:0] soon_index, next_index, write_index;
  logic [2:0][31:0] result;
  logic write_output, not_finite;
  logic [4:0] not_finite_index;
  fp_pkg::flags_t flags;
  // ---- control and host
  logic run_start, commit, fault, busy, done, start, clear, refetch, host_refetch;
  logic [3:0] cause;
  logic [15:0] fault_info, entry;
  // ---- redundancy
  asip_pkg::guard_t guard;
  logic rst_run_n, bad_word_p, bad_constant_e1, output_parity, bad_output;
  logic broken_host, broken_outputs, repaired, checking, implausible;
  logic [4:0] implausible_index;
  logic read_record, read_shown, host_record, run_busy;
  logic [4:0] read_index;
  logic [31:0] judged_word;
  // ---- debug block
  asip_pkg::hook_in_t hook;
  logic ended, quiet;
  logic [15:0] pc_p, pc_q;
  logic [31:0] watchdog, output_mask, cycles, count;
  logic [2:0] count_select;
  logic host_constant, host_safe, host_register, host_data, host_program;
  logic host_select, host_hold, host_bank_k;
  // ---- streams
  logic host_stream;
  logic [15:0] stream_address;
  logic [1:0][31:0] stream_r1;
  logic [1:0][Lanes:0][31:0] words_r1;  // by lane
  logic [1:0] stream_lane;
  logic [Ports-1:0][31:0] operand_units;
  fp_pkg::flags_t flags_lanes;
  logic [31:0] host_output, host_memory, host_word;

  // ================================================================ F and D
  genvar s;
  generate
    for (s = 0; s < Slots; s++) begin : gen_decode
      asip_pkg::decoded_t op;
      asip_decode #(
          .CanFma(s < FmaPipes),
          .CanAux(s == Slots - 1),
          .CanSeek(StreamWords != 0),
          .CanLoop(Loops != 0),
          .CanLane(Lanes != 0 && s < FmaPipes)
      ) u_decode (
          .word_i(bundle_f2[WordWidth*s+:WordWidth]),
          .op_o  (op)
      );
      assign ops_f2[OpWidth*s+:OpWidth] = op;

      asip_check #(
          .FmaPipes(FmaPipes),
          .Slot    (s),
          .Streams (StreamWords != 0),
          .Loops   (Loops),
          .Lanes   (Lanes)
      ) u_check (
          .op_i     (ops_p[OpWidth*s+:OpWidth]),
          .illegal_o(illegal_op_p[s])
      );
    end
  endgenerate

  // control[0] is halt, then come the ends of loops, the other control bits are reserved.
  assign control_f2 = bundle_f2[BundleWidth-1-:ControlWidth];
  assign decoded_f2[Slots*OpWidth+1:0] = {
    |control_f2[ControlWidth-1:1+Loops], control_f2[asip_isa_pkg::HALT_BIT], ops_f2
  };

  asip_fetch #(
      .Bundles     (Bundles),
      .BundleWidth (BundleWidth),
      .DecodedWidth(DecodedWidth),
      .Resilience  (Resilience)
  ) u_fetch (
      .clk_i,
      .rst_ni,
      .redirect_i    (flush || guard.sweep_first),
      .redirect_pc_i (guard.sweep ? 16'd0 :
                      refetch ? (hook.open ? hook.pc : entry) : target_q),
      .advance_i     (guard.sweep ? guard.sweep_step : advance),
      .turn_i        (turn),
      .turn_pc_i     (turn_pc),
      .valid_f2_o    (valid_f2),
      .pc_f2_o       (pc_f2),
      .valid_p_o     (valid_p),
      .bundle_f2_o   (bundle_f2),
      .decoded_f2_i  (decoded_f2),
      .decoded_p_o   (decoded_p),
      .illegal_p_i   (illegal_p),
      .valid_q_o     (valid_q),
      .bad_q_o       (bad_q),
      .decoded_q_o   (decoded_q),
      .valid_d_o     (valid_d),
      .bad_d_o       (bad_d),
      .pc_bad_d_o    (pc_bad_d),
      .pc_d_o        (pc_d),
      .pc_p_o        (pc_p),
      .pc_q_o        (pc_q),
      .decoded_d_o   (decoded_d),
      .bad_word_p_o  (bad_word_p),
      .write_i       (host_program),
      .write_bundle_i(address_i[LaneBits+:$clog2(Bundles)]),
      .write_lane_i  (address_i[LaneBits-1:0]),
      .write_data_i  (writedata_i)
  );

  assign {reserved_p, halt_p, ops_p} = decoded_p[Slots*OpWidth+1:0];
  assign ops_q = decoded_q[Slots*OpWidth-1:0];
  assign {halt_d, ops_d} = decoded_d[Slots*OpWidth:0];
  assign aux_p = ops_p[OpWidth*(Slots-1)+:OpWidth];
  assign aux_d = ops_d[OpWidth*(Slots-1)+:OpWidth];

  // Illegal: an operation, a reserved control bit, a branch in the last bundle.
  assign illegal_p = (|illegal_op_p) || reserved_p ||
                     (halt_p && (aux_p.jump || aux_p.branch_zero || aux_p.branch_nonzero));

  generate
    if (Loops != 0) begin : gen_loops
      logic [Loops-1:0] ends_f2;

      assign ends_f2                           = control_f2[asip_isa_pkg::LOOP_BIT+:Loops];
      assign decoded_f2[DecodedWidth-1-:Loops] = ends_f2;

      asip_loops #(
          .Loops(Loops)
      ) u_loops (
          .clk_i,
          .rst_ni,
          .clear_i   (refetch && !hook.open),
          .branch_i  (redirect_q),
          .resume_i  (refetch && hook.open),
          .advance_i (advance),
          .valid_f2_i(valid_f2),
          .pc_f2_i   (pc_f2),
          .ends_f2_i (ends_f2),
          .loop_p_i  (valid_p && aux_p.loop),
          .imm_p_i   (aux_p.imm),
          .issue_i   (issue),
          .pc_d_i    (pc_d),
          .loop_d_i  (aux_d.loop),
          .imm_d_i   (aux_d.imm),
          .ends_d_i  (decoded_d[DecodedWidth-1-:Loops]),
          .turn_o    (turn),
          .turn_pc_o (turn_pc)
      );
    end else begin : gen_no_loops
      logic unused_loops;
      assign turn         = 1'b0;
      assign turn_pc      = '0;
      assign unused_loops = ^{valid_f2, pc_f2, valid_p};
    end
  endgenerate

  asip_issue #(
      .FmaPipes(FmaPipes),
      .Slots   (Slots)
  ) u_issue (
      .clk_i,
      .rst_ni         (rst_run_n),
      .flush_i        (flush),
      .ops_p_i        (ops_p),
      .valid_q_i      (valid_q),
      .bad_q_i        (bad_q || hook.stop_q),
      .ops_q_i        (ops_q),
      .valid_d_i      (valid_d),
      .bad_d_i        (bad_d || hook.stop_d),
      .ops_d_i        (ops_d),
      .run_i          (run),
      .run_next_i     (run_next),
      .advance_o      (advance),
      .issue_o        (issue),
      .branch_wait_o  (branch_wait),
      .branch_e1_o    (branch_e1),
      .stall_operand_o(stall_operand),
      .stall_unit_o   (stall_unit),
      .source_d_o     (source_d),
      .soon_o         (soon),
      .soon_index_o   (soon_index),
      .next_o         (next),
      .next_index_o   (next_index),
      .write_o        (write),
      .write_index_o  (write_index),
      .write_output_o (write_output),
      .busy_o         (issue_busy)
  );

  // ================================================================ R1, R2 and E1
  always_ff @(posedge clk_i or negedge rst_run_n) begin
    if (!rst_run_n) begin
      valid_r1_q <= 1'b0;
      valid_r2_q <= 1'b0;
      valid_e1_q <= 1'b0;
    end else begin
      valid_r1_q <= issue;
      valid_r2_q <= valid_r1_q;
      valid_e1_q <= valid_r2_q;
    end
  end

  always_ff @(posedge clk_i) begin
    ops_r1_q <= ops_d;
    ops_r2_q <= ops_r1_q;
    ops_e1_q <= ops_r2_q;
    pc_r1_q  <= pc_d;
    pc_r2_q  <= pc_r1_q;
    pc_e1_q  <= pc_r2_q;
    pc_e2_q  <= pc_e1_q;
  end

  // Streams step in the cycle in which a bundle issues; nothing in the pipeline waits for them.
  genvar p;
  generate
    if (StreamWords != 0) begin : gen_streams
      for (p = 0; p < FmaPipes; p++) begin : gen_stream
        asip_pkg::decoded_t op_q, aux_q;
        logic [2:0] reads_q, reads_d;
        logic [32*(Lanes+1)-1:0] word_r1;  // by lane

        assign stream_r1[p]         = word_r1[31:0];
        assign words_r1[p][Lanes:0] = word_r1;

        assign op_q    = ops_q[OpWidth*p+:OpWidth];
        assign aux_q   = ops_q[OpWidth*(Slots-1)+:OpWidth];
        assign reads_q = {
          op_q.c[8:6] == asip_isa_pkg::BANK_S,
          op_q.b[8:6] == asip_isa_pkg::BANK_S,
          op_q.a[8:6] == asip_isa_pkg::BANK_S
        };
        // Sources a, b, c of the slot are ports 3p to 3p+2 of the operand stage.
        assign reads_d = {
          source_d[3*p+2][8:6] == asip_isa_pkg::BANK_S,
          source_d[3*p+1][8:6] == asip_isa_pkg::BANK_S,
          source_d[3*p][8:6] == asip_isa_pkg::BANK_S
        };

        asip_stream #(
            .Words(StreamWords),
            .Lanes(Lanes)
        ) u_stream (
            .clk_i,
            .rst_ni,
            .clear_i        (refetch && !hook.open),
            .flush_i        (flush),
            .advance_i      (advance),
            .take_q_i       (valid_q && (|reads_q)),
            .seek_q_i       (valid_q && aux_q.seek && aux_q.imm[15] == 1'(p)),
            .seek_address_q_i(aux_q.imm[14:0]),
            .take_i         (issue && (|reads_d)),
            .seek_i         (issue && aux_d.seek && aux_d.imm[15] == 1'(p)),
            .seek_address_i (aux_d.imm[14:0]),
            .word_r1_o      (word_r1),
            .write_i        (host_stream && stream_address[15] == 1'(p)),
            .write_lane_i   (stream_lane),
            .write_address_i(stream_address[14:0]),
            .write_data_i   (writedata_i)
        );

        logic unused_q;
        assign unused_q = ^{op_q, aux_q};
      end
    end else begin : gen_no_streams
      logic unused_streams;
      assign stream_r1      = '0;
      assign words_r1       = '0;
      assign unused_streams = ^{host_stream, stream_address, stream_lane};
    end
  endgenerate

  asip_operands #(
      .FmaPipes  (FmaPipes),
      .Ports     (Ports),
      .Resilience(Resilience),
      .StreamWords(StreamWords)
  ) u_operands (
      .clk_i,
      .source_d_i           (source_d),
      .soon_i               (soon),
      .soon_index_i         (soon_index),
      .next_i               (next),
      .next_index_i         (next_index),
      .write_i              (write),
      .write_index_i        (write_index),
      .write_data_i         (result),
      .host_read_i          (host_select),
      .host_write_i         (host_register),
      .host_write_constant_i(host_constant),
      .host_register_i      ({host_bank_k, address_i[ConstantBits] && !host_bank_k, address_i[ConstantBits-1:0]}),
      .host_data_i          (writedata_i),
      .stream_r1_i          (stream_r1),
      .guard_i              (guard),
      .bad_constant_e1_o    (bad_constant_e1),
      .early_r2_o           (early_r2),
      .late_r2_o            (late_r2),
      .own_r2_o             (own_r2),
      .fresh_r2_o           (fresh_r2),
      .operand_e1_o         (operand_e1)
  );

  assign aux_e1 = ops_e1_q[OpWidth*(Slots-1)+:OpWidth];

  // Branches are decided in E1 and redirect in E2; until then nothing after them issues.
  assign branch_taken = aux_e1.jump ||
                        (aux_e1.branch_nonzero && (|operand_e1[Ports-3][30:0])) ||
                        (aux_e1.branch_zero && !(|operand_e1[Ports-3][30:0]));

  always_ff @(posedge clk_i or negedge rst_run_n) begin
    if (!rst_run_n) redirect_q <= 1'b0;
    else redirect_q <= branch_e1 && branch_taken;
  end

  always_ff @(posedge clk_i) target_q <= aux_e1.imm;

  assign flush = redirect_q || refetch;

  // ================================================================ lanes
  generate
    if (Lanes != 0) begin : gen_lanes
      logic [5*FmaPipes*(Lanes+1)-1:0] flags_lane;

      for (p = 0; p < FmaPipes; p++) begin : gen_pipe
        asip_pkg::decoded_t op_r2, op_e1;
        logic [95:0] addend_r2;  // of the further lanes
        logic [31:0] addend_lanes_r2;
        logic [2:0] vector_r2;  // by operand
        logic [31:0] a_r2, b_r2, c_r2;
        logic [31:0] factor_e1_q, addend_e1_q;  // operands b, c
        logic keep_r2, least_r2, keep_e1_q, least_e1_q;  // what the limit leaves of operand a
        logic [1:0] nan_r2, nan_e1_q;
        asip_pkg::facts_t facts_r2;  // of operand a, a vector
        logic [7:0] power_r2;  // of operand b, a vector
        localparam logic [2:0] Own = p == 0 ? asip_isa_pkg::BANK_A : asip_isa_pkg::BANK_B;

        assign op_r2                = ops_r2_q[OpWidth*p+:OpWidth];
        assign op_e1                = ops_e1_q[OpWidth*p+:OpWidth];
        assign flags_lane[5*p*(Lanes+1)+:5] = '0;
        // A lane has words of its own for registers of the pipe's bank, in field c always, elsewhere if the
        // operation says so, and for the stream.
        assign vector_r2[0] = (op_r2.every && op_r2.a[8:6] == Own) || op_r2.a[8:6] == asip_isa_pkg::BANK_S;
        assign vector_r2[1] = op_r2.every && op_r2.b[8:6] == Own;
        assign vector_r2[2] = op_r2.c[8:6] == Own || op_r2.c[8:6] == asip_isa_pkg::BANK_ZERO;

        // Before the multiply-add `vbelow` and `vabove` limit operand a, and `vscale` makes 2^n of b, with n its lowest
        // 8 bits. That operand is a vector, so of all results only the pipe's own can be it. What the limit asks is
        // answered for the result and for what else the operand may be, side by side.
        assign facts_r2 = asip_pkg::facts_of(own_r2[3*p]) |
                          ({4{fresh_r2[3*p]}} & asip_pkg::facts_of(result[p]));
        assign power_r2 = own_r2[3*p+1][7:0] | ({8{fresh_r2[3*p+1]}} & result[p][7:0]);

        asip_limit u_limit (
            .below_i(op_r2.below),
            .above_i(op_r2.above),
            .facts_i(facts_r2),
            .keep_o (keep_r2),
            .nan_o  (nan_r2),
            .least_o(least_r2)
        );

        always_ff @(posedge clk_i) begin
          {keep_e1_q, nan_e1_q, least_e1_q} <= {keep_r2, nan_r2, least_r2};
          factor_e1_q <= op_r2.power ? asip_pkg::power_of_two(power_r2) : b_r2;
          addend_e1_q <= op_r2.pick && (|op_r2.b[1:0]) ? addend_lanes_r2 : c_r2;
        end

        assign a_r2 = early_r2[3*p] | ({32{late_r2[3*p]}} & result[2]);
        assign b_r2 = early_r2[3*p+1] | ({32{late_r2[3*p+1]}} & result[2]);
        assign c_r2 = early_r2[3*p+2] | ({32{late_r2[3*p+2]}} & result[2]);

        assign operand_units[3*p]   = asip_pkg::limited(operand_e1[3*p], keep_e1_q, nan_e1_q, least_e1_q);
        assign operand_units[3*p+1] = factor_e1_q;
        assign operand_units[3*p+2] = addend_e1_q;
        assign addend_lanes_r2      = op_r2.b[1:0] == 2'd1 ? addend_r2[31:0] :
                                      op_r2.b[1:0] == 2'd2 ? addend_r2[63:32] : addend_r2[95:64];

        logic unused_op;
        assign unused_op = ^{op_r2, op_e1};

        for (s = 1; s < 4; s++) begin : gen_lane
          if (s <= Lanes) begin : gen_there
            asip_lane u_lane (
                .clk_i,
                .rst_ni       (rst_run_n),
                .source_d_i   (source_d[3*p+:3]),
                .soon_i       (soon[p]),
                .soon_index_i (soon_index[p]),
                .next_i       (next[p]),
                .next_index_i (next_index[p]),
                .word_r1_i    (words_r1[p][s]),
                .kind_r2_i    (op_r2.fma_kind),
                .power_r2_i   (op_r2.power),
                .below_r2_i   (op_r2.below),
                .above_r2_i   (op_r2.above),
                .own_r2_i     (vector_r2),
                .operand_r2_i ({c_r2, b_r2, a_r2}),
                .addend_r2_o  (addend_r2[32*(s-1)+:32]),
                .start_e1_i   (valid_e1_q && op_e1.lanes && !op_e1.pick),
                .flags_o      (flags_lane[5*(p*(Lanes+1)+s)+:5])
            );
          end else begin : gen_none
            assign addend_r2[32*(s-1)+:32] = '0;
          end
        end
      end
      assign operand_units[Ports-1:3*FmaPipes] = operand_e1[Ports-1:3*FmaPipes];

      always_comb begin
        flags_lanes = '0;
        for (int unsigned i = 0; i < FmaPipes * (Lanes + 1); i++) begin
          flags_lanes = flags_lanes | flags_lane[5*i+:5];
        end
      end
    end else begin : gen_no_lanes
      logic unused_words;
      assign operand_units = operand_e1;
      assign flags_lanes   = '0;
      assign unused_words  = ^words_r1;
    end
  endgenerate

  // ================================================================ units
  asip_units #(
      .FmaPipes (FmaPipes),
      .Slots    (Slots),
      .DataWords(DataWords)
  ) u_units (
      .clk_i,
      .rst_ni,
      .rst_run_ni     (rst_run_n),
      .clear_flags_i  (run_start),
      .valid_e1_i     (valid_e1_q),
      .ops_e1_i       (ops_e1_q),
      .operand_e1_i   (operand_units),
      .flags_lanes_i  (flags_lanes),
      .result_o       (result),
      .flags_o        (flags),
      .address_fault_o(address_fault),
      .host_select_i  (host_select),
      .host_write_i   (write_i),
      .host_data_i    (host_data),
      .host_address_i (16'(address_i[$clog2(asip_regmap_pkg::WORDS_DATA)-1:0])),
      .host_word_i    (writedata_i),
      .host_word_o    (host_word),
      .host_read_o    (host_memory)
  );

  // ================================================================ control, outputs, host
  asip_run #(
      .Bundles   (Bundles),
      .Resilience(Resilience)
  ) u_run (
      .clk_i,
      .rst_ni,
      .rst_run_no        (rst_run_n),
      .start_i           (start),
      .clear_i           (clear),
      .refetch_i         (host_refetch),
      .watchdog_i        (watchdog),
      .output_mask_i     (output_mask),
      .freeze_i          (hook.freeze),
      .abort_i           (hook.stop_run),
      .valid_d_i         (valid_d),
      .bad_d_i           (bad_d),
      .pc_bad_d_i        (pc_bad_d),
      .halt_d_i          (halt_d),
      .pc_d_i            (pc_d),
      .issue_i           (issue),
      .branch_wait_i     (branch_wait),
      .stall_operand_i   (stall_operand),
      .stall_unit_i      (stall_unit),
      .output_d_i        (aux_d.to_output),
      .output_index_d_i  (aux_d.dst[4:0]),
      .inflight_i        (valid_r1_q || valid_r2_q || valid_e1_q),
      .busy_i            (issue_busy),
      .address_fault_e2_i(address_fault),
      .pc_e2_i           (pc_e2_q),
      .not_finite_i      (not_finite),
      .not_finite_index_i(not_finite_index),
      .run_o             (run),
      .run_next_o        (run_next),
      .refetch_o         (refetch),
      .run_start_o       (run_start),
      .commit_o          (commit),
      .fault_o           (fault),
      .ended_o           (ended),
      .quiet_o           (quiet),
      .busy_o            (busy),
      .run_busy_o        (run_busy),
      .done_o            (done),
      .cause_o           (cause),
      .fault_info_o      (fault_info),
      .cycles_o          (cycles),
      .count_select_i    (count_select),
      .count_o           (count),
      .host_write_i      (write_i),
      .host_register_i   (host_register),
      .wrote_i           ({write_output, write}),
      .index_i           (write_index),
      .result_i          (result),
      .bad_program_i     (bad_word_p),
      .bad_constant_i    (bad_constant_e1),
      .valid_e1_i        (valid_e1_q),
      .bad_output_i      (bad_output),
      .broken_i          (broken_host || broken_outputs),
      .checking_i        (checking),
      .implausible_i     (implausible),
      .implausible_index_i(implausible_index),
      .guard_o           (guard),
      .repaired_o        (repaired)
  );

  asip_outputs #(
      .Resilience(Resilience)
  ) u_outputs (
      .clk_i,
      .rst_ni,
      .commit_i         (commit),
      .fault_i          (fault),
      .write_i          (write_output),
      .index_i          (write_index[2][4:0]),
      .data_i           (result[2]),
      .not_finite_o     (not_finite),
      .not_finite_index_o(not_finite_index),
      .read_record_i    (read_record),
      .read_shown_i     (read_shown),
      .read_index_i     (read_index),
      .word_o           (judged_word),
      .host_write_safe_i(host_safe),
      .host_write_record_i(host_record),
      .host_index_i     (address_i[$clog2(asip_regmap_pkg::WORDS_OUTPUTS)-1:0]),
      .host_data_i      (host_word),
      .host_read_o      (host_output),
      .parity_o         (output_parity),
      .broken_o         (broken_outputs)
  );

  generate
    if (Resilience != 0 && Plausible != 0) begin : gen_plausible
      asip_plausible u_plausible (
          .clk_i,
          .rst_ni,
          .run_start_i  (run_start),
          .busy_i       (run_busy),
          .commit_i     (commit),
          .fault_i      (fault),
          .write_i      (write_output),
          .index_i      (write_index[2][4:0]),
          .read_record_o(read_record),
          .read_shown_o (read_shown),
          .read_index_o (read_index),
          .word_i       (judged_word),
          .checking_o   (checking),
          .implausible_o(implausible),
          .index_o      (implausible_index),
          .host_write_i (host_record),
          .host_index_i (address_i[$clog2(asip_regmap_pkg::WORDS_OUTPUTS)-1:0]),
          .host_on_i    (writedata_i[asip_regmap_pkg::PLAUSIBLE_ON_JUDGED_LSB])
      );
    end else begin : gen_no_plausible
      logic unused_plausible;
      assign checking          = 1'b0;
      assign implausible       = 1'b0;
      assign implausible_index = '0;
      assign read_record       = 1'b0;
      assign read_shown        = 1'b0;
      assign read_index        = '0;
      assign unused_plausible  = ^{judged_word, run_busy};
    end
  endgenerate

  asip_host #(
      .Slots    (Slots),
      .FmaPipes (FmaPipes),
      .Bundles  (Bundles),
      .DataWords(DataWords),
      .Debug    (Debug),
      .Resilience(Resilience),
      .Plausible (Plausible),
      .StreamWords(StreamWords),
      .Loops     (Loops),
      .Lanes     (Lanes)
  ) u_host (
      .clk_i,
      .rst_ni,
      .address_i,
      .read_i,
      .write_i,
      .writedata_i,
      .readdata_o,
      .waitrequest_o,
      .irq_o,
      .start_o         (start),
      .clear_o         (clear),
      .refetch_o       (host_refetch),
      .watchdog_o      (watchdog),
      .entry_o         (entry),
      .output_mask_o   (output_mask),
      .busy_i          (busy),
      .hold_i          (host_hold),
      .copy_i          (guard.copy),
      .repaired_i      (repaired),
      .broken_o        (broken_host),
      .output_parity_i (output_parity),
      .bad_output_o    (bad_output),
      .done_i          (done),
      .fault_i         (fault),
      .cause_i         (cause),
      .fault_info_i    (fault_info),
      .flags_i         (flags),
      .cycles_i        (cycles),
      .count_select_o  (count_select),
      .count_i         (count),
      .write_constant_o(host_constant),
      .write_safe_o    (host_safe),
      .write_register_o(host_register),
      .write_data_o    (host_data),
      .write_program_o (host_program),
      .write_record_o  (host_record),
      .write_stream_o  (host_stream),
      .stream_address_o(stream_address),
      .stream_lane_o   (stream_lane),
      .select_o        (host_select),
      .read_output_i   (host_output),
      .read_register_i (operand_e1[Ports-3]),
      .read_data_i     (host_memory)
  );

`ifndef SYNTHESIS
  generate
    if (!(FmaPipes == 1 && Slots == 1) && !(FmaPipes == 2 && Slots == 3)) begin : gen_check_shape
      $error("asip: FmaPipes=%0d, Slots=%0d, must be 2 and 3 (fast) or 1 and 1 (small)", FmaPipes, Slots);
    end
    if (Resilience != 0 && (Slots == 1 || Debug != 0)) begin : gen_check_resilience
      $error("asip: Resilience=1 is for configuration fast without a debug block");
    end
    if (StreamWords != 0 && (2 ** $clog2(
            StreamWords
        ) != StreamWords || StreamWords > 2 ** 15 || StreamWords < 2)) begin : gen_check_streams
      $error("asip: StreamWords=%0d, must be 0 or a power of two from 2 to 32768", StreamWords);
    end
    if (StreamWords != 0 && (Slots == 1 || Resilience != 0)) begin : gen_check_stream_shape
      $error("asip: StreamWords=%0d is for configuration fast without Resilience", StreamWords);
    end
    if (Loops != 0 && (Loops > asip_isa_pkg::LOOP_LEVELS || Slots == 1 || Resilience != 0)) begin : gen_check_loops
      $error(
          "asip: Loops=%0d, must be 0 to %0d, for configuration fast without Resilience",
          Loops,
          asip_isa_pkg::LOOP_LEVELS
      );
    end
    if (Lanes != 0 && (Lanes > 3 || StreamWords == 0)) begin : gen_check_lanes
      $error("asip: Lanes=%0d, must be 0 to 3, with StreamWords", Lanes);
    end
    // verilog_format: off - it breaks calls inside their parentheses
  if (2 ** $clog2(Bundles) != Bundles || Bundles > asip_isa_pkg::PROGRAM_BUNDLES ||
      2 ** $clog2(DataWords) != DataWords || DataWords > asip_isa_pkg::DATA_WORDS) begin : gen_check_size
  // verilog_format: on
      $error(
          "asip: Bundles=%0d, DataWords=%0d, must be powers of two, at most %0d and %0d",
          Bundles,
          DataWords,
          asip_isa_pkg::PROGRAM_BUNDLES,
          asip_isa_pkg::DATA_WORDS
      );
    end
  endgenerate
`endif

  // ================================================================ debug block
  generate
    if (Debug != 0) begin : gen_hook
      assign hook        = hook_i;
      assign host_bank_k = 32'(address_i) / asip_regmap_pkg::WORDS_CONSTANTS ==
                         asip_regmap_pkg::BASE_CONSTANTS / asip_regmap_pkg::WORDS_CONSTANTS;
      assign hook_o      = {advance, valid_d, branch_wait, run, run_start, busy, ended, fault, quiet,
                          pc_p, pc_q, cycles};
    end else begin : gen_no_hook
      logic unused_hook;
      assign hook        = '0;
      assign host_bank_k = 1'b0;
      assign hook_o      = '0;
      assign unused_hook = ^{hook_i, ended, quiet, pc_p, pc_q};
    end
  endgenerate
  assign host_hold = (busy && !hook.open) || hook.wait_k;

  // ================================================================ trace
  assign trace_issue_o = issue;
  assign trace_pc_o    = pc_d;
  assign trace_write_o = {write_output, write};
  assign trace_index_o = write_index;
  assign trace_data_o  = result;

  logic unused_ops;
  assign unused_ops = ^{ops_e1_q, early_r2, late_r2, own_r2, fresh_r2, decoded_p, decoded_q, decoded_d};

endmodule
