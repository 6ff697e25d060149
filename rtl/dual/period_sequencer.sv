// SPDX-License-Identifier: Apache-2.0
// period_sequencer: starts both cores once per period and copies words between them by lists.
// Contract: core 0 makes set-points, core 1 tracks; irq_i[n] is high from the end of core n's run to its next
// start. Bus requests are Avalon-MM, held until bus_wait_i is low. A core still at work at the start
// of a period is not started in it. A fault of core 0 keeps core 0 from being started, one of core 1 both;
// its safe commands are put out. clear_i is taken between periods. Lists: see docs/dual_regmap.md.
module period_sequencer (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        start_i,            // first clock of a period
    input  logic        clear_i,
    input  logic [1:0]  irq_i,
    // lists: {destination, source} of 14 bits each
    input  logic        list_write_i,
    input  logic [6:0]  list_address_i,
    input  logic [27:0] list_data_i,
    input  logic [5:0]  set_points_i,       // entries of each list
    input  logic [5:0]  inputs_i,
    input  logic [5:0]  commands_i,
    // bus of both cores
    output logic        bus_core_o,
    output logic        bus_read_o,
    output logic        bus_write_o,
    output logic [13:0] bus_address_o,
    output logic [31:0] bus_data_o,
    input  logic [31:0] bus_data_i,
    input  logic        bus_wait_i,
    // buffer
    output logic        swap_o,
    output logic        store_o,            // word of a set-point
    output logic        complete_o,
    output logic [4:0]  source_o,           // word of an input
    output logic        source_measured_o,  // measured, else from the buffer
    input  logic [31:0] source_data_i,      // a clock later
    input  logic        valid_i,
    // commands
    output logic        command_o,          // word of a command
    output logic        commit_o,           // all words are there
    output logic [4:0]  index_o,            // of the set-point or command
    output logic [31:0] data_o,
    // events and state
    output logic [1:0]  cycles_o,           // data_o holds CYCLES of core n
    output logic [1:0]  fault_o,
    output logic [1:0]  overrun_o,          // pulse: core n at work when a period starts
    output logic        late_o,             // pulse: any work is under way when a period starts
    output logic        finished_o,         // pulse: all work of the period is done
    output logic        cleared_o,          // pulse
    output logic        waiting_o,          // a period has begun, its work not yet
    output logic        copying_o,          // the bus is in use
    output logic        active_o
);

  typedef enum logic [3:0] {
    StIdle       = 4'd0,
    StBegin      = 4'd1,  // buffer is swapped
    StTrajectory = 4'd2,  // core 0 is started
    StFetch      = 4'd3,  // entry of a list
    StSource     = 4'd4,  // word of an input
    StTransfer   = 4'd5,
    StTracking   = 4'd6,  // core 1 is started
    StWait       = 4'd7,  // for a core
    StStatus     = 4'd8,
    StCycles     = 4'd9,
    StClear      = 4'd10  // both cores in turn
  } state_e;

  localparam logic [1:0] LiSetPoints = 2'd0;
  localparam logic [1:0] LiInputs = 2'd1;
  localparam logic [1:0] LiCommands = 2'd2;

  localparam logic [13:0] CsrControl = 14'(asip_regmap_pkg::BASE_CSR) + 14'(asip_regmap_pkg::REG_CONTROL);
  localparam logic [13:0] CsrStatus = 14'(asip_regmap_pkg::BASE_CSR) + 14'(asip_regmap_pkg::REG_STATUS);
  localparam logic [13:0] CsrCycles = 14'(asip_regmap_pkg::BASE_CSR) + 14'(asip_regmap_pkg::REG_CYCLES);
  localparam logic [31:0] CLEAR = 32'd1 << asip_regmap_pkg::CONTROL_CLEAR_LSB;
  localparam logic [31:0] START = CLEAR | 32'd1 << asip_regmap_pkg::CONTROL_START_LSB;

  logic [27:0] lists[0:127];
  logic [27:0] entry_q;
  logic [13:0] source, destination;
  state_e state_q, state_d;
  logic [1:0] list_q, work_q, fault_q;
  logic [5:0] index_q, length;
  logic core_q, faulted_q, pending_q, clear_q;
  logic start_allowed, track_allowed, list_end, accepted, transferred, ended;

  always_ff @(posedge clk_i) begin
    if (list_write_i) lists[list_address_i] <= list_data_i;
    entry_q <= lists[{list_q, index_q[4:0]}];
  end

  assign {destination, source} = entry_q;

  always_comb begin
    case (list_q)
      LiSetPoints: length = set_points_i;
      LiInputs: length = inputs_i;
      default: length = commands_i;
    endcase
  end

  assign start_allowed = !work_q[0] && fault_q == 2'd0;
  assign track_allowed = !work_q[1] && !fault_q[1] && valid_i;
  assign list_end      = index_q >= length || index_q[5];
  assign accepted      = (bus_read_o || bus_write_o) && !bus_wait_i;
  assign transferred   = state_q == StTransfer && accepted;
  assign ended         = state_q == StFetch && list_end;

  always_comb begin
    state_d = state_q;
    case (state_q)
      StIdle:
      if (start_i || pending_q) state_d = StBegin;
      else if (clear_q) state_d = StClear;
      StBegin: state_d = StTrajectory;
      StTrajectory:
      if (accepted || !start_allowed) state_d = track_allowed ? StFetch : StWait;
      StFetch:
      if (!list_end) state_d = (list_q == LiInputs) ? StSource : StTransfer;
      else state_d = (list_q == LiInputs) ? StTracking : StWait;
      StSource: state_d = StTransfer;
      StTransfer: if (accepted) state_d = StFetch;
      StTracking: if (accepted) state_d = StWait;
      StWait:
      if (|(work_q & irq_i)) state_d = StStatus;
      else if (pending_q) state_d = StBegin;
      else if (work_q == 2'd0) state_d = StIdle;
      StStatus: if (accepted) state_d = StCycles;
      StCycles: if (accepted) state_d = (faulted_q && !core_q) ? StWait : StFetch;
      default: if (accepted && core_q) state_d = StIdle;  // StClear
    endcase
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q   <= StIdle;
      list_q    <= LiSetPoints;
      index_q   <= 6'd0;
      work_q    <= 2'd0;
      fault_q   <= 2'd0;
      core_q    <= 1'b0;
      faulted_q <= 1'b0;
      pending_q <= 1'b0;
      clear_q   <= 1'b0;
    end else begin
      state_q   <= state_d;
      pending_q <= (pending_q || start_i) && state_d != StBegin;
      clear_q   <= (clear_q || clear_i) && !cleared_o;
      if (state_q == StFetch && list_end) index_q <= 6'd0;
      else if (transferred) index_q <= index_q + 6'd1;
      case (state_q)
        StIdle: core_q <= 1'b0;
        StTrajectory: begin
          if (accepted) work_q[0] <= 1'b1;
          list_q <= LiInputs;
        end
        StTracking: if (accepted) work_q[1] <= 1'b1;
        StWait: begin  // the commands first
          core_q <= work_q[1] && irq_i[1];
          list_q <= (work_q[1] && irq_i[1]) ? LiCommands : LiSetPoints;
        end
        StStatus:
        if (accepted) faulted_q <= bus_data_i[asip_regmap_pkg::STATUS_FAULT_LSB];
        StCycles:
        if (accepted && faulted_q) begin
          fault_q[core_q] <= 1'b1;
          if (!core_q) work_q[0] <= 1'b0;
        end
        StClear: begin
          if (accepted) core_q <= 1'b1;
          if (cleared_o) fault_q <= 2'd0;
        end
        default: ;
      endcase
      if (ended && list_q == LiSetPoints) work_q[0] <= 1'b0;
      if (ended && list_q == LiCommands) work_q[1] <= 1'b0;
    end
  end

  always_comb begin
    bus_core_o    = core_q;
    bus_read_o    = 1'b0;
    bus_write_o   = 1'b0;
    bus_address_o = CsrControl;
    bus_data_o    = START;
    case (state_q)
      StTrajectory: begin
        bus_core_o  = 1'b0;
        bus_write_o = start_allowed;
      end
      StTransfer:
      if (list_q == LiInputs) begin
        bus_core_o    = 1'b1;
        bus_write_o   = 1'b1;
        bus_address_o = destination;
        bus_data_o    = source_data_i;
      end else begin
        bus_read_o    = 1'b1;
        bus_address_o = source;
      end
      StTracking: begin
        bus_core_o  = 1'b1;
        bus_write_o = 1'b1;
      end
      StStatus: begin
        bus_read_o    = 1'b1;
        bus_address_o = CsrStatus;
      end
      StCycles: begin
        bus_read_o    = 1'b1;
        bus_address_o = CsrCycles;
      end
      StClear: begin
        bus_write_o = 1'b1;
        bus_data_o  = CLEAR;
      end
      default: ;
    endcase
  end

  assign swap_o            = state_q == StBegin;
  assign store_o           = transferred && list_q == LiSetPoints;
  assign command_o         = transferred && list_q == LiCommands;
  assign complete_o        = ended && list_q == LiSetPoints;
  assign commit_o          = ended && list_q == LiCommands;
  assign source_o          = source[4:0];
  assign source_measured_o = source[5];
  assign index_o           = destination[4:0];
  assign data_o            = bus_data_i;
  assign cycles_o[0]       = state_q == StCycles && accepted && !core_q;
  assign cycles_o[1]       = state_q == StCycles && accepted && core_q;
  assign fault_o           = fault_q;
  assign overrun_o         = start_i ? work_q : 2'd0;
  assign late_o            = start_i && state_q != StIdle;
  assign finished_o        = state_q == StWait && state_d == StIdle;
  assign cleared_o         = state_q == StClear && accepted && core_q;
  assign waiting_o         = pending_q || start_i;
  assign copying_o         = state_q != StIdle && state_q != StWait && state_q != StBegin;
  assign active_o          = state_q != StIdle || pending_q || clear_q;

endmodule
