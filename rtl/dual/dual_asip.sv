// SPDX-License-Identifier: Apache-2.0
// dual_asip: two processors in parallel, one for set-points, one for the tracking law.
// Contract: one clock, asynchronous active-low reset. Every period the tracking core gets the set-point that
// the trajectory core made in the period before, and measured_i as it is in the period's first clock. The
// commands change together, in the clock of command_valid_o. See docs/two_processors.md.
module dual_asip #(
    parameter int unsigned TrajectoryFmaPipes = 2,
    parameter int unsigned TrajectorySlots    = 3,
    parameter int unsigned TrackingFmaPipes   = 2,
    parameter int unsigned TrackingSlots      = 3,
    parameter int unsigned Words              = 15,  // of a set-point, 2..32
    parameter int unsigned Measured           = 5,   // 1..32
    parameter int unsigned Commands           = 5    // 1..32
) (
    input  logic                   clk_i,
    input  logic                   rst_ni,
    // Avalon-MM agent
    input  logic [dual_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic                   read_i,
    input  logic                   write_i,
    input  logic [31:0]            writedata_i,
    output logic [31:0]            readdata_o,
    output logic                   waitrequest_o,
    output logic                   irq_o,
    // to and from the machine
    input  logic [32*Measured-1:0] measured_i,
    output logic [32*Commands-1:0] command_o,
    output logic                   command_valid_o,  // pulse: new commands
    output logic                   period_o,         // first clock of a period
    output logic                   finished_o,       // pulse: all work of a period is done
    output logic                   stop_o,           // a core has faulted
    // trace: words of set-points on their way into the buffer, cycles of core n's run; open in hardware
    output logic                   trace_store_o,
    output logic [1:0]             trace_cycles_o,
    output logic [4:0]             trace_index_o,
    output logic [31:0]            trace_data_o
);

  // ---- host
  logic [1:0] host_read, host_write, host_wait;
  logic run, clear, cleared, list_write;
  logic [15:0] period, elapsed, clocks;
  logic [5:0] set_points, inputs, commands;
  logic [31:0] zero_on_hold;
  // ---- sequencer and buffer
  logic start, seq_core, seq_read, seq_write, seq_wait, active, valid, hold, underrun, late;
  logic swap, store, complete, source_measured, command, copying, waiting;
  logic source_measured_q;
  logic [13:0] seq_address;
  logic [4:0] source, index;
  logic [31:0] seq_data, seq_readdata, data, buffer_data, measured_q;
  logic [1:0] core_cycles, core_fault, overrun;
  logic [32*Measured-1:0] latched_q, taken_q;
  logic [32*Commands-1:0] gathered_q;
  // ---- statistics
  logic [31:0] periods, overruns, left_min;
  logic [63:0] core_last, core_min, core_max;
  logic [15:0] command_last, command_max, copy_last, copy_max, used_last, used_max;
  // ---- cores
  logic [1:0] core_read, core_write, core_wait, core_seq_wait, core_irq;
  logic [27:0] core_address;
  logic [63:0] core_writedata, core_data;

  dual_host #(
      .Words   (Words),
      .Measured(Measured),
      .Commands(Commands)
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
      .core_read_o   (host_read),
      .core_write_o  (host_write),
      .core_wait_i   (host_wait),
      .core_data_i   (core_data),
      .run_o         (run),
      .clear_o       (clear),
      .period_o      (period),
      .list_write_o  (list_write),
      .set_points_o  (set_points),
      .inputs_o      (inputs),
      .commands_o    (commands),
      .zero_on_hold_o(zero_on_hold),
      .cleared_i     (cleared),
      .active_i      (active),
      .valid_i       (valid),
      .hold_i        (hold),
      .underrun_i    (underrun),
      .overrun_i     (overrun),
      .fault_i       (core_fault),
      .periods_i     (periods),
      .overruns_i    (overruns),
      .core_last_i   (core_last),
      .core_min_i    (core_min),
      .core_max_i    (core_max),
      .command_last_i(command_last),
      .command_max_i (command_max),
      .copy_last_i   (copy_last),
      .copy_max_i    (copy_max),
      .used_last_i   (used_last),
      .used_max_i    (used_max),
      .left_min_i    (left_min)
  );

  period_timer u_timer (
      .clk_i,
      .rst_ni,
      .run_i    (run),
      .clocks_i (period),
      .start_o  (start),
      .elapsed_o(elapsed),
      .clocks_o (clocks)
  );

  period_sequencer u_sequencer (
      .clk_i,
      .rst_ni,
      .start_i          (start),
      .clear_i          (clear),
      .irq_i            (core_irq),
      .list_write_i     (list_write),
      .list_address_i   (address_i[$clog2(dual_regmap_pkg::WORDS_LISTS)-1:0]),
      .list_data_i      ({writedata_i[dual_regmap_pkg::LISTS_DESTINATION_LSB+:14],
                          writedata_i[dual_regmap_pkg::LISTS_SOURCE_LSB+:14]}),
      .set_points_i     (set_points),
      .inputs_i         (inputs),
      .commands_i       (commands),
      .bus_core_o       (seq_core),
      .bus_read_o       (seq_read),
      .bus_write_o      (seq_write),
      .bus_address_o    (seq_address),
      .bus_data_o       (seq_data),
      .bus_data_i       (seq_readdata),
      .bus_wait_i       (seq_wait),
      .swap_o           (swap),
      .store_o          (store),
      .complete_o       (complete),
      .source_o         (source),
      .source_measured_o(source_measured),
      .source_data_i    (source_measured_q ? measured_q : buffer_data),
      .valid_i          (valid),
      .command_o        (command),
      .commit_o         (command_valid_o),
      .index_o          (index),
      .data_o           (data),
      .cycles_o         (core_cycles),
      .fault_o          (core_fault),
      .overrun_o        (overrun),
      .late_o           (late),
      .finished_o       (finished_o),
      .cleared_o        (cleared),
      .waiting_o        (waiting),
      .copying_o        (copying),
      .active_o         (active)
  );

  set_point_buffer #(
      .Words(Words)
  ) u_buffer (
      .clk_i,
      .rst_ni,
      .clear_i       (cleared),
      .swap_i        (swap),
      .write_i       (store),
      .write_index_i (index),
      .write_data_i  (data),
      .complete_i    (complete),
      .zero_on_hold_i(zero_on_hold),
      .read_index_i  (source),
      .read_data_o   (buffer_data),
      .valid_o       (valid),
      .hold_o        (hold),
      .underrun_o    (underrun)
  );

  period_statistics u_statistics (
      .clk_i,
      .rst_ni,
      .clear_i       (cleared),
      .waiting_i     (waiting),
      .cycles_i      (core_cycles),
      .data_i        (data),
      .start_i       (start),
      .late_i        (late),
      .commit_i      (command_valid_o),
      .finished_i    (finished_o),
      .copying_i     (copying),
      .elapsed_i     (elapsed),
      .clocks_i      (clocks),
      .periods_o     (periods),
      .overruns_o    (overruns),
      .core_last_o   (core_last),
      .core_min_o    (core_min),
      .core_max_o    (core_max),
      .command_last_o(command_last),
      .command_max_o (command_max),
      .copy_last_o   (copy_last),
      .copy_max_o    (copy_max),
      .used_last_o   (used_last),
      .used_max_o    (used_max),
      .left_min_o    (left_min)
  );

  // Measured words are taken at one instant, never while they are copied; commands are put out at one.
  always_ff @(posedge clk_i) begin
    if (start) latched_q <= measured_i;
    if (swap) taken_q <= latched_q;
    measured_q        <= 32'd0;
    source_measured_q <= source_measured;
    for (int unsigned i = 0; i < Measured; i++) if (source == 5'(i)) measured_q <= taken_q[32*i+:32];
    for (int unsigned i = 0; i < Commands; i++) if (command && index == 5'(i)) gathered_q[32*i+:32] <= data;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) command_o <= '0;
    else if (command_valid_o) command_o <= gathered_q;
  end

  // ---- cores
  genvar n;
  generate
    for (n = 0; n < 2; n++) begin : gen_bus
      core_bus u_bus (
          .clk_i,
          .rst_ni,
          .host_read_i        (host_read[n]),
          .host_write_i       (host_write[n]),
          .host_address_i     (address_i[asip_regmap_pkg::ADDRESS_WIDTH-1:0]),
          .host_data_i        (writedata_i),
          .host_wait_o        (host_wait[n]),
          .sequencer_read_i   (seq_read && seq_core == 1'(n)),
          .sequencer_write_i  (seq_write && seq_core == 1'(n)),
          .sequencer_address_i(seq_address),
          .sequencer_data_i   (seq_data),
          .sequencer_wait_o   (core_seq_wait[n]),
          .read_o             (core_read[n]),
          .write_o            (core_write[n]),
          .address_o          (core_address[14*n+:14]),
          .data_o             (core_writedata[32*n+:32]),
          .wait_i             (core_wait[n])
      );
    end
  endgenerate

  assign seq_wait     = core_seq_wait[seq_core];
  assign seq_readdata = core_data[32*seq_core+:32];

  generate
    for (n = 0; n < 2; n++) begin : gen_core
      logic trace_issue;
      logic [15:0] trace_pc;
      logic [3:0] trace_write;
      logic [17:0] trace_index;
      logic [95:0] trace_data;
      asip_pkg::hook_out_t hook;
      logic unused_trace;

      asip #(
          .FmaPipes(n == 0 ? TrajectoryFmaPipes : TrackingFmaPipes),
          .Slots   (n == 0 ? TrajectorySlots : TrackingSlots)
      ) u_asip (
          .clk_i,
          .rst_ni,
          .address_i    (core_address[14*n+:14]),
          .read_i       (core_read[n]),
          .write_i      (core_write[n]),
          .writedata_i  (core_writedata[32*n+:32]),
          .readdata_o   (core_data[32*n+:32]),
          .waitrequest_o(core_wait[n]),
          .irq_o        (core_irq[n]),
          .trace_issue_o(trace_issue),
          .trace_pc_o   (trace_pc),
          .trace_write_o(trace_write),
          .trace_index_o(trace_index),
          .trace_data_o (trace_data),
          .hook_i       ('0),
          .hook_o       (hook)
      );
      assign unused_trace = ^{trace_issue, trace_pc, trace_write, trace_index, trace_data, hook};
    end
  endgenerate

  assign period_o = start;
  assign stop_o   = core_fault != 2'd0;

  assign trace_store_o  = store;
  assign trace_cycles_o = core_cycles;
  assign trace_index_o  = index;
  assign trace_data_o   = data;

endmodule
