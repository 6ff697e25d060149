// SPDX-License-Identifier: Apache-2.0
// debug_asip: the ASIP with a debug block: run control, live parameters, scope, serial port.
// Contract: words 0x0000 to 0x3fff of the bus are those of the core (docs/regmap.md), the block's registers
// follow (docs/debug_regmap.md). A run that is not held takes the cycles and gives the bits of `asip`.
// The serial port and the host take turns on the bus, word by word. docs/debug_block.md. Words 0x6000 to
// 0x7fff of the serial port alone are registers of the machine, outside.
module debug_asip #(
    parameter int unsigned FmaPipes  = 2,
    parameter int unsigned Slots     = 3,
    parameter int unsigned Bundles   = asip_isa_pkg::PROGRAM_BUNDLES,
    parameter int unsigned DataWords = asip_isa_pkg::DATA_WORDS,
    parameter int unsigned StreamWords = 0,  // as of `asip`
    parameter int unsigned Loops       = 0,
    parameter int unsigned Lanes       = 0,
    parameter int unsigned Uart      = 1,  // 0: no serial port
    parameter int unsigned UartDivider =   // clocks a bit after reset
        32'(debug_regmap_pkg::RESET_UART[debug_regmap_pkg::UART_DIVIDER_LSB+:16])
) (
    input  logic                                    clk_i,
    input  logic                                    rst_ni,
    // Avalon-MM agent
    input  logic [asip_regmap_pkg::ADDRESS_WIDTH:0] address_i,
    input  logic                                    read_i,
    input  logic                                    write_i,
    input  logic [31:0]                             writedata_i,
    output logic [31:0]                             readdata_o,
    output logic                                    waitrequest_o,
    output logic                                    irq_o,
    // serial line
    input  logic                                    rx_i,
    output logic                                    tx_o,
    // registers of the machine for the serial port, Avalon-MM host
    output logic [12:0]                             machine_address_o,
    output logic                                    machine_read_o,
    output logic                                    machine_write_o,
    output logic [31:0]                             machine_writedata_o,
    input  logic [31:0]                             machine_readdata_i,
    input  logic                                    machine_waitrequest_i,
    // to the power stage: the core is held
    output logic                                    debug_active_o,
    // trace, as of `asip`
    output logic                                    trace_issue_o,
    output logic [15:0]                             trace_pc_o,
    output logic [3:0]                              trace_write_o,
    output logic [2:0][5:0]                         trace_index_o,
    output logic [2:0][31:0]                        trace_data_o
);

  localparam int unsigned Width = asip_regmap_pkg::ADDRESS_WIDTH;
  localparam int unsigned BlockWidth = debug_regmap_pkg::ADDRESS_WIDTH;
  localparam int unsigned RingLog2 = $clog2(debug_regmap_pkg::WORDS_RING);
  localparam int unsigned StageLog2 = 6;

  // ---- bus
  logic link_read, link_write, link_wait, link_in_block, host_in_block;
  logic link_in_machine;
  logic [Width:0] link_address;
  logic [31:0] link_data;
  logic host_wait_core, host_wait_block, link_wait_core, link_wait_block;
  logic either_read, either_write, either_wait, stage_wait;
  logic [Width-1:0] either_address, stage_address, core_address;
  logic [31:0] either_data, stage_data, core_writedata, core_readdata;
  logic stage_bus_write, core_read, core_write, core_wait;
  logic turn_read, turn_write, turn_wait;
  logic [Width-1:0] turn_address;
  logic [31:0] turn_data, turn_readdata;
  logic block_read, block_write, block_wait;
  logic [Width-1:0] block_address;
  logic [31:0] block_writedata, block_readdata;
  logic chosen_read, chosen_write, chosen_wait;
  logic [Width-1:0] chosen_address;
  logic [31:0] chosen_data, chosen_readdata;
  logic in_constants;
  // ---- core
  asip_pkg::hook_in_t hook_in;
  asip_pkg::hook_out_t hook;
  logic stop_q, stop_d, freeze, stop_run, wait_k;
  // ---- block
  logic csr_write, stage_write, ring_read;
  logic [5:0] csr_index;
  logic watchdog_runs, stop_at_start;
  logic [3:0] breakpoints;
  logic [1:0] watches;
  logic held, halted, committing, overflow, black_box, triggered, armed;
  logic [2:0] reason, which, channel, last_channel;
  logic [15:0] next, last, version, run_version;
  logic [7:0] staged;
  logic [1:0] scope_state, size_log2;
  logic [31:0] status_word, place_word, mode_word, enable_word, version_word;
  logic [31:0] runs, records, triggered_at, uart_errors;
  logic [31:0] channel_word, ring_data;
  logic [RingLog2-1:0] link_ring_address;

  // ================================================================ bus
  assign host_in_block = address_i[Width];
  assign link_in_machine = &link_address[Width:BlockWidth];
  assign link_in_block = link_address[Width] && !link_in_machine;
  assign waitrequest_o = host_in_block ? host_wait_block : host_wait_core;
  assign readdata_o    = host_in_block ? chosen_readdata : turn_readdata;
  assign link_wait     = link_in_machine ? machine_waitrequest_i
                         : link_in_block ? link_wait_block : link_wait_core;

  assign machine_address_o   = link_address[BlockWidth-1:0];
  assign machine_read_o      = link_read && link_in_machine;
  assign machine_write_o     = link_write && link_in_machine;
  assign machine_writedata_o = link_data;

  core_bus u_core_turn (
      .clk_i,
      .rst_ni,
      .host_read_i        (read_i && !host_in_block),
      .host_write_i       (write_i && !host_in_block),
      .host_address_i     (address_i[Width-1:0]),
      .host_data_i        (writedata_i),
      .host_wait_o        (host_wait_core),
      .sequencer_read_i   (link_read && !link_address[Width]),
      .sequencer_write_i  (link_write && !link_address[Width]),
      .sequencer_address_i(link_address[Width-1:0]),
      .sequencer_data_i   (link_data),
      .sequencer_wait_o   (link_wait_core),
      .read_o             (either_read),
      .write_o            (either_write),
      .address_o          (either_address),
      .data_o             (either_data),
      .wait_i             (either_wait)
  );

  // A commit goes first: nothing comes between its writes.
  core_bus u_stage_turn (
      .clk_i,
      .rst_ni,
      .host_read_i        (either_read),
      .host_write_i       (either_write),
      .host_address_i     (either_address),
      .host_data_i        (either_data),
      .host_wait_o        (either_wait),
      .sequencer_read_i   (1'b0),
      .sequencer_write_i  (stage_bus_write),
      .sequencer_address_i(stage_address),
      .sequencer_data_i   (stage_data),
      .sequencer_wait_o   (stage_wait),
      .read_o             (turn_read),
      .write_o            (turn_write),
      .address_o          (turn_address),
      .data_o             (turn_data),
      .wait_i             (turn_wait)
  );

  debug_bus_slice u_core_slice (
      .clk_i,
      .rst_ni,
      .read_i          (turn_read),
      .write_i         (turn_write),
      .address_i       (turn_address),
      .writedata_i     (turn_data),
      .readdata_o      (turn_readdata),
      .waitrequest_o   (turn_wait),
      .far_read_o       (core_read),
      .far_write_o      (core_write),
      .far_address_o    (core_address),
      .far_writedata_o  (core_writedata),
      .far_readdata_i   (core_readdata),
      .far_wait_i       (core_wait)
  );

  core_bus u_block_turn (
      .clk_i,
      .rst_ni,
      .host_read_i        (read_i && host_in_block),
      .host_write_i       (write_i && host_in_block),
      .host_address_i     (address_i[Width-1:0]),
      .host_data_i        (writedata_i),
      .host_wait_o        (host_wait_block),
      .sequencer_read_i   (link_read && link_in_block),
      .sequencer_write_i  (link_write && link_in_block),
      .sequencer_address_i(link_address[Width-1:0]),
      .sequencer_data_i   (link_data),
      .sequencer_wait_o   (link_wait_block),
      .read_o             (chosen_read),
      .write_o            (chosen_write),
      .address_o          (chosen_address),
      .data_o             (chosen_data),
      .wait_i             (chosen_wait)
  );

  debug_bus_slice u_block_slice (
      .clk_i,
      .rst_ni,
      .read_i          (chosen_read),
      .write_i         (chosen_write),
      .address_i       (chosen_address),
      .writedata_i     (chosen_data),
      .readdata_o      (chosen_readdata),
      .waitrequest_o   (chosen_wait),
      .far_read_o       (block_read),
      .far_write_o      (block_write),
      .far_address_o    (block_address),
      .far_writedata_o  (block_writedata),
      .far_readdata_i   (block_readdata),
      .far_wait_i       (block_wait)
  );

  // ================================================================ core
  always_comb begin
    hook_in        = '0;
    hook_in.stop_q = stop_q;
    hook_in.stop_d = stop_d;
    hook_in.freeze = freeze;
    hook_in.open   = halted;
    hook_in.wait_k = wait_k;
    hook_in.stop_run = stop_run;
    hook_in.pc     = next;
  end

  asip #(
      .FmaPipes (FmaPipes),
      .Slots    (Slots),
      .Bundles  (Bundles),
      .DataWords(DataWords),
      .StreamWords(StreamWords),
      .Loops     (Loops),
      .Lanes     (Lanes),
      .Debug    (1)
  ) u_asip (
      .clk_i,
      .rst_ni,
      .address_i    (core_address),
      .read_i       (core_read),
      .write_i      (core_write),
      .writedata_i  (core_writedata),
      .readdata_o   (core_readdata),
      .waitrequest_o(core_wait),
      .irq_o,
      .trace_issue_o,
      .trace_pc_o,
      .trace_write_o,
      .trace_index_o,
      .trace_data_o,
      .hook_i       (hook_in),
      .hook_o       (hook)
  );

  // ================================================================ block
  debug_run u_run (
      .clk_i,
      .rst_ni,
      .csr_write_i  (csr_write),
      .csr_index_i  (csr_index),
      .csr_data_i   (block_writedata),
      .host_write_i (core_write && !core_wait),
      .core_i       (hook),
      .issue_i      (trace_issue_o),
      .pc_d_i       (trace_pc_o),
      .write_i      (trace_write_o),
      .write_index_i(trace_index_o),
      .write_data_i (trace_data_o),
      .stop_q_o     (stop_q),
      .stop_d_o     (stop_d),
      .freeze_o     (freeze),
      .abort_o      (stop_run),
      .watchdog_runs_o(watchdog_runs),
      .stop_at_start_o(stop_at_start),
      .breakpoints_o(breakpoints),
      .watches_o    (watches),
      .held_o       (held),
      .halted_o     (halted),
      .reason_o     (reason),
      .which_o      (which),
      .next_o       (next),
      .last_o       (last)
  );

  debug_stage #(
      .WordsLog2(StageLog2)
  ) u_stage (
      .clk_i,
      .rst_ni,
      .csr_write_i  (csr_write),
      .csr_index_i  (csr_index),
      .csr_data_i   (block_writedata),
      .stage_write_i(stage_write),
      .stage_index_i(block_address[$clog2(debug_regmap_pkg::WORDS_STAGE)-1:0]),
      .stage_data_i (block_writedata),
      .core_busy_i  (hook.busy),
      .run_start_i  (hook.run_start),
      .write_o      (stage_bus_write),
      .address_o    (stage_address),
      .data_o       (stage_data),
      .wait_i       (stage_wait),
      .count_o      (staged),
      .committing_o (committing),
      .overflow_o   (overflow),
      .version_o    (version),
      .run_version_o(run_version)
  );

  assign in_constants = 32'(core_address) / asip_regmap_pkg::WORDS_CONSTANTS ==
                        asip_regmap_pkg::BASE_CONSTANTS / asip_regmap_pkg::WORDS_CONSTANTS;

  debug_capture u_capture (
      .clk_i,
      .rst_ni,
      .csr_write_i     (csr_write),
      .csr_index_i     (csr_index),
      .csr_data_i      (block_writedata),
      .run_start_i     (hook.run_start),
      .ended_i         (hook.ended),
      .cycles_i        (hook.cycles),
      .write_i         (trace_write_o),
      .write_index_i   (trace_index_o),
      .write_data_i    (trace_data_o),
      .constant_write_i(core_write && !core_wait && in_constants),
      .constant_index_i(core_address[$clog2(asip_regmap_pkg::WORDS_CONSTANTS)-1:0]),
      .constant_data_i (core_writedata),
      .channel_o       (channel),
      .word_o          (channel_word)
  );

  debug_scope #(
      .RingLog2(RingLog2)
  ) u_scope (
      .clk_i,
      .rst_ni,
      .csr_write_i   (csr_write),
      .csr_index_i   (csr_index),
      .csr_data_i    (block_writedata),
      .ended_i       (hook.ended),
      .fault_i       (hook.fault),
      .wait_k_o      (wait_k),
      .channel_i     (channel),
      .word_i        (channel_word),
      .ring_address_i(ring_read ? block_address[RingLog2-1:0] : link_ring_address),
      .ring_data_o   (ring_data),
      .state_o       (scope_state),
      .black_box_o   (black_box),
      .triggered_o   (triggered),
      .records_o     (records),
      .triggered_at_o(triggered_at),
      .last_channel_o(last_channel),
      .size_log2_o   (size_log2),
      .armed_o       (armed)
  );

  always_comb begin
    status_word = 32'd0;
    status_word[debug_regmap_pkg::STATUS_HELD_LSB]       = held;
    status_word[debug_regmap_pkg::STATUS_HALTED_LSB]     = halted;
    status_word[debug_regmap_pkg::STATUS_RUNNING_LSB]    = hook.busy;
    status_word[debug_regmap_pkg::STATUS_EMPTY_LSB]      = hook.quiet;
    status_word[debug_regmap_pkg::STATUS_FAULT_LSB]      = hook.fault;
    status_word[debug_regmap_pkg::STATUS_STAGED_LSB]     = |staged;
    status_word[debug_regmap_pkg::STATUS_COMMITTING_LSB] = committing;
    status_word[debug_regmap_pkg::STATUS_OVERFLOW_LSB]   = overflow;
    status_word[debug_regmap_pkg::STATUS_REASON_LSB+:3]  = reason;
    status_word[debug_regmap_pkg::STATUS_WHICH_LSB+:3]   = which;
    status_word[debug_regmap_pkg::STATUS_SCOPE_LSB+:2]   = scope_state;
    status_word[debug_regmap_pkg::STATUS_BLACK_BOX_LSB]  = black_box;
    status_word[debug_regmap_pkg::STATUS_TRIGGERED_LSB]  = triggered;

    place_word = 32'd0;
    place_word[debug_regmap_pkg::PLACE_NEXT_LSB+:16] = next;
    place_word[debug_regmap_pkg::PLACE_LAST_LSB+:16] = last;

    mode_word = 32'd0;
    mode_word[debug_regmap_pkg::MODE_WATCHDOG_RUNS_LSB] = watchdog_runs;
    mode_word[debug_regmap_pkg::MODE_STOP_AT_START_LSB] = stop_at_start;

    enable_word = 32'd0;
    enable_word[debug_regmap_pkg::ENABLE_BREAKPOINTS_LSB+:4] = breakpoints;
    enable_word[debug_regmap_pkg::ENABLE_WATCHES_LSB+:2]     = watches;

    version_word = 32'd0;
    version_word[debug_regmap_pkg::VERSION_PAGE_LSB+:16] = version;
    version_word[debug_regmap_pkg::VERSION_RUN_LSB+:16]  = run_version;
  end

  debug_registers #(
      .StageLog2(StageLog2),
      .RingLog2 (RingLog2),
      .Uart     (Uart),
      .ResetUart(32'(UartDivider) << debug_regmap_pkg::UART_DIVIDER_LSB)
  ) u_registers (
      .clk_i,
      .rst_ni,
      .address_i     (block_address[BlockWidth-1:0]),
      .read_i        (block_read),
      .write_i       (block_write),
      .writedata_i   (block_writedata),
      .readdata_o    (block_readdata),
      .waitrequest_o (block_wait),
      .csr_write_o   (csr_write),
      .csr_index_o   (csr_index),
      .stage_write_o (stage_write),
      .ring_read_o   (ring_read),
      .ring_data_i   (ring_data),
      .ended_i       (hook.ended),
      .status_i      (status_word),
      .place_i       (place_word),
      .mode_i        (mode_word),
      .enable_i      (enable_word),
      .staged_i      (staged),
      .version_i     (version_word),
      .records_i     (records),
      .triggered_at_i(triggered_at),
      .uart_errors_i (uart_errors),
      .runs_o        (runs)
  );

  generate
    if (Uart != 0) begin : gen_uart
      debug_link #(
          .RingLog2(RingLog2),
          .Divider (16'(UartDivider))
      ) u_link (
          .clk_i,
          .rst_ni,
          .rx_i,
          .tx_o,
          .csr_write_i   (csr_write),
          .csr_index_i   (csr_index),
          .csr_data_i    (block_writedata),
          .status_i      (status_word),
          .place_i       (place_word),
          .runs_i        (runs),
          .records_i     (records),
          .last_channel_i(last_channel),
          .size_log2_i   (size_log2),
          .armed_i       (armed),
          .errors_o      (uart_errors),
          .read_o        (link_read),
          .write_o       (link_write),
          .address_o     (link_address),
          .writedata_o   (link_data),
          .readdata_i    (link_in_machine ? machine_readdata_i
                        : link_in_block ? chosen_readdata : turn_readdata),
          .wait_i        (link_wait),
          .ring_taken_i  (ring_read),
          .ring_address_o(link_ring_address),
          .ring_data_i   (ring_data)
      );
    end else begin : gen_no_uart
      logic unused_uart;
      assign tx_o              = 1'b1;
      assign link_read         = 1'b0;
      assign link_write        = 1'b0;
      assign link_address      = '0;
      assign link_data         = '0;
      assign link_ring_address = '0;
      assign uart_errors       = '0;
      assign unused_uart       = ^{rx_i, link_wait, runs, last_channel, size_log2, armed,
                            machine_readdata_i};
    end
  endgenerate

  assign debug_active_o = held;

  logic unused_address;
  assign unused_address = block_address[Width-1];

endmodule
