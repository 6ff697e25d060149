// SPDX-License-Identifier: Apache-2.0
// asip_host: Avalon-MM agent and control and status registers (map: docs/regmap.md).
// Contract: word addresses, 32-bit words only. Writes take one cycle, reads five. With several slots and without
// Resilience, a read in the clock after a write to a register or constant takes six. Accesses to memories and to
// registers that configure a run are held by waitrequest_o while a run is active. A word beyond a memory reads 0 and is
// not written.
module asip_host #(
    parameter int unsigned Slots     = 3,
    parameter int unsigned FmaPipes  = 2,
    parameter int unsigned Bundles   = 1024,
    parameter int unsigned DataWords = 1024,
    parameter int unsigned Debug     = 0,     // 1: bank K can be read
    parameter int unsigned Resilience = 0,    // 1: parity of the registers that configure a run
    parameter int unsigned Plausible  = 1,    // 1: with Resilience, there is a plausibility record
    parameter int unsigned StreamWords = 0,   // of each stream; 0: there is none
    parameter int unsigned Loops       = 0,   // levels
    parameter int unsigned Lanes       = 0    // of each multiply-add pipe, besides the first
) (
    input  logic                                      clk_i,
    input  logic                                      rst_ni,
    // Avalon-MM
    input  logic [asip_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic                                      read_i,
    input  logic                                      write_i,
    input  logic [31:0]                               writedata_i,
    output logic [31:0]                               readdata_o,
    output logic                                      waitrequest_o,
    output logic                                      irq_o,
    // from and to control
    output logic                                      start_o,
    output logic                                      clear_o,
    output logic                                      refetch_o,
    output logic [31:0]                               watchdog_o,
    output logic [15:0]                               entry_o,
    output logic [31:0]                               output_mask_o,
    input  logic                                      busy_i,
    input  logic                                      hold_i,          // accesses to memories wait
    input  logic                                      copy_i,          // those to banks A, B, C
    input  logic                                      repaired_i,
    output logic                                      broken_o,        // parity of a register
    input  logic                                      output_parity_i,
    output logic                                      bad_output_o,    // an output read is wrong
    input  logic                                      done_i,
    input  logic                                      fault_i,
    input  logic [3:0]                                cause_i,
    input  logic [15:0]                               fault_info_i,
    input  fp_pkg::flags_t                            flags_i,
    input  logic [31:0]                               cycles_i,
    output logic [2:0]                                count_select_o,  // of STALL_* and DRAIN
    input  logic [31:0]                               count_i,         // .. in the next cycle
    // to the memories of the core, idle only; the address and data are those of the bus
    output logic                                      write_constant_o,
    output logic                                      write_safe_o,
    output logic                                      write_register_o,
    output logic                                      write_data_o,
    output logic                                      write_program_o,
    output logic                                      write_record_o,  // of plausibility
    output logic                                      write_stream_o,
    output logic [15:0]                               stream_address_o,  // {pipe, word}
    output logic [1:0]                                stream_lane_o,
    output logic                                      select_o,
    input  logic [31:0]                               read_output_i,
    input  logic [31:0]                               read_register_i,
    input  logic [31:0]                               read_data_i
);

  localparam int unsigned Width = asip_regmap_pkg::ADDRESS_WIDTH;
  localparam int unsigned CsrBits = $clog2(asip_regmap_pkg::WORDS_CSR);
  localparam int unsigned Groups = asip_regmap_pkg::WORDS_CSR / 4;

  // Blocks are aligned powers of two.
  function automatic logic in_block(input logic [Width-1:0] address, input int unsigned base, input int unsigned words);
    in_block = (32'(address) & ~(words - 1)) == base;
  endfunction

  logic in_csr, in_constants, in_outputs, in_safe, in_registers, in_data, in_program;
  logic in_record, in_streams;
  logic [7:0] stream_page;
  logic in_banks;
  logic held, memory_write, bank_write, csr_write, configures;
  logic [CsrBits-1:0] csr;
  logic [$clog2(asip_regmap_pkg::WORDS_PROGRAM)-3:0] bundle;
  logic [2:0] wait_q;
  logic read_done, refetch_q;
  logic settle_q;  // a word is on its way into a bank
  logic in_counts;
  logic [asip_regmap_pkg::WORDS_CSR-1:0][31:0] word;  // registers but the counters
  logic [Groups-1:0][31:0] group_q;
  logic [Groups:0][31:0] groups;  // ORed from the first on
  logic [31:0] count_q, readdata_q, watchdog_q, output_mask_q;
  logic [15:0] entry_q;
  logic [31:0] config_word, status_word, info_word, irq_word, entry_word, stream_word;
  logic irq_done_q, irq_fault_q;

  assign in_csr       = in_block(address_i, asip_regmap_pkg::BASE_CSR,
                                 asip_regmap_pkg::WORDS_CSR);
  assign in_constants = in_block(address_i, asip_regmap_pkg::BASE_CONSTANTS,
                                 asip_regmap_pkg::WORDS_CONSTANTS);
  assign in_outputs   = in_block(address_i, asip_regmap_pkg::BASE_OUTPUTS,
                                 asip_regmap_pkg::WORDS_OUTPUTS);
  assign in_safe      = in_block(address_i, asip_regmap_pkg::BASE_SAFE,
                                 asip_regmap_pkg::WORDS_SAFE);
  assign in_registers = in_block(address_i, asip_regmap_pkg::BASE_REGISTERS,
                                 asip_regmap_pkg::WORDS_REGISTERS);
  assign in_data      = in_block(address_i, asip_regmap_pkg::BASE_DATA,
                                 asip_regmap_pkg::WORDS_DATA);
  assign in_program   = in_block(address_i, asip_regmap_pkg::BASE_PROGRAM,
                                 asip_regmap_pkg::WORDS_PROGRAM);
  assign in_record    = |{in_block(address_i, asip_regmap_pkg::BASE_PLAUSIBLE_LEAST,
                                   asip_regmap_pkg::WORDS_PLAUSIBLE_LEAST),
                          in_block(address_i, asip_regmap_pkg::BASE_PLAUSIBLE_MOST,
                                   asip_regmap_pkg::WORDS_PLAUSIBLE_MOST),
                          in_block(address_i, asip_regmap_pkg::BASE_PLAUSIBLE_SLEW,
                                   asip_regmap_pkg::WORDS_PLAUSIBLE_SLEW),
                          in_block(address_i, asip_regmap_pkg::BASE_PLAUSIBLE_ON,
                                   asip_regmap_pkg::WORDS_PLAUSIBLE_ON)};
  assign in_streams   = in_block(address_i, asip_regmap_pkg::BASE_STREAMS,
                                 asip_regmap_pkg::WORDS_STREAMS);
  assign in_banks     = in_registers || (Debug != 0 && in_constants);
  assign csr          = address_i[CsrBits-1:0];
  assign bundle       = address_i[$clog2(asip_regmap_pkg::WORDS_PROGRAM)-1:2];

  // A run must not be disturbed: everything but control, status and interrupt enable waits.
  assign configures = csr == asip_regmap_pkg::REG_WATCHDOG || csr == asip_regmap_pkg::REG_ENTRY ||
                      csr == asip_regmap_pkg::REG_OUTPUT_MASK;
  assign held       = (hold_i && (in_csr ? write_i && configures : 1'b1)) || (copy_i && in_banks);
  assign csr_write    = write_i && in_csr && !(hold_i && configures);
  assign memory_write = write_i && !hold_i;
  assign bank_write   = memory_write && !copy_i;
  assign read_done  = wait_q == 3'd4;
  assign waitrequest_o = (write_i && held) || (read_i && !read_done);

  assign start_o   = csr_write && csr == asip_regmap_pkg::REG_CONTROL &&
                     writedata_i[asip_regmap_pkg::CONTROL_START_LSB];
  assign clear_o   = csr_write && csr == asip_regmap_pkg::REG_CONTROL &&
                     writedata_i[asip_regmap_pkg::CONTROL_CLEAR_LSB];
  assign refetch_o = refetch_q;

  assign write_constant_o = (Debug != 0 ? bank_write : memory_write) && in_constants;
  assign write_safe_o     = memory_write && in_safe;
  assign write_register_o = bank_write && in_registers;
  assign write_data_o     = memory_write && in_data;
  assign write_program_o  = memory_write && in_program && 32'(bundle) < Bundles;
  assign write_record_o   = memory_write && in_record && Resilience != 0 && Plausible != 0;
  assign write_stream_o   = memory_write && in_streams && StreamWords != 0 && 32'(stream_page[7:6]) < Lanes + 1;
  assign stream_lane_o    = stream_page[7:6];
  assign stream_address_o = {stream_page[5:0], address_i[$clog2(asip_regmap_pkg::WORDS_STREAMS)-1:0]};
  assign select_o         = (read_i || write_i) && !hold_i;

  always_comb begin
    config_word = 32'd0;
    config_word[asip_regmap_pkg::CONFIG_SLOTS_LSB+:4]        = 4'(Slots);
    config_word[asip_regmap_pkg::CONFIG_FMA_PIPES_LSB+:4]    = 4'(FmaPipes);
    config_word[asip_regmap_pkg::CONFIG_BANK_SIZE_LSB+:8]    = 8'(asip_isa_pkg::BANK_SIZE);
    config_word[asip_regmap_pkg::CONFIG_PROGRAM_LOG2_LSB+:8] = 8'($clog2(Bundles));
    config_word[asip_regmap_pkg::CONFIG_DATA_LOG2_LSB+:6]    = 6'($clog2(DataWords));
    config_word[asip_regmap_pkg::CONFIG_PLAUSIBLE_LSB]       = Resilience != 0 && Plausible != 0;
    config_word[asip_regmap_pkg::CONFIG_RESILIENCE_LSB]      = Resilience != 0;

    status_word = 32'd0;
    status_word[asip_regmap_pkg::STATUS_BUSY_LSB]     = busy_i;
    status_word[asip_regmap_pkg::STATUS_DONE_LSB]     = done_i;
    status_word[asip_regmap_pkg::STATUS_FAULT_LSB]    = fault_i;
    status_word[asip_regmap_pkg::STATUS_REPAIRED_LSB] = repaired_i;
    status_word[asip_regmap_pkg::STATUS_CAUSE_LSB+:4] = cause_i;
    status_word[asip_regmap_pkg::STATUS_FLAGS_LSB+:5] = flags_i;

    irq_word = 32'd0;
    irq_word[asip_regmap_pkg::IRQ_ENABLE_DONE_LSB]  = irq_done_q;
    irq_word[asip_regmap_pkg::IRQ_ENABLE_FAULT_LSB] = irq_fault_q;

    info_word = 32'd0;
    info_word[asip_regmap_pkg::FAULT_INFO_VALUE_LSB+:16] = fault_info_i;
    entry_word = 32'd0;
    entry_word[asip_regmap_pkg::ENTRY_VALUE_LSB+:16] = entry_q;

    stream_word = 32'd0;
    if (Lanes != 0) stream_word[asip_regmap_pkg::STREAM_LANES_LSB+:2] = 2'(Lanes);
    if (Loops != 0) stream_word[asip_regmap_pkg::STREAM_LOOPS_LSB+:2] = 2'(Loops);
    if (StreamWords != 0) begin
      stream_word[asip_regmap_pkg::STREAM_PAGE_LSB+:8]       = stream_page;
      stream_word[asip_regmap_pkg::STREAM_WORDS_LOG2_LSB+:5] = 5'($clog2(StreamWords));
    end

    word                                     = '0;
    word[asip_regmap_pkg::REG_ID]            = asip_regmap_pkg::RESET_ID;
    word[asip_regmap_pkg::REG_CONFIG]        = config_word;
    word[asip_regmap_pkg::REG_STATUS]        = status_word;
    word[asip_regmap_pkg::REG_CYCLES]        = cycles_i;
    word[asip_regmap_pkg::REG_FAULT_INFO]    = info_word;
    word[asip_regmap_pkg::REG_IRQ_ENABLE]    = irq_word;
    word[asip_regmap_pkg::REG_WATCHDOG]      = watchdog_q;
    word[asip_regmap_pkg::REG_ENTRY]         = entry_word;
    word[asip_regmap_pkg::REG_OUTPUT_MASK]   = output_mask_q;
    word[asip_regmap_pkg::REG_STREAM]        = stream_word;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      wait_q        <= 3'd0;
      refetch_q     <= 1'b0;
      settle_q      <= 1'b0;
      irq_done_q    <= 1'b0;
      irq_fault_q   <= 1'b0;
      watchdog_q    <= asip_regmap_pkg::RESET_WATCHDOG;
      entry_q       <= 16'd0;
      output_mask_q <= 32'd0;
    end else begin
      refetch_q <= (csr_write && csr == asip_regmap_pkg::REG_ENTRY) || write_program_o;
      settle_q <= Slots > 1 && Resilience == 0 && (write_constant_o || write_register_o);
      wait_q <= (read_i && !held && !read_done && !settle_q) ? wait_q + 3'd1 : 3'd0;
      if (csr_write && csr == asip_regmap_pkg::REG_IRQ_ENABLE) begin
        irq_done_q  <= writedata_i[asip_regmap_pkg::IRQ_ENABLE_DONE_LSB];
        irq_fault_q <= writedata_i[asip_regmap_pkg::IRQ_ENABLE_FAULT_LSB];
      end
      if (csr_write && csr == asip_regmap_pkg::REG_WATCHDOG) watchdog_q <= writedata_i;
      if (csr_write && csr == asip_regmap_pkg::REG_ENTRY) entry_q <= writedata_i[asip_regmap_pkg::ENTRY_VALUE_LSB+:16];
      if (csr_write && csr == asip_regmap_pkg::REG_OUTPUT_MASK) output_mask_q <= writedata_i;
    end
  end

  genvar g;
  generate
    if (StreamWords != 0) begin : gen_streams
      logic [7:0] page_q;
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) page_q <= 8'd0;
        else if (csr_write && csr == asip_regmap_pkg::REG_STREAM)
          page_q <= writedata_i[asip_regmap_pkg::STREAM_PAGE_LSB+:8];
      end
      assign stream_page = page_q;
    end else begin : gen_no_streams
      assign stream_page = 8'd0;
    end

    if (Resilience != 0) begin : gen_parity
      // A wrong bit is seen for one clock; the register keeps its word until the host writes it.
      logic [3:0] written, parity, parity_d, parity_q;
      assign written = {
      csr_write && csr == asip_regmap_pkg::REG_WATCHDOG,
      csr_write && csr == asip_regmap_pkg::REG_ENTRY,
      csr_write && csr == asip_regmap_pkg::REG_OUTPUT_MASK,
      csr_write && csr == asip_regmap_pkg::REG_IRQ_ENABLE
    };
      assign parity   = {^watchdog_q, ^entry_q, ^output_mask_q, irq_done_q ^ irq_fault_q};
      assign parity_d = {
      ^writedata_i,
      ^writedata_i[asip_regmap_pkg::ENTRY_VALUE_LSB+:16],
      ^writedata_i,
      writedata_i[asip_regmap_pkg::IRQ_ENABLE_DONE_LSB]
        ^ writedata_i[asip_regmap_pkg::IRQ_ENABLE_FAULT_LSB]
    };
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) parity_q <= {^asip_regmap_pkg::RESET_WATCHDOG, 3'b000};
        else parity_q <= (written & parity_d) | (~written & parity);
      end
      assign broken_o = parity_q != parity;

      // An output is checked as the host takes it, after every register of its way.
      logic output_parity_q;
      always_ff @(posedge clk_i) output_parity_q <= output_parity_i;
      assign bad_output_o = read_i && read_done && in_outputs && ((^readdata_q) != output_parity_q);
    end else begin : gen_no_parity
      logic unused_parity;
      assign broken_o      = 1'b0;
      assign bad_output_o  = 1'b0;
      assign unused_parity = output_parity_i;
    end

    // Registers are selected in groups of four, and a group that is not read is zero.
    for (g = 0; g < Groups; g++) begin : gen_group
      always_ff @(posedge clk_i) begin
        group_q[g] <= in_csr && csr[CsrBits-1:2] == (CsrBits - 2)'(g) ? word[{(CsrBits-2)'(g), csr[1:0]}] : 32'd0;
      end
      assign groups[g+1] = groups[g] | group_q[g];
    end
  endgenerate
  assign groups[0] = 32'd0;

  assign in_counts = csr == asip_regmap_pkg::REG_STALL_OPERAND ||
                     csr == asip_regmap_pkg::REG_STALL_PORT ||
                     csr == asip_regmap_pkg::REG_STALL_UNIT ||
                     csr == asip_regmap_pkg::REG_STALL_FETCH || csr == asip_regmap_pkg::REG_DRAIN;

  // The memories answer within three cycles of the address being stable.
  always_ff @(posedge clk_i) begin
    count_q    <= in_csr && in_counts ? count_i : 32'd0;
    readdata_q <= groups[Groups] | count_q |
                  ({32{in_outputs}} & read_output_i) | ({32{in_banks}} & read_register_i) |
                  ({32{in_data}} & read_data_i);
  end

  assign count_select_o = csr[2:0];
  assign readdata_o    = readdata_q;
  assign irq_o         = (done_i && irq_done_q) || (fault_i && irq_fault_q);
  assign watchdog_o    = watchdog_q;
  assign entry_o       = entry_q;
  assign output_mask_o = output_mask_q;

endmodule
