// SPDX-License-Identifier: Apache-2.0
// asip_control: run state, faults and cycle counters.
// Contract: a run is accepted when the first bundle waits in stage D, so every run of a program takes
// the same number of cycles. cycles_o counts from that cycle to done or fault, and is the sum of issued
// bundles, stalls, fetch and drain cycles; these counters follow one cycle late. The first fault of a
// run wins; the core then drains, and is faulted from then on until clear_i.
module asip_control #(
    parameter int unsigned Resilience = 0  // 1: the state has an inverted copy
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    // from the host
    input  logic        start_i,
    input  logic        clear_i,
    input  logic        refetch_i,
    input  logic [31:0] watchdog_i,
    input  logic [31:0] output_mask_i,
    // from a debug block: counters hold, the run ends with the fault WATCHDOG
    input  logic        freeze_i,
    input  logic        abort_i,
    // from stage D
    input  logic        valid_d_i,
    input  logic        bad_d_i,         // illegal or outside program memory
    input  logic        pc_bad_d_i,      // of these, outside program memory
    input  logic        halt_d_i,
    input  logic [15:0] pc_d_i,
    input  logic        issue_i,
    input  logic        branch_wait_i,
    input  logic        stall_operand_i,
    input  logic        stall_unit_i,
    input  logic        output_d_i,
    input  logic [4:0]  output_index_d_i,
    // from R1 to E2 and write-back; not_finite_i comes a cycle after write-back
    input  logic        inflight_i,
    input  logic        busy_i,
    input  logic        address_fault_e2_i,
    input  logic [15:0] pc_e2_i,
    input  logic        not_finite_i,
    input  logic [4:0]  not_finite_index_i,
    // to issue, fetch and outputs
    output logic        run_o,
    output logic        run_next_o,
    output logic        refetch_o,
    output logic        run_start_o,
    output logic        commit_o,
    output logic        fault_o,
    output logic        ended_o,     // pulse, in the first clock after a run
    output logic        quiet_o,     // nothing was in flight in the cycle before
    output logic        broken_o,    // the state is none
    // to the host
    output logic        busy_o,
    output logic        done_o,
    output logic [3:0]  cause_o,
    output logic [15:0] fault_info_o,
    output logic [31:0] cycles_o,
    input  logic [2:0]  count_select_i,  // low bits of the register STALL_* or DRAIN
    output logic [31:0] count_o          // .. in the next cycle
);

  typedef enum logic [1:0] {
    StIdle,  // waits for start
    StRun,   // bundles issue
    StDrain  // halt or fault: results in flight are written
  } state_e;

  // Where FAULT_INFO comes from.
  typedef enum logic [1:0] {
    InfoOutput,
    InfoE2,
    InfoD,
    InfoLast
  } info_e;

  state_e state_d, state_q;
  info_e info_from;
  logic start_q, busy_q, done_d, done_q, fault_d, fault_q, info_load;
  logic [3:0] cause_d, cause_q;
  logic [15:0] info_d, info_q, last_pc_q;
  logic [31:0] unwritten_q, ahead_q;
  logic [3:0] written_high;
  logic [7:0] written_low;
  logic [31:0] cycles_q;
  logic event_d, event_q, same_q, fresh_q, counted_q;
  logic [2:0] event_of, event_of_q;
  logic [7:0] seen_q;
  logic [31:0] count, count_q, read_event, read_host;
  logic running, active, bad_d, drained, run_start, refetch, started;
  logic quiet_q, missing_q, watchdog_q, refetch_q;

  assign running   = state_q == StRun;
  assign active    = state_q != StIdle;
  assign bad_d     = valid_d_i && !branch_wait_i && bad_d_i;
  assign drained   = state_q == StDrain && quiet_q;
  assign refetch   = refetch_i || refetch_q;
  assign run_start = state_q == StIdle && start_q && valid_d_i && !refetch;
  assign started   = run_start || active;

  always_comb begin
    state_d = state_q;
    done_d  = done_q;
    fault_d = fault_q;
    cause_d = cause_q;
    info_from = InfoLast;
    info_load = 1'b0;
    case (state_q)
      StIdle: begin
        if (clear_i) begin
          done_d  = 1'b0;
          fault_d = 1'b0;
          cause_d = asip_regmap_pkg::FAULT_NONE;
        end
        if (run_start) begin
          state_d = StRun;
          done_d  = 1'b0;
        end
      end
      StRun: if (issue_i && halt_d_i) state_d = StDrain;
      default: begin
        if (drained) begin
          state_d = StIdle;
          if (!fault_q) begin
            done_d = 1'b1;
            if (missing_q) begin
              fault_d = 1'b1;
              cause_d = asip_regmap_pkg::FAULT_OUTPUT_MISSING;
              info_load = 1'b1;
            end
          end
        end
      end
    endcase
    // Faults, oldest operation first.
    if (active && !fault_q) begin
      if (not_finite_i) begin
        fault_d = 1'b1;
        cause_d = asip_regmap_pkg::FAULT_NOT_FINITE;
        info_from = InfoOutput;
        info_load = 1'b1;
      end else if (address_fault_e2_i) begin
        fault_d = 1'b1;
        cause_d = asip_regmap_pkg::FAULT_ADDRESS;
        info_from = InfoE2;
        info_load = 1'b1;
      end else if (running && bad_d) begin
        fault_d = 1'b1;
        cause_d = pc_bad_d_i ? asip_regmap_pkg::FAULT_ADDRESS :
                  asip_regmap_pkg::FAULT_ILLEGAL;
        info_from = InfoD;
        info_load = 1'b1;
      end else if (watchdog_q) begin
        fault_d = 1'b1;
        cause_d = asip_regmap_pkg::FAULT_WATCHDOG;
        info_load = 1'b1;
      end
    end
    if (fault_d) begin
      done_d = 1'b0;
      if (running) state_d = StDrain;
    end
    case (info_from)
      InfoOutput: info_d = {11'd0, not_finite_index_i};
      InfoE2:     info_d = pc_e2_i;
      InfoD:      info_d = pc_d_i;
      default:    info_d = last_pc_q;
    endcase
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q    <= StIdle;
      start_q    <= 1'b0;
      busy_q     <= 1'b0;
      done_q     <= 1'b0;
      fault_q    <= 1'b0;
      cause_q    <= 4'd0;
      quiet_q    <= 1'b0;
      watchdog_q <= 1'b0;
      refetch_q  <= 1'b0;
    end else begin
      state_q    <= state_d;
      start_q    <= (start_q || (start_i && !fault_q && !active)) && !run_start;
      // active or start_q of the next cycle: what the host may write is decided after a register
      busy_q     <= start_q || (active ? !drained : start_i && !fault_q);
      done_q     <= done_d;
      fault_q    <= fault_d;
      cause_q    <= cause_d;
      quiet_q    <= !issue_i && !inflight_i && !busy_i;
      refetch_q  <= active && state_d == StIdle;
      // set from the cycle on in which CYCLES is WATCHDOG
      watchdog_q <= ((watchdog_q || abort_i) && active) || (started && ahead_q == watchdog_i);
    end
  end

  always_ff @(posedge clk_i) begin
    if (info_load) info_q <= info_d;
    missing_q <= |unwritten_q;
    if (issue_i) last_pc_q <= pc_d_i;
  end

  // Outputs of the mask that no bundle has written. The index is decoded in two parts, so that one takes
  // five inputs.
  genvar i;
  generate
    for (i = 0; i < 4; i++) begin : gen_written_high
      assign written_high[i] = issue_i && output_d_i && output_index_d_i[4:3] == 2'(i);
    end
    for (i = 0; i < 8; i++) begin : gen_written_low
      assign written_low[i] = output_index_d_i[2:0] == 3'(i);
    end
    for (i = 0; i < 32; i++) begin : gen_unwritten
      always_ff @(posedge clk_i) begin
        unwritten_q[i] <= run_start ? output_mask_i[i] : unwritten_q[i] && !(written_high[i/8] && written_low[i%8]);
      end
    end

    if (Resilience != 0) begin : gen_code
      // Two codes differ in two bits.
      logic [1:0] code;
      (* keep *) logic [1:0] inverse_q;
      assign code = state_q;
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) inverse_q <= ~StIdle;
        else inverse_q <= ~state_d;
      end
      assign broken_o = code != ~inverse_q;
    end else begin : gen_no_code
      assign broken_o = 1'b0;
    end
  endgenerate

  // CYCLES follows a counter that is one ahead, 0 when a run is accepted.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) cycles_q <= 32'd0;
    else if (started && !freeze_i) cycles_q <= ahead_q;
  end

  always_ff @(posedge clk_i) begin
    if (!started) ahead_q <= 32'd0;
    else if (!freeze_i) ahead_q <= ahead_q + 32'd1;
  end

  // The other counters are words of a memory under the low bits of their addresses. A cycle counts for one
  // of them at most: its word is read in that cycle, and written, one more, in the next. A word that has
  // not been written since the start of the run is zero.
  always_comb begin
    event_d  = 1'b0;
    event_of = asip_regmap_pkg::REG_DRAIN[2:0];
    if (active && (!running || bad_d)) begin
      event_d = !freeze_i;
    end else if (running && !issue_i) begin
      event_d = !freeze_i;
      if (!valid_d_i || branch_wait_i) event_of = asip_regmap_pkg::REG_STALL_FETCH[2:0];
      else if (stall_operand_i) event_of = asip_regmap_pkg::REG_STALL_OPERAND[2:0];
      else if (stall_unit_i) event_of = asip_regmap_pkg::REG_STALL_UNIT[2:0];
      else event_of = asip_regmap_pkg::REG_STALL_PORT[2:0];
    end
  end

  assign count = (same_q ? count_q : fresh_q ? 32'd0 : read_event) + 32'd1;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      event_q <= 1'b0;
      seen_q  <= '0;
    end else begin
      event_q <= event_d;
      if (run_start) seen_q <= '0;
      else if (event_q) seen_q[event_of_q] <= 1'b1;
    end
  end

  always_ff @(posedge clk_i) begin
    event_of_q <= event_of;
    same_q     <= event_q && event_of == event_of_q;
    fresh_q    <= !seen_q[event_of];
    counted_q  <= seen_q[count_select_i];
    count_q    <= count;
  end

`ifndef SYNTHESIS
  // A counter's place in the bank is the low bits of its register's address.
  localparam logic [10:0] Operand = 11'd1 << asip_regmap_pkg::REG_STALL_OPERAND[2:0];
  localparam logic [10:0] Port = 11'd1 << asip_regmap_pkg::REG_STALL_PORT[2:0];
  localparam logic [10:0] Unit = 11'd1 << asip_regmap_pkg::REG_STALL_UNIT[2:0];
  localparam logic [10:0] Fetch = 11'd1 << asip_regmap_pkg::REG_STALL_FETCH[2:0];
  localparam logic [10:0] Drain = 11'd1 << asip_regmap_pkg::REG_DRAIN[2:0];
  generate
    if (Operand + Port + Unit + Fetch + Drain != (Operand | Port | Unit | Fetch | Drain)) begin : gen_check_counters
      $error("asip_control: registers STALL_* and DRAIN must differ in the low three address bits");
    end
  endgenerate
`endif

  asip_regbank #(
      .IndexWidth(3),
      .ReadPorts (2)
  ) u_counts (
      .clk_i,
      .write_i      (event_q),
      .write_index_i(event_of_q),
      .write_data_i (count),
      .read_index_i ({count_select_i, event_of}),
      .read_data_o  ({read_host, read_event})
  );

  assign run_o           = running;
  assign run_next_o      = run_start || (running && !(issue_i && halt_d_i));
  assign refetch_o       = refetch;
  assign run_start_o     = run_start;
  assign commit_o        = drained && done_d && !fault_d;
  assign fault_o         = fault_q && !active;
  assign ended_o         = refetch_q;
  assign quiet_o         = quiet_q;
  assign busy_o          = busy_q;
  assign done_o          = done_q;
  assign cause_o         = fault_o ? cause_q : asip_regmap_pkg::FAULT_NONE;
  assign fault_info_o    = info_q;
  assign cycles_o        = cycles_q;
  assign count_o         = {32{counted_q}} & read_host;

endmodule
