// SPDX-License-Identifier: Apache-2.0
// n2_system: the systems FPGA1 (Platform 1, vendor floating-point instructions) and FPGA2 (Platform 2,
// own instructions): core, tightly coupled memories, custom instructions, I/O.
// Contract: memory map of nios_sw/system.toml. The host port sees the memories, writes the block input
// and reads the block output, at the addresses of the map; data follow one cycle later. It may touch
// the instruction memory only while run_i is low, which holds the core in reset. One write per cycle.
// With Debug = 1 a debugger has the core through the port debug_*, registers of rtl/nios/debug_regmap.rdl;
// with 0 the port is dead. debug_halted_o: a line for who must know that nobody controls the machine.
// With External = 1 accesses outside of memories and I/O go to the port ext_*, where an agent answers; with 0 it is dead.
module n2_system #(
    parameter int unsigned Platform = 2,
    parameter int unsigned Debug    = 0,
    parameter int unsigned Trace    = 0,
    parameter int unsigned External = 0
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    // host
    input  logic        run_i,
    input  logic [31:0] host_address_i,   // byte address, multiple of 4
    input  logic        host_write_i,
    input  logic [31:0] host_wdata_i,
    output logic [31:0] host_rdata_o,
    input  logic        enable_i,
    input  logic        tick_i,
    output logic        pending_o,
    output logic        overrun_o,
    output logic [31:0] tick_cycles_o,
    // console and end of a program
    output logic        console_valid_o,
    output logic [7:0]  console_data_o,
    output logic        exit_valid_o,
    output logic [31:0] exit_status_o,
    // agents next to the I/O (External = 1): Avalon-MM host, byte address
    output logic [31:0] ext_address_o,
    output logic        ext_read_o,
    output logic        ext_write_o,
    output logic [3:0]  ext_byteenable_o,
    output logic [31:0] ext_writedata_o,
    input  logic [31:0] ext_readdata_i,
    input  logic        ext_waitrequest_i,
    // debugger (Debug = 1): Avalon-MM agent, address of words; its reset is rst_ni alone
    input  logic [4:0]  debug_address_i,
    input  logic        debug_read_i,
    input  logic        debug_write_i,
    input  logic [31:0] debug_writedata_i,
    output logic [31:0] debug_readdata_o,
    output logic        debug_waitrequest_o,
    output logic        debug_halted_o,
    // trace of the core (Trace = 1)
    output logic [31:0] cycles_o,
    output logic [31:0] retired_o,
    output logic        trace_valid_o,
    output logic [31:0] trace_pc_o,
    output logic [31:0] trace_instruction_o,
    output logic        trace_write_o,
    output logic [4:0]  trace_dst_o,
    output logic [31:0] trace_value_o,
    output logic        trace_exception_o,
    output logic [4:0]  trace_cause_o
);

  localparam logic [31:0] ItcmBase = n2_system_pkg::ITCM_BASE;
  localparam logic [31:0] DtcmBase = n2_system_pkg::DTCM_BASE;
  localparam logic [31:0] IoBase = n2_system_pkg::IO_BASE;
  localparam int unsigned ItcmWords = n2_system_pkg::ITCM_WORDS;
  localparam int unsigned DtcmWords = n2_system_pkg::DTCM_WORDS;
  localparam int unsigned ItcmWidth = n2_system_pkg::ITCM_ADDRESS_WIDTH;
  localparam int unsigned DtcmWidth = n2_system_pkg::DTCM_ADDRESS_WIDTH;
  localparam int unsigned IoWidth = n2_system_pkg::IO_ADDRESS_WIDTH;
  localparam int unsigned HostWidth = $clog2(n2_io_regmap_pkg::WORDS_INPUTS);
  localparam logic [255:0] Combinational = Platform == 1 ? ci_pkg::FPGA1_COMBINATIONAL : ci_pkg::FPGA2_COMBINATIONAL;

  logic run_q, core_rst_n;
  // core to memories
  logic fetch_en, code_en, data_en;
  logic [ItcmWidth-1:0] fetch_address, code_address;
  logic [DtcmWidth-1:0] data_address;
  logic [3:0] code_we, data_we;
  logic [31:0] fetch_rdata, code_wdata, code_rdata, data_wdata, data_rdata;
  // core to I/O
  logic [31:0] avm_address, avm_writedata, avm_readdata;
  logic avm_read, avm_write, avm_waitrequest, io_select, io_waitrequest;
  logic [3:0] avm_byteenable;
  logic [31:0] io_readdata;
  logic timer_irq;
  // custom instructions
  logic [31:0] combo_dataa, combo_datab, combo_result, combo_ipending;
  logic [31:0] multi_dataa, multi_datab, multi_result;
  logic [7:0] combo_n, multi_n;
  logic combo_readra, combo_readrb, combo_writerc, combo_estatus;
  logic multi_readra, multi_readrb, multi_writerc;
  logic [4:0] combo_a, combo_b, combo_c, multi_a, multi_b, multi_c;
  logic multi_clk_en, multi_start, multi_done;
  // host
  logic host_itcm, host_dtcm, host_io, host_itcm_q, host_dtcm_q;
  logic [31:0] host_data_rdata, host_io_rdata;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) run_q <= 1'b0;
    else run_q <= run_i;
  end

  assign core_rst_n = rst_ni && run_q;

  n2_pkg::debug_state_t debug_state;
  n2_pkg::debug_address_t debug_address;
  n2_pkg::debug_event_t debug_event;
  logic debug_break_d, debug_watch_e, debug_freeze;

  // ------------------------------------------------------------------ core
  n2_core #(
      .ItcmBase       (ItcmBase),
      .ItcmBytes      (4 * ItcmWords),
      .DtcmBase       (DtcmBase),
      .DtcmBytes      (4 * DtcmWords),
      .ResetVector    (n2_system_pkg::RESET_VECTOR),
      .ExceptionVector(n2_system_pkg::EXCEPTION_VECTOR),
      .BreakVector    (n2_system_pkg::EXCEPTION_VECTOR),
      .CiCombinational(Combinational),
      .Debug          (Debug),
      .Trace          (Trace)
  ) u_core (
      .clk_i              (clk_i),
      .rst_ni             (core_rst_n),
      .itcm_en_o          (fetch_en),
      .itcm_address_o     (fetch_address),
      .itcm_rdata_i       (fetch_rdata),
      .itcm_data_en_o     (code_en),
      .itcm_data_we_o     (code_we),
      .itcm_data_address_o(code_address),
      .itcm_data_wdata_o  (code_wdata),
      .itcm_data_rdata_i  (code_rdata),
      .dtcm_en_o          (data_en),
      .dtcm_we_o          (data_we),
      .dtcm_address_o     (data_address),
      .dtcm_wdata_o       (data_wdata),
      .dtcm_rdata_i       (data_rdata),
      .avm_address_o      (avm_address),
      .avm_read_o         (avm_read),
      .avm_write_o        (avm_write),
      .avm_byteenable_o   (avm_byteenable),
      .avm_writedata_o    (avm_writedata),
      .avm_readdata_i     (avm_readdata),
      .avm_waitrequest_i  (avm_waitrequest),
      .irq_i              ({31'd0, timer_irq}),
      .ci_combo_dataa_o   (combo_dataa),
      .ci_combo_datab_o   (combo_datab),
      .ci_combo_n_o       (combo_n),
      .ci_combo_readra_o  (combo_readra),
      .ci_combo_readrb_o  (combo_readrb),
      .ci_combo_writerc_o (combo_writerc),
      .ci_combo_a_o       (combo_a),
      .ci_combo_b_o       (combo_b),
      .ci_combo_c_o       (combo_c),
      .ci_combo_estatus_o (combo_estatus),
      .ci_combo_ipending_o(combo_ipending),
      .ci_combo_result_i  (combo_result),
      .ci_multi_clk_en_o  (multi_clk_en),
      .ci_multi_start_o   (multi_start),
      .ci_multi_dataa_o   (multi_dataa),
      .ci_multi_datab_o   (multi_datab),
      .ci_multi_n_o       (multi_n),
      .ci_multi_readra_o  (multi_readra),
      .ci_multi_readrb_o  (multi_readrb),
      .ci_multi_writerc_o (multi_writerc),
      .ci_multi_a_o       (multi_a),
      .ci_multi_b_o       (multi_b),
      .ci_multi_c_o       (multi_c),
      .ci_multi_done_i    (multi_done),
      .ci_multi_result_i  (multi_result),
      .debug_state_i      (debug_state),
      .debug_break_d_i    (debug_break_d),
      .debug_watch_e_i    (debug_watch_e),
      .debug_address_o    (debug_address),
      .debug_event_o      (debug_event),
      .cycles_o           (cycles_o),
      .retired_o          (retired_o),
      .trace_valid_o      (trace_valid_o),
      .trace_pc_o         (trace_pc_o),
      .trace_instruction_o(trace_instruction_o),
      .trace_write_o      (trace_write_o),
      .trace_dst_o        (trace_dst_o),
      .trace_value_o      (trace_value_o),
      .trace_exception_o  (trace_exception_o),
      .trace_cause_o      (trace_cause_o)
  );

  generate
    if (Debug != 0) begin : gen_debug
      n2_debug u_debug (
          .clk_i            (clk_i),
          .rst_ni           (rst_ni),
          .core_rst_ni      (core_rst_n),
          .avs_address_i    (debug_address_i),
          .avs_read_i       (debug_read_i),
          .avs_write_i      (debug_write_i),
          .avs_writedata_i  (debug_writedata_i),
          .avs_readdata_o   (debug_readdata_o),
          .avs_waitrequest_o(debug_waitrequest_o),
          .halted_o         (debug_halted_o),
          .freeze_o         (debug_freeze),
          .state_o          (debug_state),
          .break_d_o        (debug_break_d),
          .watch_e_o        (debug_watch_e),
          .address_i        (debug_address),
          .event_i          (debug_event)
      );
    end else begin : gen_no_debug
      logic unused_debug;
      assign {debug_readdata_o, debug_waitrequest_o, debug_halted_o} = '0;
      assign {debug_state, debug_break_d, debug_watch_e, debug_freeze} = '0;
      assign unused_debug = &{debug_address_i, debug_read_i, debug_write_i, debug_writedata_i,
                            debug_address, debug_event};
    end
  endgenerate

  // ------------------------------------------------------------------ memories
  assign host_itcm = host_address_i[31:ItcmWidth+2] == ItcmBase[31:ItcmWidth+2];
  assign host_dtcm = host_address_i[31:DtcmWidth+2] == DtcmBase[31:DtcmWidth+2];

  // Loads and stores share the second port of the instruction memory with the host, which has it
  // while the core does not run.
  n2_tcm #(
      .Words(ItcmWords)
  ) u_itcm (
      .clk_i      (clk_i),
      .a_en_i     (fetch_en),
      .a_we_i     (4'd0),
      .a_address_i(fetch_address),
      .a_wdata_i  (32'd0),
      .a_rdata_o  (fetch_rdata),
      .b_en_i     (run_q ? code_en : host_itcm),
      .b_we_i     (run_q ? code_we : {4{host_write_i}}),
      .b_address_i(run_q ? code_address : host_address_i[ItcmWidth+1:2]),
      .b_wdata_i  (run_q ? code_wdata : host_wdata_i),
      .b_rdata_o  (code_rdata)
  );

  n2_tcm #(
      .Words(DtcmWords)
  ) u_dtcm (
      .clk_i      (clk_i),
      .a_en_i     (data_en),
      .a_we_i     (data_we),
      .a_address_i(data_address),
      .a_wdata_i  (data_wdata),
      .a_rdata_o  (data_rdata),
      .b_en_i     (host_dtcm),
      .b_we_i     ({4{host_write_i}}),
      .b_address_i(host_address_i[DtcmWidth+1:2]),
      .b_wdata_i  (host_wdata_i),
      .b_rdata_o  (host_data_rdata)
  );

  // ------------------------------------------------------------------ custom instructions
  ci_slaves #(
      .Platform(Platform)
  ) u_ci (
      .multi_clk_i    (clk_i),
      .multi_reset_i  (!core_rst_n),
      .combo_dataa_i  (combo_dataa),
      .combo_datab_i  (combo_datab),
      .combo_n_i      (combo_n),
      .combo_readra_i (combo_readra),
      .combo_readrb_i (combo_readrb),
      .combo_writerc_i(combo_writerc),
      .combo_a_i      (combo_a),
      .combo_b_i      (combo_b),
      .combo_c_i      (combo_c),
      .combo_result_o (combo_result),
      .multi_clk_en_i (multi_clk_en),
      .multi_start_i  (multi_start),
      .multi_dataa_i  (multi_dataa),
      .multi_datab_i  (multi_datab),
      .multi_n_i      (multi_n),
      .multi_readra_i (multi_readra),
      .multi_readrb_i (multi_readrb),
      .multi_writerc_i(multi_writerc),
      .multi_a_i      (multi_a),
      .multi_b_i      (multi_b),
      .multi_c_i      (multi_c),
      .multi_done_o   (multi_done),
      .multi_result_o (multi_result)
  );

  // ------------------------------------------------------------------ I/O
  // Where no agent is, reads give 0 and writes are lost, in one cycle: a stray access never hangs.
  assign io_select       = avm_address[31:IoWidth+2] == IoBase[31:IoWidth+2];
  assign avm_readdata    = io_select ? io_readdata : External != 0 ? ext_readdata_i : 32'd0;
  assign avm_waitrequest = io_select ? io_waitrequest : External != 0 && ext_waitrequest_i;
  assign host_io         = host_address_i[31:IoWidth+2] == IoBase[31:IoWidth+2];

  assign ext_address_o    = External != 0 ? avm_address : '0;
  assign ext_read_o       = External != 0 && avm_read && !io_select;
  assign ext_write_o      = External != 0 && avm_write && !io_select;
  assign ext_byteenable_o = External != 0 ? avm_byteenable : '0;
  assign ext_writedata_o  = External != 0 ? avm_writedata : '0;

  n2_io #(
      .Platform(Platform)
  ) u_io (
      .clk_i            (clk_i),
      .rst_ni           (core_rst_n),
      .freeze_i         (debug_freeze),
      .avs_address_i    (avm_address[IoWidth+1:2]),
      .avs_read_i       (avm_read && io_select),
      .avs_write_i      (avm_write && io_select),
      .avs_writedata_i  (avm_writedata),
      .avs_readdata_o   (io_readdata),
      .avs_waitrequest_o(io_waitrequest),
      .irq_o            (timer_irq),
      .host_word_i      (host_address_i[HostWidth+1:2]),
      .host_write_i     (host_write_i && host_io),
      .host_wdata_i     (host_wdata_i),
      .host_rdata_o     (host_io_rdata),
      .enable_i         (enable_i),
      .tick_i           (tick_i),
      .pending_o        (pending_o),
      .overrun_o        (overrun_o),
      .tick_cycles_o    (tick_cycles_o),
      .console_valid_o  (console_valid_o),
      .console_data_o   (console_data_o),
      .exit_valid_o     (exit_valid_o),
      .exit_status_o    (exit_status_o)
  );

  // ------------------------------------------------------------------ host
  always_ff @(posedge clk_i) begin
    host_itcm_q <= host_itcm;
    host_dtcm_q <= host_dtcm;
  end

  assign host_rdata_o = host_itcm_q ? code_rdata : host_dtcm_q ? host_data_rdata : host_io_rdata;

  logic unused;
  assign unused = &{combo_estatus, combo_ipending, avm_byteenable, avm_address[1:0], host_address_i[1:0],
                    ext_readdata_i, ext_waitrequest_i};

endmodule
