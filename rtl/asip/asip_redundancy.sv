// SPDX-License-Identifier: Apache-2.0
// asip_redundancy: every tick runs twice, a third time if the two differ, and counts when two agree.
// Contract: is between host and control. Run 1 works on page 0 of banks A, B, C, run 2 on page 1, which
// hold the same states; page 2 has those of the tick before, from which run 3 begins on page 0. Runs are
// compared by a signature of every write-back, their end and cause. The core is reset before runs 2 and 3 and
// after each tick. Idle, the pages are made equal, then every word of program memory and bank K is read once.
// A tick lasts at most three times WATCHDOG + Drain clocks and three copies; then busy_o falls.
// A fault stays until clear_i, and no run begins meanwhile.
// Registers that matter have an inverted copy: one flipped bit is the fault CONTROL.
module asip_redundancy #(
    parameter int unsigned Bundles = 1024,
    parameter int unsigned Drain   = 256  // clocks of a run beyond WATCHDOG, a power of two from 128 on
) (
    input  logic                  clk_i,
    input  logic                  rst_ni,
    // from the host
    input  logic                  start_i,
    input  logic                  clear_i,
    input  logic [31:0]           watchdog_i,
    input  logic                  write_i,           // any write
    input  logic                  write_register_i,  // .. of a register of banks A, B, C
    // from and to control: one run
    output logic                  start_o,
    output logic                  scrub_o,           // issue and units are in reset
    output logic                  scrub_control_o,   // .. and control
    output logic                  refetch_o,
    input  logic                  run_start_i,
    input  logic                  busy_i,
    input  logic                  done_i,
    input  logic                  fault_i,
    input  logic [3:0]            cause_i,
    input  logic                  broken_run_i,      // no state of control
    // what a run writes
    input  logic [3:0]            wrote_i,           // output, banks C, B, A
    input  logic [2:0][5:0]       index_i,
    input  logic [2:0][31:0]      result_i,          // the last one is zero if no unit has any
    // parity
    input  logic                  bad_program_i,     // a bundle in P
    input  logic                  bad_constant_i,    // an operand in E1
    input  logic                  valid_e1_i,
    input  logic                  bad_output_i,      // an output that the host reads
    input  logic                  broken_i,          // registers of the host port or outputs
    // the plausibility record
    input  logic                  checking_i,        // the verdict on an output is open
    input  logic                  implausible_i,
    // to fetch and the operand stage
    output asip_pkg::guard_t      guard_o,
    // to outputs and host
    output logic                  commit_o,
    output logic                  busy_o,
    output logic                  done_o,
    output logic                  fault_o,
    output logic [3:0]            cause_o,
    output logic                  repaired_o,        // the last tick took a third run
    output logic [31:0]           cycles_o
);

  typedef enum logic [2:0] {
    StIdle   = 3'd0,
    StLaunch = 3'd1,
    StRun    = 3'd2,
    StScrub  = 3'd3,
    StCopy   = 3'd4,
    StSweep  = 3'd5
  } state_e;
  localparam logic [32:0] Begin = -(33'(Drain));
  localparam int unsigned SweepEnd = Bundles + 8;  // the last words are checked a few clocks later
  localparam int unsigned SweepWidth = $clog2(SweepEnd + 1);
  localparam logic [SweepWidth-1:0] SweepBegin = Begin[SweepWidth-1:0];
  localparam logic [SweepWidth-1:0] SweepLast = SweepBegin + SweepWidth'(SweepEnd);

  // What must not change unseen.
  typedef struct packed {
    state_e state;
    logic [1:0] run;       // 1 to 3, 0 between ticks
    logic       start;     // a start waits
    logic       done;
    logic       fault;
    logic       repaired;
    logic       dirty;     // pages 1 and 2 are not those of page 0
    logic       save;      // page 2 is not
    logic       sweep;     // the memories have not been read since the tick
    logic [3:0] cause;
  } control_t;
  localparam int unsigned ControlWidth = 16;

  control_t now, next;
  logic [ControlWidth-1:0] control_q;
  (* keep *) logic [ControlWidth-1:0] inverse_q;
  logic scrub_q, scrub_control_q;
  logic [32:0] count_q;  // from -Drain on: clocks of the run or of the copy, words of the sweep
  logic [31:0] signature_q, first_signature_q, second_signature_q, cycles_q, mixed;
  logic [4:0] first_end_q, second_end_q, end_now;  // {failed, cause}
  logic begun_q, constant_q, program_q, counts_q;
  logic [5:0] copy_write_q;
  logic [2:0] read_q;  // a word of bank K is on its way
  logic broken, over, late, same_first, same_second, agreed, copied, swept;
  logic bad_sweep, reading, misplaced;

  assign now    = control_q;
  assign misplaced = now.run != 2'd0 ? now.state == StIdle || now.state == StSweep :
                     now.state == StLaunch || now.state == StRun;
  assign broken = control_q != ~inverse_q || misplaced;
  // Below -Drain it is the count of a flipped bit.
  assign late   = count_q[32] ? !(&count_q[31:$clog2(Drain)]) : count_q[31:0] >= watchdog_i;
  assign over   = now.state == StRun &&
                  ((!busy_i && !checking_i) || broken_run_i || late);

  // How a run has ended.
  always_comb begin
    end_now = {1'b1, asip_regmap_pkg::FAULT_CONTROL};
    if (late) end_now = {1'b1, asip_regmap_pkg::FAULT_WATCHDOG};
    else if (broken_run_i) end_now = {1'b1, asip_regmap_pkg::FAULT_CONTROL};
    else if (constant_q) end_now = {1'b1, asip_regmap_pkg::FAULT_MEMORY};
    else if (fault_i && cause_i == asip_regmap_pkg::FAULT_ILLEGAL && program_q)
      end_now = {1'b1, asip_regmap_pkg::FAULT_MEMORY};
    else if (fault_i) end_now = {1'b1, cause_i};
    else if (done_i && implausible_i) end_now = {1'b1, asip_regmap_pkg::FAULT_IMPLAUSIBLE};
    else if (done_i) end_now = {1'b0, asip_regmap_pkg::FAULT_NONE};
  end

  assign same_first  = end_now == first_end_q && signature_q == first_signature_q;
  assign same_second = end_now == second_end_q && signature_q == second_signature_q;
  assign agreed      = (now.run == 2'd2 && same_first) ||
                       (now.run == 2'd3 && (same_first || same_second));
  assign copied      = count_q[6];
  assign swept       = count_q[SweepWidth-1:0] == SweepLast;
  assign bad_sweep   = now.state == StSweep && (bad_program_i || (bad_constant_i && read_q[2]));

  always_comb begin
    next = now;
    if (start_i && !now.fault && now.run == 2'd0) next.start = 1'b1;
    if (write_register_i) next.dirty = 1'b1;
    case (now.state)
      StIdle: begin
        if (now.dirty ? now.start || now.sweep : now.save) next.state = StCopy;
        else if (now.start) begin
          next.state    = StLaunch;
          next.run      = 2'd1;
          next.start    = 1'b0;
          next.done     = 1'b0;
          next.repaired = 1'b0;
        end else if (now.sweep) next.state = StSweep;
      end
      StLaunch: next.state = StRun;
      StRun:
      if (over) begin
        next.state = StScrub;
        next.run   = now.run + 2'd1;
        if (agreed || now.run == 2'd3) begin
          next.run   = 2'd0;
          next.save  = 1'b1;
          next.sweep = 1'b1;
          next.dirty = now.run == 2'd3 || end_now[4];
          next.done  = agreed && !end_now[4];
          next.fault = !next.done;
          next.cause = agreed ? end_now[3:0] : asip_regmap_pkg::FAULT_DISAGREE;
          next.repaired = now.run == 2'd3 && agreed;
        end
      end
      StScrub: begin
        if (now.run == 2'd0) next.state = StIdle;
        else if (now.run == 2'd3) next.state = StCopy;
        else next.state = StLaunch;
      end
      StCopy:
      if (copied) begin
        if (now.run != 2'd0) next.state = StLaunch;
        else begin
          next.state = StIdle;
          // page 1 first
          next.save  = now.dirty;
          next.dirty = 1'b0;
        end
      end
      StSweep: begin
        if (swept) next.sweep = 1'b0;
        if (swept || now.start || now.dirty || clear_i) next.state = StScrub;
        if (bad_sweep) begin
          next.fault = 1'b1;
          next.done  = 1'b0;
          next.cause = asip_regmap_pkg::FAULT_MEMORY;
        end
      end
      default: next.state = StScrub;
    endcase
    if (now.run == 2'd0) begin
      if (clear_i) begin
        next.done  = 1'b0;
        next.fault = 1'b0;
      end
      if (bad_output_i) begin
        next.done  = 1'b0;
        next.fault = 1'b1;
        next.cause = asip_regmap_pkg::FAULT_MEMORY;
      end
      // no start takes a fault away
      if (next.fault) begin
        next.start = 1'b0;
        next.run   = 2'd0;
        if (next.state == StLaunch) next.state = StIdle;
      end
      // a run that nobody started
      if (clear_i || busy_i) next.state = StScrub;
    end
    if (broken || broken_i) begin
      next.state = StScrub;
      next.run   = 2'd0;
      next.start = 1'b0;
      next.done  = 1'b0;
      next.fault = 1'b1;
      next.dirty = 1'b1;
      next.sweep = 1'b1;
      next.cause = asip_regmap_pkg::FAULT_CONTROL;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      control_q       <= '0;
      inverse_q       <= '1;
      scrub_q         <= 1'b0;
      scrub_control_q <= 1'b0;
    end else begin
      control_q       <= next;
      inverse_q       <= ~next;
      scrub_q         <= next.state == StScrub;
      scrub_control_q <= next.state == StScrub && (next.run != 2'd0 || next.fault || busy_i);
    end
  end

  // Signature: a shift register with feedback (x^32 + x^22 + x^2 + x + 1, which is primitive), into which the
  // words go turned by bank.
  function automatic logic [31:0] turned(input logic [31:0] word, input int unsigned by);
    turned = (word << by) | (word >> (32 - by));
  endfunction

  // verilog_format: off - it breaks calls inside their parentheses
  assign mixed = ({32{wrote_i[0]}} & (result_i[0] ^ {26'd0, index_i[0]})) ^
                 ({32{wrote_i[1]}} & turned(result_i[1] ^ {26'd1, index_i[1]}, 11)) ^
                 turned(result_i[2] ^ ({32{wrote_i[2] || wrote_i[3]}} & {25'd2, wrote_i[3], index_i[2]}), 22);
  // verilog_format: on

  always_ff @(posedge clk_i) begin
    if (now.state != StRun) begin
      begun_q     <= 1'b0;
      signature_q <= '1;
      constant_q  <= 1'b0;
      program_q   <= 1'b0;
    end else begin
      begun_q <= begun_q || run_start_i;
      if (begun_q) begin
        signature_q <= {signature_q[30:0], 1'b0} ^ ({32{signature_q[31]}} & 32'h0040_0007) ^ mixed;
      end
      constant_q  <= constant_q || (bad_constant_i && valid_e1_i);
      program_q   <= program_q || bad_program_i;
    end
    if (over && now.run == 2'd1) begin
      first_signature_q <= signature_q;
      first_end_q       <= end_now;
    end
    if (over && now.run == 2'd2) begin
      second_signature_q <= signature_q;
      second_end_q       <= end_now;
    end
    if (now.run == 2'd0) second_signature_q <= '0;
    if (now.state == StRun || now.state == StCopy || reading) count_q <= count_q + 33'd1;
    else if (now.state != StSweep) count_q <= Begin;
    copy_write_q <= count_q[5:0];
    read_q  <= {read_q[1:0], reading};
    // clocks from the first run's beginning to the end of the tick
    counts_q <= now.run != 2'd0 && (counts_q || run_start_i);
    if (now.run == 2'd1 && run_start_i) cycles_q <= 32'd1;
    else if (counts_q && now.run != 2'd0) cycles_q <= cycles_q + 32'd1;
  end

  assign reading             = now.state == StSweep && !write_i;
  assign guard_o.page        = now.run == 2'd2 ? 2'd1 : 2'd0;
  assign guard_o.copy        = now.state == StCopy;
  assign guard_o.copy_from   = now.run == 2'd3 ? 2'd2 : 2'd0;
  assign guard_o.copy_to     = now.run == 2'd3 ? 2'd0 : now.dirty ? 2'd1 : 2'd2;
  assign guard_o.copy_store  = now.state == StCopy && count_q[6:0] != 7'd0;
  assign guard_o.copy_read   = count_q[5:0];
  assign guard_o.copy_write  = copy_write_q;
  assign guard_o.sweep       = now.state == StSweep;
  assign guard_o.sweep_first = now.state == StSweep && count_q[SweepWidth-1:0] == SweepBegin;
  assign guard_o.sweep_step  = reading;
  assign guard_o.sweep_index = count_q[6:0];

  assign start_o    = now.state == StLaunch;
  assign scrub_o    = scrub_q;
  assign scrub_control_o = scrub_control_q;
  assign refetch_o  = now.state == StScrub;
  assign commit_o   = over && agreed && !end_now[4] && !broken && !broken_i;
  assign busy_o     = now.run != 2'd0 || now.start || broken;  // a fault follows
  assign done_o     = now.done;
  assign fault_o    = now.fault;
  assign cause_o    = now.fault ? now.cause : asip_regmap_pkg::FAULT_NONE;
  assign repaired_o = now.repaired;
  assign cycles_o   = cycles_q;

endmodule
