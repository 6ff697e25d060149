// SPDX-License-Identifier: Apache-2.0
// debug_scope: ring of records, trigger, black box.
// Contract: a record is taken from the clock after a run has ended, a word a clock, and compared with the
// trigger in the clock after its last word. wait_k_o holds the host's writes of bank K meanwhile, so that
// the record is that of the run. A run that ends in a fault is recorded whatever the decimation, then the
// ring is frozen. A read of the ring takes a clock.
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
    // words of the channels, one a clock from the clock after ended_i on
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

  logic                 control, arm, freeze, command, records_now, active, record, full_record;
  logic                 recording_q, judge_q, fault_q, black_box_q, triggered_q, command_q;
  logic [1:0]           state_q;
  logic [2:0]           last_q, kind_q, trigger_channel_q, size_mask;
  logic                 float_q, low_q, high_q, before_q, before_valid_q;
  logic [15:0]          skip_q, skipped_q;
  logic [CountBits-1:0] pre_q, post_q;
  logic [CountBits-1:0] left_q;    // records to come, and the last one
  logic [31:0]          level_low_q, level_high_q, records_q, triggered_at_q;
  logic [RingLog2-1:0]  at_q;
  logic [31:0]          memory[0:(1<<RingLog2)-1];
  logic [31:0]          ring_q;
  logic                 hit, enough, trigger;

  // ---- registers
  assign control = csr_write_i && csr_index_i == debug_regmap_pkg::REG_CONTROL;
  assign arm     = control && csr_data_i[debug_regmap_pkg::CONTROL_ARM_LSB];
  assign freeze  = control && csr_data_i[debug_regmap_pkg::CONTROL_FREEZE_LSB];
  assign command = control && csr_data_i[debug_regmap_pkg::CONTROL_TRIGGER_LSB];

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
      if (csr_index_i == debug_regmap_pkg::REG_RECORD) begin
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
  // negative one is below any other, and two negative float32 are in the opposite order
  function automatic logic at_least(input logic [31:0] word, input logic [31:0] level,
                                    input logic is_float);
    if (word[31] != level[31]) at_least = level[31];
    else if (is_float && word[31]) at_least = word[30:0] == level[30:0] || !(word[30:0] >= level[30:0]);
    else at_least = word[30:0] >= level[30:0];
  endfunction

  always_ff @(posedge clk_i) begin
    if (csr_write_i && csr_index_i == debug_regmap_pkg::REG_TRIGGER_LOW) begin
      level_low_q <= csr_data_i;
    end
    if (csr_write_i && csr_index_i == debug_regmap_pkg::REG_TRIGGER_HIGH) begin
      level_high_q <= csr_data_i;
    end
    if (recording_q && channel_i == trigger_channel_q) begin
      low_q  <= at_least(word_i, level_low_q, float_q);
      high_q <= !at_least(level_high_q, word_i, float_q);
    end
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
  assign record      = recording_q;
  assign full_record = recording_q && channel_i == last_q;
  assign enough      = (|records_q[31:CountBits]) || records_q[CountBits-1:0] >= pre_q;
  assign trigger     = judge_q && state_q == debug_regmap_pkg::SCOPE_STATE_WAITING && enough &&
                       (hit || command_q);

  // Lowest bits of a record's address: as many as a channel's number needs.
  assign size_mask = {last_q[2], |last_q[2:1], |last_q};

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q        <= debug_regmap_pkg::SCOPE_STATE_IDLE;
      recording_q    <= 1'b0;
      judge_q        <= 1'b0;
      fault_q        <= 1'b0;
      black_box_q    <= 1'b0;
      triggered_q    <= 1'b0;
      command_q      <= 1'b0;
      before_valid_q <= 1'b0;
      before_q       <= 1'b0;
      skipped_q      <= '0;
      left_q         <= '0;
      records_q      <= '0;
      at_q           <= '0;
    end else begin
      judge_q <= full_record;
      if (active && ended_i) skipped_q <= skipped_q == 16'd0 ? skip_q : skipped_q - 16'd1;
      if (full_record) recording_q <= 1'b0;
      if (records_now) begin
        recording_q <= 1'b1;
        fault_q     <= fault_i;
      end
      if (command && state_q == debug_regmap_pkg::SCOPE_STATE_WAITING) command_q <= 1'b1;
      if (judge_q) begin
        records_q      <= records_q + 32'd1;
        at_q           <= (at_q | RingLog2'(size_mask)) + 1'b1;
        before_q       <= low_q;
        before_valid_q <= 1'b1;
        left_q         <= left_q - 1'b1;
        if (state_q == debug_regmap_pkg::SCOPE_STATE_TRIGGERED && left_q == CountBits'(2) &&
            |post_q) begin
          state_q <= debug_regmap_pkg::SCOPE_STATE_FROZEN;
        end
        if (trigger) begin
          triggered_q <= 1'b1;
          left_q      <= post_q;
          state_q     <= post_q == CountBits'(1) ? debug_regmap_pkg::SCOPE_STATE_FROZEN
                                                 : debug_regmap_pkg::SCOPE_STATE_TRIGGERED;
        end
        if (fault_q) begin
          state_q     <= debug_regmap_pkg::SCOPE_STATE_FROZEN;
          black_box_q <= 1'b1;
        end
      end
      if (freeze) begin
        state_q     <= debug_regmap_pkg::SCOPE_STATE_FROZEN;
        recording_q <= 1'b0;
        judge_q     <= 1'b0;
      end
      if (arm) begin
        state_q        <= debug_regmap_pkg::SCOPE_STATE_WAITING;
        recording_q    <= 1'b0;
        judge_q        <= 1'b0;
        black_box_q    <= 1'b0;
        triggered_q    <= 1'b0;
        command_q      <= 1'b0;
        before_valid_q <= 1'b0;
        skipped_q      <= '0;
        records_q      <= '0;
        at_q           <= '0;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (trigger) triggered_at_q <= records_q;
    if (record) memory[at_q|RingLog2'(channel_i)] <= word_i;
    ring_q <= memory[ring_address_i];
  end

  assign wait_k_o       = records_now || recording_q;
  assign ring_data_o    = ring_q;
  assign state_o        = state_q;
  assign black_box_o    = black_box_q;
  assign triggered_o    = triggered_q;
  assign records_o      = records_q;
  assign triggered_at_o = triggered_at_q;
  assign last_channel_o = last_q;
  assign size_log2_o    = {size_mask[1], size_mask[2] || (size_mask[0] && !size_mask[1])};
  assign armed_o        = arm;

endmodule
