// SPDX-License-Identifier: Apache-2.0
// debug_scope: ring of records, trigger, black box.
// Contract: a record is taken from the second clock after a run has ended, a word a clock, and compared with the
// trigger in three clocks after its last word. wait_k_o holds the host's writes of bank K until that word is
// taken, so that the record is that of the run. A run that ends in a fault is recorded whatever the
// decimation, then the ring is frozen. A read of the ring takes a clock.
module debug_scope #(
    parameter int unsigned RingLog2 = 12
) (
    input  logic                clk_i,
    input  logic                rst_ni,
    // writes of registers
    input  logic                csr_write_i,
    input  logic [5:0]          csr_index_i,
    input  logic [31:0]         csr_data_i,
    // from the core
    input  logic                ended_i,
    input  logic                fault_i,
    output logic                wait_k_o,
    // words of the channels, one a clock from the second clock after ended_i on
    input  logic [2:0]          channel_i,
    input  logic [31:0]         word_i,
    // reads of the ring
    input  logic [RingLog2-1:0] ring_address_i,
    output logic [31:0]         ring_data_o,
    // to the registers and the stream of samples
    output logic [1:0]          state_o,
    output logic                black_box_o,
    output logic                triggered_o,
    output logic [31:0]         records_o,
    output logic [31:0]         triggered_at_o,
    output logic [2:0]          last_channel_o,
    output logic [1:0]          size_log2_o,
    output logic                armed_o
);

  localparam int unsigned CountBits = debug_regmap_pkg::AROUND_PRE_WIDTH;

  logic control, arm, freeze, command, set_record, records_now, active, full_record;
  logic begins_q, recording_q, judge, fault_q, black_box_q, triggered_q, command_q;
  logic begun_q, clear;
  logic [2:0] ended_q;  // clocks after the last word of a record
  logic [1:0] state_q, size_log2;
  logic [2:0] last_q, kind_q, trigger_channel_q;
  logic float_q, low_q, high_q, before_q, before_valid_q;
  logic [15:0] skip_q, skipped_q;
  logic [CountBits-1:0] pre_q, post_q;
  logic [CountBits-1:0] after_q, after;  // records from the trigger on
  logic [31:0] records_q, triggered_at_q;
  logic [31:0] levels[0:1];
  logic [31:0] judged_q, level;
  logic lower_q, upper_q, reversed, above;
  logic [31:0] memory[0:(1<<RingLog2)-1];
  logic [31:0] ring_q;
  logic [RingLog2-1:0] at;
  logic hit, enough, trigger, count, full;

  // ---- registers
  assign control = csr_write_i && csr_index_i == debug_regmap_pkg::REG_CONTROL;
  assign arm     = control && csr_data_i[debug_regmap_pkg::CONTROL_ARM_LSB];
  assign freeze  = control && csr_data_i[debug_regmap_pkg::CONTROL_FREEZE_LSB];
  assign command = control && csr_data_i[debug_regmap_pkg::CONTROL_TRIGGER_LSB];
  assign set_record = csr_write_i && csr_index_i == debug_regmap_pkg::REG_RECORD;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      last_q            <= 3'd7;
      skip_q            <= '0;
      kind_q            <= debug_regmap_pkg::TRIGGER_KIND_NEVER;
      float_q           <= 1'b1;
      trigger_channel_q <= '0;
      pre_q             <= '0;
      post_q            <= '0;
    end else if (csr_write_i) begin
      if (set_record) begin
        last_q <= csr_data_i[debug_regmap_pkg::RECORD_LAST_CHANNEL_LSB+:3];
        skip_q <= csr_data_i[debug_regmap_pkg::RECORD_SKIP_LSB+:16];
      end
      if (csr_index_i == debug_regmap_pkg::REG_TRIGGER) begin
        kind_q            <= csr_data_i[debug_regmap_pkg::TRIGGER_KIND_LSB+:3];
        float_q           <= csr_data_i[debug_regmap_pkg::TRIGGER_FLOAT_LSB];
        trigger_channel_q <= csr_data_i[debug_regmap_pkg::TRIGGER_CHANNEL_LSB+:3];
      end
      if (csr_index_i == debug_regmap_pkg::REG_AROUND) begin
        pre_q  <= csr_data_i[debug_regmap_pkg::AROUND_PRE_LSB+:CountBits];
        post_q <= csr_data_i[debug_regmap_pkg::AROUND_POST_LSB+:CountBits];
      end
    end
  end

  // ---- order of float32 (-0 below +0, NaN beyond infinity) or int32, out of that of unsigned numbers: a
  // negative one is below any other, and two negative float32 are in the opposite order. One comparator:
  // word >= lower level, then word > upper level; a bit after the last one makes `>` of `>=`.
  assign level    = levels[upper_q];
  assign reversed = float_q && level[31];
  assign above    = judged_q[31] != level[31] ? level[31] :
                    ({judged_q[30:0], 1'b0} >= {level[30:0], upper_q ^ reversed}) ^ reversed;

  always_ff @(posedge clk_i) begin
    if (csr_write_i && csr_index_i[5:1] == debug_regmap_pkg::REG_TRIGGER_LOW[5:1]) begin
      levels[csr_index_i[0]] <= csr_data_i;
    end
    lower_q <= recording_q && channel_i == trigger_channel_q;
    upper_q <= lower_q;
    if (recording_q && channel_i == trigger_channel_q) judged_q <= word_i;
    if (lower_q) low_q <= above;
    if (upper_q) high_q <= above;
  end

  always_comb begin
    case (kind_q)
      debug_regmap_pkg::TRIGGER_KIND_ABOVE: hit = low_q;
      debug_regmap_pkg::TRIGGER_KIND_BELOW: hit = !low_q;
      debug_regmap_pkg::TRIGGER_KIND_RISING: hit = low_q && before_valid_q && !before_q;
      debug_regmap_pkg::TRIGGER_KIND_FALLING: hit = !low_q && before_valid_q && before_q;
      debug_regmap_pkg::TRIGGER_KIND_INSIDE: hit = low_q && !high_q;
      debug_regmap_pkg::TRIGGER_KIND_OUTSIDE: hit = !low_q || high_q;
      debug_regmap_pkg::TRIGGER_KIND_NOW: hit = 1'b1;
      default: hit = 1'b0;
    endcase
  end

  // ---- records
  assign active      = state_q == debug_regmap_pkg::SCOPE_STATE_WAITING ||
                       state_q == debug_regmap_pkg::SCOPE_STATE_TRIGGERED;
  assign records_now = active && ended_i && (fault_i || skipped_q == 16'd0);
  assign full_record = recording_q && channel_i == last_q;
  assign judge       = ended_q[2];
  assign enough      = (|records_q[31:CountBits]) || records_q[CountBits-1:0] >= pre_q;
  assign trigger     = judge && state_q == debug_regmap_pkg::SCOPE_STATE_WAITING && enough &&
                       (hit || command_q);
  assign count       = trigger || (judge && state_q == debug_regmap_pkg::SCOPE_STATE_TRIGGERED);
  assign after       = after_q + 1'b1;
  assign full        = after == post_q && |post_q;

  // Counters are cleared by their clock: with their carry chain that is no logic.
  assign clear = arm || !begun_q;

  always_ff @(posedge clk_i) begin
    if (clear) records_q <= '0;
    else if (judge) records_q <= records_q + 32'd1;

    if (clear) after_q <= '0;
    else if (count) after_q <= after;

    if (clear || set_record) skipped_q <= '0;
    else if (active && ended_i) skipped_q <= skipped_q == skip_q ? 16'd0 : skipped_q + 16'd1;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q        <= debug_regmap_pkg::SCOPE_STATE_IDLE;
      begins_q       <= 1'b0;
      recording_q    <= 1'b0;
      ended_q        <= '0;
      begun_q        <= 1'b0;
      fault_q        <= 1'b0;
      black_box_q    <= 1'b0;
      triggered_q    <= 1'b0;
      command_q      <= 1'b0;
      before_valid_q <= 1'b0;
      before_q       <= 1'b0;
    end else begin
      begun_q  <= 1'b1;
      ended_q  <= {ended_q[1:0], full_record};
      begins_q <= records_now;
      if (full_record) recording_q <= 1'b0;
      if (records_now) fault_q <= fault_i;
      if (begins_q) recording_q <= 1'b1;
      if (command && state_q == debug_regmap_pkg::SCOPE_STATE_WAITING) command_q <= 1'b1;
      if (judge) begin
        before_q       <= low_q;
        before_valid_q <= 1'b1;
        if (trigger) triggered_q <= 1'b1;
        if (count) begin
          state_q <= full ? debug_regmap_pkg::SCOPE_STATE_FROZEN : debug_regmap_pkg::SCOPE_STATE_TRIGGERED;
        end
        if (fault_q) begin
          state_q     <= debug_regmap_pkg::SCOPE_STATE_FROZEN;
          black_box_q <= 1'b1;
        end
      end
      if (freeze) begin
        state_q     <= debug_regmap_pkg::SCOPE_STATE_FROZEN;
        begins_q    <= 1'b0;
        recording_q <= 1'b0;
        ended_q     <= '0;
      end
      if (arm) begin
        state_q        <= debug_regmap_pkg::SCOPE_STATE_WAITING;
        begins_q       <= 1'b0;
        recording_q    <= 1'b0;
        ended_q        <= '0;
        black_box_q    <= 1'b0;
        triggered_q    <= 1'b0;
        command_q      <= 1'b0;
        before_valid_q <= 1'b0;
      end
    end
  end

  assign size_log2 = last_q[2] ? 2'd3 : last_q[1] ? 2'd2 : {1'b0, last_q[0]};
  assign at        = RingLog2'(records_q << size_log2) | RingLog2'(channel_i);

  always_ff @(posedge clk_i) begin
    if (trigger) triggered_at_q <= records_q;
    if (recording_q) memory[at] <= word_i;
    ring_q <= memory[ring_address_i];
  end

  assign wait_k_o       = records_now || begins_q || recording_q;
  assign ring_data_o    = ring_q;
  assign state_o        = state_q;
  assign black_box_o    = black_box_q;
  assign triggered_o    = triggered_q;
  assign records_o      = records_q;
  assign triggered_at_o = triggered_at_q;
  assign last_channel_o = last_q;
  assign size_log2_o    = size_log2;
  assign armed_o        = arm;

endmodule
