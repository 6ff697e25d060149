// SPDX-License-Identifier: Apache-2.0
// debug_run: holds the core at a bundle, steps it; breakpoints and watches.
// Contract: while held_o, no bundle issues from the next clock on but the one that a step or resume
// releases. halted_o: held inside a run, the bundle that is next waits in stage D, and every result of
// those before it is written. A watch sees a write one clock after write-back. A core that is never held
// issues as if this module were not there.
module debug_run (
    input  logic                    clk_i,
    input  logic                    rst_ni,
    // writes of registers
    input  logic                    csr_write_i,
    input  logic [5:0]              csr_index_i,
    input  logic [31:0]             csr_data_i,
    input  logic                    host_write_i,   // to a memory or register of the core, taken
    // from the core
    input  asip_pkg::hook_out_t     core_i,
    input  logic                    issue_i,
    input  logic [15:0]             pc_d_i,
    input  logic [3:0]              write_i,        // banks A, B, C, outputs
    input  logic [2:0][5:0]         write_index_i,
    input  logic [2:0][31:0]        write_data_i,
    // to the core
    output logic                    stop_q_o,
    output logic                    stop_d_o,
    output logic                    freeze_o,
    output logic                    abort_o,
    // to the registers
    output logic                    watchdog_runs_o,
    output logic                    stop_at_start_o,
    output logic [3:0]              breakpoints_o,  // enabled
    output logic [1:0]              watches_o,
    output logic                    held_o,
    output logic                    halted_o,
    output logic [2:0]              reason_o,
    output logic [2:0]              which_o,
    output logic [15:0]             next_o,
    output logic [15:0]             last_o
);

  localparam int unsigned Breakpoints = 4;
  localparam int unsigned Watches = 2;

  logic [Breakpoints-1:0] enable_q, match_q_q, match_d_q;
  logic [Breakpoints-1:0][15:0] break_q;
  logic [Watches-1:0] watch_enable_q, written_d, written_q, seen;
  logic [Watches-1:0][5:0] index_q;
  logic [Watches-1:0][1:0] bank_q;
  logic [Watches-1:0][31:0] mask_q, value_q, data_d, data_q;
  logic watchdog_runs_q, stop_at_start_q, abort_q;
  logic control, halt, resume, step, hit, watched, waits;
  logic held_q, halted_q, release_q, look_d, changed_q, late_q;
  logic wrote_q;  // a word of a stream or a bank may be on its way to its memory
  logic [15:0] looked;
  logic [2:0] reason_q, which_q, hit_which;
  logic [15:0] next_q, last_q;

  // ---- registers
  assign control = csr_write_i && csr_index_i == debug_regmap_pkg::REG_CONTROL;
  assign halt    = control && csr_data_i[debug_regmap_pkg::CONTROL_HALT_LSB];
  assign resume  = control && csr_data_i[debug_regmap_pkg::CONTROL_RESUME_LSB];
  assign step    = control && csr_data_i[debug_regmap_pkg::CONTROL_STEP_LSB];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      enable_q        <= '0;
      watch_enable_q  <= '0;
      watchdog_runs_q <= 1'b0;
      stop_at_start_q <= 1'b0;
      abort_q         <= 1'b0;
    end else begin
      abort_q <= control && csr_data_i[debug_regmap_pkg::CONTROL_ABORT_LSB];
      if (csr_write_i && csr_index_i == debug_regmap_pkg::REG_ENABLE) begin
        enable_q       <= csr_data_i[debug_regmap_pkg::ENABLE_BREAKPOINTS_LSB+:Breakpoints];
        watch_enable_q <= csr_data_i[debug_regmap_pkg::ENABLE_WATCHES_LSB+:Watches];
      end
      if (csr_write_i && csr_index_i == debug_regmap_pkg::REG_MODE) begin
        watchdog_runs_q <= csr_data_i[debug_regmap_pkg::MODE_WATCHDOG_RUNS_LSB];
        stop_at_start_q <= csr_data_i[debug_regmap_pkg::MODE_STOP_AT_START_LSB];
      end
    end
  end

  // ---- breakpoints: one comparator each, a clock ahead of the bundle that will be in Q; what was found goes
  // with the bundle to D. After a write of the host between two runs it looks at the bundle in D, then at the
  // one in Q, before a run begins that the host starts next. Where D took its bundle in the clock between, that
  // run begins a clock later.
  assign look_d = (changed_q || late_q) && !core_i.run && !core_i.advance;
  assign looked = core_i.advance ? core_i.pc_p : look_d ? pc_d_i : core_i.pc_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      changed_q <= 1'b0;
      late_q    <= 1'b0;
      wrote_q   <= 1'b0;
    end else begin
      wrote_q   <= host_write_i && halted_q;
      changed_q <= csr_write_i && (csr_index_i == debug_regmap_pkg::REG_ENABLE ||
                   (csr_index_i & ~(6'(Breakpoints - 1))) == debug_regmap_pkg::REG_BREAK);
      late_q    <= changed_q && core_i.advance && !core_i.run;
    end
  end

  genvar b, w;
  generate
    for (b = 0; b < Breakpoints; b++) begin : gen_break
      logic match;
      assign match = enable_q[b] && break_q[b] == looked;

      always_ff @(posedge clk_i) begin
        if (csr_write_i && csr_index_i == debug_regmap_pkg::REG_BREAK + 6'(b)) begin
          break_q[b] <= csr_data_i[debug_regmap_pkg::BREAK_VALUE_LSB+:16];
        end
        if (!look_d) match_q_q[b] <= match;
        // A breakpoint that is disabled holds the bundle in D no more.
        match_d_q[b] <= enable_q[b] && (core_i.advance ? match_q_q[b] : look_d ? match : match_d_q[b]);
      end
    end

    // ---- watches
    for (w = 0; w < Watches; w++) begin : gen_watch
      assign data_d[w]    = bank_q[w][1] ? write_data_i[2] :
                          bank_q[w][0] ? write_data_i[1] : write_data_i[0];
      assign written_d[w] = (bank_q[w][1] ? (bank_q[w][0] ? write_i[3] : write_i[2]) :
                           bank_q[w][0] ? write_i[1] : write_i[0]) &&
                          (bank_q[w][1] ? write_index_i[2] :
                           bank_q[w][0] ? write_index_i[1] : write_index_i[0]) == index_q[w];

      always_ff @(posedge clk_i) begin
        if (csr_write_i && csr_index_i == debug_regmap_pkg::REG_WATCH_PLACE + 6'(w)) begin
          index_q[w] <= csr_data_i[debug_regmap_pkg::WATCH_PLACE_INDEX_LSB+:6];
          bank_q[w]  <= csr_data_i[debug_regmap_pkg::WATCH_PLACE_BANK_LSB+:2];
        end
        if (csr_write_i && csr_index_i == debug_regmap_pkg::REG_WATCH_MASK + 6'(w)) begin
          mask_q[w] <= csr_data_i;
        end
        if (csr_write_i && csr_index_i == debug_regmap_pkg::REG_WATCH_VALUE + 6'(w)) begin
          value_q[w] <= csr_data_i;
        end
        data_q[w] <= data_d[w];
      end

      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) written_q[w] <= 1'b0;
        else written_q[w] <= written_d[w] && watch_enable_q[w] && core_i.busy;
      end

      assign seen[w] = written_q[w] && !(|((data_q[w] ^ value_q[w]) & mask_q[w]));
    end
  endgenerate

  // ---- state
  assign waits   = core_i.run && core_i.valid_d && !core_i.branch_wait && !issue_i;
  assign hit     = waits && (|match_d_q) && !release_q;
  assign watched = |seen;

  always_comb begin
    hit_which = 3'd3;
    if (match_d_q[2]) hit_which = 3'd2;
    if (match_d_q[1]) hit_which = 3'd1;
    if (match_d_q[0]) hit_which = 3'd0;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      held_q    <= 1'b0;
      halted_q  <= 1'b0;
      release_q <= 1'b0;
      reason_q  <= debug_regmap_pkg::STOP_REASON_NONE;
      which_q   <= 3'd0;
    end else begin
      halted_q <= core_i.run && (halted_q || (held_q && waits && core_i.quiet && !release_q));
      if (issue_i || !core_i.run) release_q <= 1'b0;
      if (resume) begin
        held_q    <= 1'b0;
        reason_q  <= debug_regmap_pkg::STOP_REASON_NONE;
      end
      if (!held_q) begin
        if (core_i.run_start && stop_at_start_q) begin
          held_q   <= 1'b1;
          reason_q <= debug_regmap_pkg::STOP_REASON_START;
        end
        if (hit) begin
          held_q   <= 1'b1;
          reason_q <= debug_regmap_pkg::STOP_REASON_BREAKPOINT;
          which_q  <= hit_which;
        end
      end
      if (watched) begin
        held_q   <= 1'b1;
        reason_q <= debug_regmap_pkg::STOP_REASON_WATCH;
        which_q  <= {2'd0, !seen[0]};
      end
      if (halt) begin
        held_q <= 1'b1;
        if (!held_q) reason_q <= debug_regmap_pkg::STOP_REASON_REQUEST;
      end
      if (step) begin
        held_q   <= 1'b1;
        reason_q <= debug_regmap_pkg::STOP_REASON_STEP;
      end
      if ((resume && held_q && core_i.run) || (step && halted_q)) begin
        release_q <= 1'b1;
        halted_q  <= 1'b0;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (!halted_q) next_q <= pc_d_i;
    if (issue_i) last_q <= pc_d_i;
  end

  assign stop_q_o = held_q || (|match_q_q);
  assign stop_d_o = ((held_q || (|match_d_q) || (stop_at_start_q && !core_i.run)) && !release_q) ||
                    late_q || wrote_q;
  assign freeze_o = halted_o && !watchdog_runs_q;
  assign abort_o  = abort_q;
  assign watchdog_runs_o = watchdog_runs_q;
  assign stop_at_start_o = stop_at_start_q;
  assign breakpoints_o   = enable_q;
  assign watches_o       = watch_enable_q;
  assign held_o   = held_q;
  assign halted_o = halted_q && core_i.run;  // a fault ends it
  assign reason_o = reason_q;
  assign which_o  = which_q;
  assign next_o   = next_q;
  assign last_o   = last_q;

  logic unused_core;
  assign unused_core = ^core_i;

endmodule
