// SPDX-License-Identifier: Apache-2.0
// n2_core: Nios II R1 instruction-compatible processor, pipeline F D E M A W, no MMU, no caches.
// Contract: fetches from the instruction memory only; loads and stores inside the two tightly coupled
// memories take one synchronous RAM cycle (rdata valid the cycle after en, held while en is low), every
// other data address goes to the Avalon-MM master. Memory ports carry word addresses. A custom
// instruction n is combinational (ci_combo_*, stage E) where CiCombinational[n] is set, else multicycle
// (ci_multi_*, stage A): start in its first cycle, ended by done, at the earliest in that same cycle.
// Bases are multiples of the (power of two) sizes; vectors lie in the instruction memory.
module n2_core #(
    parameter logic [31:0] ItcmBase = 32'h1000_0000,
    parameter int unsigned ItcmBytes = 65536,
    parameter logic [31:0] DtcmBase = 32'h1004_0000,
    parameter int unsigned DtcmBytes = 65536,
    parameter logic [31:0] ResetVector = 32'h1000_0000,
    parameter logic [31:0] ExceptionVector = 32'h1000_0020,
    parameter logic [31:0] BreakVector = 32'h1000_0020,
    parameter logic [31:0] CpuId = 32'd0,
    parameter logic [255:0] CiCombinational = 256'd0,
    parameter int unsigned HardwareMultiply = 1,
    parameter int unsigned HardwareDivide = 1,
    parameter int unsigned DivisionError = 1,
    parameter int unsigned Debug = 0,        // 1: the ports of n2_debug act; 0: they are ignored
    parameter int unsigned Trace = 0
) (
    input  logic                        clk_i,
    input  logic                        rst_ni,
    // to the instruction memory, first RAM port: fetch
    output logic                          itcm_en_o,
    output logic [$clog2(ItcmBytes)-3:0]  itcm_address_o,
    input  logic [31:0]                 itcm_rdata_i,
    // to the instruction memory, second RAM port: loads and stores
    output logic                          itcm_data_en_o,
    output logic [3:0]                    itcm_data_we_o,      // per byte
    output logic [$clog2(ItcmBytes)-3:0]  itcm_data_address_o,
    output logic [31:0]                   itcm_data_wdata_o,
    input  logic [31:0]                 itcm_data_rdata_i,
    // to the data memory
    output logic                          dtcm_en_o,
    output logic [3:0]                    dtcm_we_o,           // per byte
    output logic [$clog2(DtcmBytes)-3:0]  dtcm_address_o,
    output logic [31:0]                   dtcm_wdata_o,
    input  logic [31:0]                 dtcm_rdata_i,
    // Avalon-MM data master: readdata is taken in the cycle with read and no waitrequest
    output logic [31:0]                 avm_address_o,       // byte address, multiple of 4
    output logic                        avm_read_o,
    output logic                        avm_write_o,
    output logic [3:0]                  avm_byteenable_o,
    output logic [31:0]                 avm_writedata_o,
    input  logic [31:0]                 avm_readdata_i,
    input  logic                        avm_waitrequest_i,
    // interrupts, level
    input  logic [31:0]                 irq_i,
    // combinational custom instructions, stage E
    output logic [31:0]                 ci_combo_dataa_o,
    output logic [31:0]                 ci_combo_datab_o,
    output logic [7:0]                  ci_combo_n_o,
    output logic                        ci_combo_readra_o,
    output logic                        ci_combo_readrb_o,
    output logic                        ci_combo_writerc_o,
    output logic [4:0]                  ci_combo_a_o,
    output logic [4:0]                  ci_combo_b_o,
    output logic [4:0]                  ci_combo_c_o,
    output logic                        ci_combo_estatus_o,
    output logic [31:0]                 ci_combo_ipending_o,
    input  logic [31:0]                 ci_combo_result_i,
    // multicycle custom instructions, stage A; clock and reset are those of the core
    output logic                        ci_multi_clk_en_o,
    output logic                        ci_multi_start_o,
    output logic [31:0]                 ci_multi_dataa_o,
    output logic [31:0]                 ci_multi_datab_o,
    output logic [7:0]                  ci_multi_n_o,
    output logic                        ci_multi_readra_o,
    output logic                        ci_multi_readrb_o,
    output logic                        ci_multi_writerc_o,
    output logic [4:0]                  ci_multi_a_o,
    output logic [4:0]                  ci_multi_b_o,
    output logic [4:0]                  ci_multi_c_o,
    input  logic                        ci_multi_done_i,
    input  logic [31:0]                 ci_multi_result_i,
    // from and to n2_debug (Debug = 1)
    input  n2_pkg::debug_state_t        debug_state_i,
    input  logic                        debug_break_d_i,
    input  logic                        debug_watch_e_i,
    output n2_pkg::debug_address_t      debug_address_o,
    output n2_pkg::debug_event_t        debug_event_o,
    // counters since reset, modulo 2**32: clock cycles, instructions completed without an exception
    output logic [31:0]                 cycles_o,
    output logic [31:0]                 retired_o,
    // trace (Trace = 1): one record per instruction that left stage A, else 0
    output logic                        trace_valid_o,
    output logic [31:0]                 trace_pc_o,
    output logic [31:0]                 trace_instruction_o,
    output logic                        trace_write_o,       // value goes to register dst
    output logic [4:0]                  trace_dst_o,
    output logic [31:0]                 trace_value_o,
    output logic                        trace_exception_o,   // taken instead of (or by) the instruction
    output logic [4:0]                  trace_cause_o
);

  localparam int unsigned PcWidth = $clog2(ItcmBytes) - 2;  // words
  localparam int unsigned TableBits = PcWidth < 8 ? PcWidth : 8;
  localparam logic [31:0] ItcmUpper = ItcmBase >> (PcWidth + 2);
  localparam int unsigned Region = int'((ItcmBase & 32'h0fff_ffff) >> (PcWidth + 2));
  // The upper address bits, which no program counter holds.
  localparam logic [31:0] PcBase = ItcmUpper << (PcWidth + 2);

`ifndef SYNTHESIS
  initial begin
    if (ItcmBytes < 64 || (ItcmBytes & (ItcmBytes - 1)) != 0 || ItcmBytes > 2 ** 27)
      $error("n2_core: ItcmBytes=%0d, must be a power of two, 64 to 2^27", ItcmBytes);
    if (DtcmBytes < 64 || (DtcmBytes & (DtcmBytes - 1)) != 0)
      $error("n2_core: DtcmBytes=%0d, must be a power of two from 64 on", DtcmBytes);
    if (PcBase != ItcmBase) $error("n2_core: ItcmBase=%h is no multiple of ItcmBytes", ItcmBase);
  end
`endif

  // ---------------------------------------------------------------- pipeline control
  logic en;  // the pipeline moves: nothing holds A
  logic hold_d;  // D waits for a late result
  logic redirect_m_q;  // M sends the fetch elsewhere; E, D and F are void
  logic jump_e;  // E does; D and F are void
  logic live_e;

  // ---------------------------------------------------------------- F, D
  logic fetched_d, valid_d, issue_d, taken_d, outside_d, interrupt;
  logic [31:0] word_d, immediate_d, read_a_d, read_b_d, a_d, b_d;
  logic [PcWidth-1:0] next_d, other_d;
  logic [TableBits-1:0] index_d, index_e_q, index_m_q;
  logic [1:0] counter_d, counter_e_q, counter_m_q;
  n2_pkg::decoded_t decoded_d, decoded_e_q, decoded_m_q;

  // ---------------------------------------------------------------- E
  logic valid_e_q, write_e_q, late_e_q, taken_e_q;
  logic [4:0] dst_e_q;
  logic [31:0] a_e_q, b_e_q, word_e_q;
  logic [PcWidth-1:0] next_e_q, other_e_q;
  logic [31:0] sum_e, logic_e, other_result_e, result_e, next_address_e;
  logic condition_e, misaligned_e, bad_target_e, bad_division_e, fault_e, wrong_e;
  logic [4:0] cause_e;

  // ---------------------------------------------------------------- M
  logic valid_m_q, write_m_q, late_m_q, fault_m_q, branch_m_q;
  logic div_m_q, ci_m_q;
  logic [4:0] dst_m_q, cause_m_q;
  logic [31:0] result_m_q, a_m_q, b_m_q, word_m_q, address_m, shift_m, control_m, badaddr_m;
  logic [PcWidth-1:0] target_m_q;

  // ---------------------------------------------------------------- A
  logic debug_a_q;  // an instruction of the debugger
  logic valid_a_q, write_a_q, fault_a_q, ci_a_q, started_a_q;
  logic load_a_q, mul_low_a_q, mul_high_a_q, div_a_q;
  logic [4:0] dst_a_q;
  logic [31:0] early_a_q, a_a_q, b_a_q, result_a, load_a, quotient_a;
  logic [31:6] word_a_q;
  logic [63:0] product_a;
  logic lsu_wait_a, div_wait_a;

  // Without a debugger the core never halts.
  n2_pkg::debug_state_t debug;
  n2_pkg::debug_address_t watched;
  n2_pkg::debug_event_t happening;
  logic break_d, watch_e;
  assign debug_address_o = Debug != 0 ? watched : '0;
  assign debug_event_o   = Debug != 0 ? happening : '0;
  assign debug   = Debug != 0 ? debug_state_i : '0;
  assign break_d = Debug != 0 && debug_break_d_i;
  assign watch_e = Debug != 0 && debug_watch_e_i;

  assign en = !(lsu_wait_a || div_wait_a || (ci_a_q && !ci_multi_done_i));

  n2_fetch #(
      .AddressWidth(PcWidth),
      .Region      (Region),
      .TableBits   (TableBits),
      .ResetVector (ResetVector)
  ) u_fetch (
      .clk_i,
      .rst_ni,
      .en_i        (en),
      .hold_i      (hold_d),
      .itcm_en_o,
      .itcm_address_o,
      .itcm_rdata_i(debug.halted ? debug.word : itcm_rdata_i),
      .jump_e_i    (jump_e),
      .target_e_i  (a_e_q[2+:PcWidth]),
      .redirect_m_i(redirect_m_q),
      .target_m_i  (target_m_q),
      .update_m_i  (en && branch_m_q),
      .index_m_i   (index_m_q),
      .counter_m_i (counter_m_q),
      .valid_d_o   (fetched_d),
      .word_d_o    (word_d),
      .next_d_o    (next_d),
      .other_d_o   (other_d),
      .taken_d_o   (taken_d),
      .index_d_o   (index_d),
      .counter_d_o (counter_d),
      .outside_d_o (outside_d)
  );

  // ---------------------------------------------------------------- D: decode, operands
  n2_decode #(
      .CiCombinational (CiCombinational),
      .HardwareMultiply(HardwareMultiply),
      .HardwareDivide  (HardwareDivide)
  ) u_decode (
      .instruction_i   (word_d[26:0]),
      .interrupt_i     (interrupt && !debug.mask),
      .break_i         (break_d),
      .target_outside_i(outside_d),
      .decoded_o       (decoded_d)
  );

  n2_regfile u_regfile (
      .clk_i,
      .write_i(en && write_a_q),
      .dst_i  (dst_a_q),
      .value_i(result_a),
      .a_i    (word_d[31:27]),
      .b_i    (word_d[26:22]),
      .a_o    (read_a_d),
      .b_o    (read_b_d)
  );

  assign valid_d = debug.halted ? debug.valid : fetched_d;
  assign issue_d = valid_d && !hold_d && !jump_e && !redirect_m_q;

  // Youngest producer of each operand: E, M, A, else the register file. r0 has no producer.
  logic a_in_e, a_in_m, a_in_a, b_in_e, b_in_m, b_in_a;
  logic a_from_a, b_from_a, a_from_file, b_from_file, b_register;
  assign a_in_e = write_e_q && dst_e_q == word_d[31:27];
  assign a_in_m = write_m_q && dst_m_q == word_d[31:27];
  assign a_in_a = write_a_q && dst_a_q == word_d[31:27];
  assign b_in_e = write_e_q && dst_e_q == word_d[26:22];
  assign b_in_m = write_m_q && dst_m_q == word_d[26:22];
  assign b_in_a = write_a_q && dst_a_q == word_d[26:22];

  // A late result is there in A: until then its readers wait in D.
  assign hold_d = valid_d &&
                  ((decoded_d.read_a && ((late_e_q && a_in_e) || (late_m_q && a_in_m && !a_in_e))) ||
                   (decoded_d.read_b && ((late_e_q && b_in_e) || (late_m_q && b_in_m && !b_in_e))));

  always_comb begin
    case (decoded_d.immediate)
      n2_pkg::ImSigned:   immediate_d = {{16{word_d[21]}}, word_d[21:6]};
      n2_pkg::ImUnsigned: immediate_d = {16'd0, word_d[21:6]};
      n2_pkg::ImHigh:     immediate_d = {word_d[21:6], 16'd0};
      n2_pkg::ImShift:    immediate_d = {27'd0, word_d[10:6]};
      default:            immediate_d = 32'd0;
    endcase

    b_register = decoded_d.immediate == n2_pkg::ImRegister;
    a_from_a = a_in_a && !a_in_m && !a_in_e;
    b_from_a = b_in_a && !b_in_m && !b_in_e && b_register;
    a_from_file = !a_in_e && !a_in_m && !a_in_a && word_d[31:27] != 5'd0;
    b_from_file = !b_in_e && !b_in_m && !b_in_a && word_d[26:22] != 5'd0 && b_register;

    // The results of E and A come last, so that one gate follows them.
    a_d = ({32{a_in_e}} & result_e) | ({32{a_from_a}} & result_a) |
          ({32{a_in_m && !a_in_e}} & result_m_q) | ({32{a_from_file}} & read_a_d);
    b_d = ({32{b_in_e && b_register}} & result_e) | ({32{b_from_a}} & result_a) |
          ({32{b_in_m && !b_in_e && b_register}} & result_m_q) | ({32{b_from_file}} & read_b_d) |
          immediate_d;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_e_q <= 1'b0;
      write_e_q <= 1'b0;
      late_e_q  <= 1'b0;
    end else if (en) begin
      valid_e_q <= issue_d;
      write_e_q <= issue_d && decoded_d.write;
      late_e_q  <= decoded_d.late;
    end
  end

  always_ff @(posedge clk_i) begin
    if (en) begin
      decoded_e_q <= decoded_d;
      dst_e_q     <= decoded_d.dst;
      a_e_q       <= a_d;
      b_e_q       <= b_d;
      word_e_q    <= word_d;
      next_e_q    <= next_d;
      other_e_q   <= other_d;
      taken_e_q   <= taken_d;
      index_e_q   <= index_d;
      counter_e_q <= counter_d;
    end
  end

  // ---------------------------------------------------------------- E: execute
  n2_alu u_alu (
      .a_i        (a_e_q),
      .b_i        (b_e_q),
      .subtract_i (decoded_e_q.subtract),
      .logic_op_i (decoded_e_q.logic_op),
      .equal_i    (decoded_e_q.compare_equal),
      .signed_i   (decoded_e_q.compare_signed),
      .invert_i   (decoded_e_q.compare_invert),
      .sum_o      (sum_e),
      .logic_o    (logic_e),
      .condition_o(condition_e)
  );

  assign next_address_e = PcBase | 32'({next_e_q, 2'b00});
  always_comb begin
    case (decoded_e_q.result)
      n2_pkg::RsLogic:   other_result_e = logic_e;
      n2_pkg::RsCompare: other_result_e = {31'd0, condition_e};
      n2_pkg::RsNext:    other_result_e = next_address_e;
      default:           other_result_e = 32'd0;
    endcase
    result_e = ({32{decoded_e_q.result == n2_pkg::RsAdd}} & sum_e) |
               ({32{decoded_e_q.result == n2_pkg::RsCustom}} & ci_combo_result_i) | other_result_e;
  end

  assign ci_combo_dataa_o    = a_e_q;
  assign ci_combo_datab_o    = b_e_q;
  assign ci_combo_n_o        = word_e_q[13:6];
  assign ci_combo_readra_o   = word_e_q[16];
  assign ci_combo_readrb_o   = word_e_q[15];
  assign ci_combo_writerc_o  = word_e_q[14];
  assign ci_combo_a_o        = word_e_q[31:27];
  assign ci_combo_b_o        = word_e_q[26:22];
  assign ci_combo_c_o        = word_e_q[21:17];

  assign live_e = valid_e_q && !redirect_m_q;
  assign jump_e = valid_e_q && decoded_e_q.jump;
  assign wrong_e = decoded_e_q.branch && condition_e != taken_e_q;

  assign bad_target_e = (decoded_e_q.jump || decoded_e_q.leave) &&
                        (a_e_q[1:0] != 2'd0 || (a_e_q >> (PcWidth + 2)) != ItcmUpper);
  assign bad_division_e = DivisionError != 0 && decoded_e_q.div &&
                          (b_e_q == 32'd0 ||
                           (decoded_e_q.div_signed && a_e_q == 32'h8000_0000 && b_e_q == '1));
  assign fault_e = decoded_e_q.fault || misaligned_e || bad_target_e || bad_division_e;
  always_comb begin
    if (decoded_e_q.fault) cause_e = decoded_e_q.cause;
    else if (bad_target_e) cause_e = n2_isa_pkg::CAUSE_TARGET_ADDRESS;
    else if (decoded_e_q.div) cause_e = n2_isa_pkg::CAUSE_DIVISION;
    else cause_e = n2_isa_pkg::CAUSE_DATA_ADDRESS;
  end

  n2_shift u_shift (
      .clk_i,
      .en_i      (en),
      .value_i   (a_e_q),
      .count_i   (b_e_q[4:0]),
      .right_i   (decoded_e_q.shift_right),
      .rotate_i  (decoded_e_q.shift_rotate),
      .sign_i    (decoded_e_q.shift_sign),
      .result_m_o(shift_m)
  );

  n2_mul u_mul (
      .clk_i,
      .en_i       (en),
      .a_i        (a_e_q),
      .b_i        (b_e_q),
      .signed_a_i (decoded_e_q.mul_signed_a),
      .signed_b_i (decoded_e_q.mul_signed_b),
      .product_a_o(product_a)
  );

  n2_lsu #(
      .ItcmBase (ItcmBase),
      .ItcmBytes(ItcmBytes),
      .DtcmBase (DtcmBase),
      .DtcmBytes(DtcmBytes)
  ) u_lsu (
      .clk_i,
      .rst_ni,
      .en_i          (en),
      .live_e_i      (live_e),
      .load_e_i      (decoded_e_q.load),
      .store_e_i     (decoded_e_q.store),
      .size_e_i      (decoded_e_q.size),
      .signed_e_i    (decoded_e_q.load_signed),
      .base_e_i      (a_e_q),
      .offset_e_i    (word_e_q[21:6]),
      .data_e_i      (b_e_q),
      .misaligned_e_o(misaligned_e),
      .word_e_o      (watched.data_e),
      .lanes_e_o     (watched.lanes_e),
      .address_m_o   (address_m),
      .wait_a_o      (lsu_wait_a),
      .data_a_o      (load_a),
      .itcm_en_o     (itcm_data_en_o),
      .itcm_we_o     (itcm_data_we_o),
      .itcm_address_o(itcm_data_address_o),
      .itcm_wdata_o  (itcm_data_wdata_o),
      .itcm_rdata_i  (itcm_data_rdata_i),
      .dtcm_en_o,
      .dtcm_we_o,
      .dtcm_address_o,
      .dtcm_wdata_o,
      .dtcm_rdata_i,
      .avm_address_o,
      .avm_read_o,
      .avm_write_o,
      .avm_byteenable_o,
      .avm_writedata_o,
      .avm_readdata_i,
      .avm_waitrequest_i
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_m_q    <= 1'b0;
      write_m_q    <= 1'b0;
      late_m_q     <= 1'b0;
      fault_m_q    <= 1'b0;
      branch_m_q   <= 1'b0;
      div_m_q      <= 1'b0;
      ci_m_q       <= 1'b0;
      redirect_m_q <= 1'b1;  // the first fetch
    end else if (en) begin
      valid_m_q    <= live_e;
      write_m_q    <= live_e && (write_e_q || fault_e);
      late_m_q     <= late_e_q;
      fault_m_q    <= live_e && fault_e;
      branch_m_q   <= live_e && decoded_e_q.branch;
      div_m_q      <= live_e && decoded_e_q.div && !fault_e;
      ci_m_q       <= live_e && decoded_e_q.ci_multi;
      redirect_m_q <= live_e && (fault_e || wrong_e || decoded_e_q.leave || decoded_e_q.flush || watch_e);
    end
  end

  // Where M goes: the reset vector before anything else.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) target_m_q <= ResetVector[2+:PcWidth];
    else if (en) begin
      if (decoded_e_q.fault && decoded_e_q.breakpoint) target_m_q <= BreakVector[2+:PcWidth];
      else if (fault_e) target_m_q <= ExceptionVector[2+:PcWidth];
      else if (decoded_e_q.leave) target_m_q <= a_e_q[2+:PcWidth];
      else if (decoded_e_q.flush || watch_e) target_m_q <= next_e_q;
      else target_m_q <= other_e_q;
    end
  end

  always_ff @(posedge clk_i) begin
    if (en) begin
      decoded_m_q <= decoded_e_q;
      dst_m_q     <= fault_e && !decoded_e_q.fault ? n2_isa_pkg::REG_EA : dst_e_q;
      result_m_q  <= result_e;
      a_m_q       <= a_e_q;
      b_m_q       <= b_e_q;
      word_m_q    <= word_e_q;
      cause_m_q   <= cause_e;
      index_m_q   <= index_e_q;
      // Saturating: up when taken.
      if (condition_e) counter_m_q <= counter_e_q == 2'b11 ? 2'b11 : counter_e_q + 2'b01;
      else counter_m_q <= counter_e_q == 2'b00 ? 2'b00 : counter_e_q - 2'b01;
    end
  end

  // ---------------------------------------------------------------- M: control registers
  assign badaddr_m = cause_m_q == n2_isa_pkg::CAUSE_DATA_ADDRESS ? address_m :
                     decoded_m_q.fault ? {PcBase[31:28], word_m_q[31:6], 2'b00} : a_m_q;

  n2_control #(
      .CpuId(CpuId)
  ) u_control (
      .clk_i,
      .rst_ni,
      .strobe_i     (en && valid_m_q),
      .fault_i      (fault_m_q),
      .breakpoint_i (decoded_m_q.breakpoint),
      .cause_i      (cause_m_q),
      .badaddr_i    (badaddr_m),
      .leave_i      (decoded_m_q.leave),
      .leave_break_i(decoded_m_q.leave_break),
      .wrctl_i      (decoded_m_q.wrctl),
      .number_i     (word_m_q[10:6]),
      .value_i      (a_m_q),
      .read_o       (control_m),
      .irq_i,
      .interrupt_o  (interrupt),
      .estatus_o    (ci_combo_estatus_o),
      .ipending_o   (ci_combo_ipending_o)
  );

  // A halted core exchanges words with its debugger through a control register that reads 0 otherwise.
  logic debug_ctl_m;
  logic [31:0] debug_data_m;
  assign debug_ctl_m  = debug.halted && word_m_q[10:6] == n2_pkg::CTL_DEBUG;
  assign debug_data_m = debug_ctl_m ? debug.data : 32'd0;

  logic load_m;
  assign load_m = decoded_m_q.load && !fault_m_q;

  generate
    if (Debug != 0) begin : gen_debug
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) debug_a_q <= 1'b0;
        else if (en) debug_a_q <= debug.halted;
      end
    end else begin : gen_no_debug
      assign debug_a_q = 1'b0;
    end
  endgenerate

  assign watched.next_d   = PcBase[31:2] | 30'(next_d);
  assign watched.access_e = live_e && (decoded_e_q.load || decoded_e_q.store) && !misaligned_e;
  assign watched.store_e  = decoded_e_q.store;
  assign happening.en       = en;
  assign happening.issue_d  = en && issue_d;
  assign happening.break_m  = en && fault_m_q && decoded_m_q.breakpoint;
  assign happening.return_m = en && valid_m_q && decoded_m_q.leave_break && !fault_m_q;
  assign happening.write_m  = en && valid_m_q && decoded_m_q.wrctl && debug_ctl_m;
  assign happening.value_m  = a_m_q;

  n2_div u_div (
      .clk_i,
      .rst_ni,
      .start_i   (en && div_m_q),
      .signed_i  (decoded_m_q.div_signed),
      .dividend_i(a_m_q),
      .divisor_i (b_m_q),
      .busy_o    (div_wait_a),
      .quotient_o(quotient_a)
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_a_q   <= 1'b0;
      write_a_q   <= 1'b0;
      fault_a_q   <= 1'b0;
      ci_a_q      <= 1'b0;
      started_a_q <= 1'b0;
    end else begin
      started_a_q <= ci_a_q && !en;
      if (en) begin
        valid_a_q <= valid_m_q;
        write_a_q <= write_m_q;
        fault_a_q <= fault_m_q;
        ci_a_q    <= ci_m_q;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (en) begin
      dst_a_q <= dst_m_q;
      if (load_m || decoded_m_q.mul || div_m_q || ci_m_q) early_a_q <= 32'd0;
      else if (decoded_m_q.rdctl) early_a_q <= control_m | debug_data_m;
      else early_a_q <= decoded_m_q.shift ? shift_m : result_m_q;
      load_a_q     <= load_m;
      mul_low_a_q  <= decoded_m_q.mul && !decoded_m_q.mul_high;
      mul_high_a_q <= decoded_m_q.mul && decoded_m_q.mul_high;
      div_a_q      <= div_m_q;
      a_a_q        <= a_m_q;
      b_a_q        <= b_m_q;
      word_a_q     <= word_m_q[31:6];
    end
  end

  // ---------------------------------------------------------------- A: late results
  always_comb begin
    // early_a_q is 0 if one of the others is the result.
    result_a = ({32{ci_a_q}} & ci_multi_result_i) | ({32{load_a_q}} & load_a) |
               ({32{mul_low_a_q}} & product_a[31:0]) | ({32{mul_high_a_q}} & product_a[63:32]) |
               ({32{div_a_q}} & quotient_a) | early_a_q;
  end

  assign ci_multi_clk_en_o  = !(lsu_wait_a || div_wait_a);
  assign ci_multi_start_o   = ci_a_q && !started_a_q;
  assign ci_multi_dataa_o   = a_a_q;
  assign ci_multi_datab_o   = b_a_q;
  assign ci_multi_n_o       = word_a_q[13:6];
  assign ci_multi_readra_o  = word_a_q[16];
  assign ci_multi_readrb_o  = word_a_q[15];
  assign ci_multi_writerc_o = word_a_q[14];
  assign ci_multi_a_o       = word_a_q[31:27];
  assign ci_multi_b_o       = word_a_q[26:22];
  assign ci_multi_c_o       = word_a_q[21:17];

  // ---------------------------------------------------------------- W: counters, trace
  logic [31:0] cycles_q, retired_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      cycles_q  <= 32'd0;
      retired_q <= 32'd0;
    end else begin
      cycles_q <= cycles_q + 32'd1;
      if (en && valid_a_q && !fault_a_q && !debug_a_q) retired_q <= retired_q + 32'd1;
    end
  end
  assign cycles_o  = cycles_q;
  assign retired_o = retired_q;

  generate
    if (Trace != 0) begin : gen_trace
      n2_trace #(
          .AddressWidth(PcWidth),
          .PcBase      (PcBase)
      ) u_trace (
          .clk_i,
          .rst_ni,
          .en_i     (en),
          .next_e_i (next_e_q),
          .word_m_i (word_m_q),
          .cause_m_i(cause_m_q),
          .valid_a_i(valid_a_q && !debug_a_q),
          .write_a_i(write_a_q),
          .fault_a_i(fault_a_q),
          .dst_a_i  (dst_a_q),
          .value_a_i(result_a),
          .trace_valid_o,
          .trace_pc_o,
          .trace_instruction_o,
          .trace_write_o,
          .trace_dst_o,
          .trace_value_o,
          .trace_exception_o,
          .trace_cause_o
      );
    end else begin : gen_no_trace
      assign {trace_valid_o, trace_pc_o, trace_instruction_o, trace_write_o, trace_dst_o} = '0;
      assign {trace_value_o, trace_exception_o, trace_cause_o} = '0;
    end
  endgenerate

endmodule
