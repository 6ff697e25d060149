// SPDX-License-Identifier: Apache-2.0
// n2_debug: debug module of n2_core: halts it, executes single instructions of a host in it, compares
// addresses of instructions and data. Registers: rtl/nios/debug_regmap.rdl.
// Contract: the core halts by its break exception: `ba` - 4 is the address of the next instruction,
// `bstatus` the program's status. Halted, it fetches nothing of its own; an instruction of the host has
// left the pipeline seven clocks (of a pipeline that moves) later. `bret` lets the program go on. A
// watchpoint halts after the access, all else before the instruction.
module n2_debug (
    input  logic                    clk_i,
    input  logic                    rst_ni,             // of the registers
    input  logic                    core_rst_ni,
    // host: Avalon-MM agent
    input  logic [4:0]              avs_address_i,      // words
    input  logic                    avs_read_i,
    input  logic                    avs_write_i,
    input  logic [31:0]             avs_writedata_i,
    output logic [31:0]             avs_readdata_o,
    output logic                    avs_waitrequest_o,
    // to the system
    output logic                    halted_o,
    output logic                    freeze_o,           // timers hold
    // to and from n2_core
    output n2_pkg::debug_state_t    state_o,
    output logic                    break_d_o,          // a break instead of the instruction in D
    output logic                    watch_e_o,          // the access in E is watched
    input  n2_pkg::debug_address_t  address_i,
    input  n2_pkg::debug_event_t    event_i
);

  localparam int unsigned Breakpoints = 4;
  localparam int unsigned Watchpoints = 4;

  logic enable_q, freeze_q, mask_q, pending_q;
  logic halted_q, first_q;  // first_q: no instruction has been issued since bret
  logic [2:0] count_q;  // clocks until the host's instruction has left the pipeline
  logic [31:0] word_q, data_q, rdata_d, rdata_q;
  logic [Watchpoints-1:0] hits_e, hits_q;
  logic read_q, waits, write, halt;

  // ------------------------------------------------------------------ host
  assign waits = count_q != 3'd0 && (avs_address_i == n2_debug_regmap_pkg::REG_DATA ||
                                     avs_address_i == n2_debug_regmap_pkg::REG_INSTRUCTION);
  assign write = avs_write_i && !waits;
  assign halt  = write && avs_address_i == n2_debug_regmap_pkg::REG_HALT &&
                 avs_writedata_i[n2_debug_regmap_pkg::HALT_NOW_LSB];
  assign avs_waitrequest_o = waits ? avs_read_i || avs_write_i : avs_read_i && !read_q;
  assign avs_readdata_o    = rdata_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) read_q <= 1'b0;
    else read_q <= avs_read_i && !waits && !read_q;
  end

  always_comb begin
    rdata_d = 32'd0;
    case (avs_address_i)
      n2_debug_regmap_pkg::REG_ID:     rdata_d = n2_debug_regmap_pkg::RESET_ID;
      n2_debug_regmap_pkg::REG_CONFIG: rdata_d = n2_debug_regmap_pkg::RESET_CONFIG;
      n2_debug_regmap_pkg::REG_CONTROL: begin
        rdata_d[n2_debug_regmap_pkg::CONTROL_ENABLE_LSB] = enable_q;
        rdata_d[n2_debug_regmap_pkg::CONTROL_FREEZE_LSB] = freeze_q;
        rdata_d[n2_debug_regmap_pkg::CONTROL_MASK_INTERRUPTS_LSB] = mask_q;
      end
      n2_debug_regmap_pkg::REG_STATUS: begin
        rdata_d[n2_debug_regmap_pkg::STATUS_HALTED_LSB]  = halted_q;
        rdata_d[n2_debug_regmap_pkg::STATUS_BUSY_LSB]    = count_q != 3'd0;
        rdata_d[n2_debug_regmap_pkg::STATUS_PENDING_LSB] = pending_q;
        rdata_d[n2_debug_regmap_pkg::STATUS_WATCH_HITS_LSB+:Watchpoints] = hits_q;
      end
      n2_debug_regmap_pkg::REG_DATA:   rdata_d = data_q;
      default: ;
    endcase
  end

  always_ff @(posedge clk_i) begin
    rdata_q <= rdata_d;
    if (write && avs_address_i == n2_debug_regmap_pkg::REG_DATA) data_q <= avs_writedata_i;
    else if (event_i.write_m && halted_q) data_q <= event_i.value_m;
    if (write && avs_address_i == n2_debug_regmap_pkg::REG_INSTRUCTION) word_q <= avs_writedata_i;
  end

  // ------------------------------------------------------------------ run control
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      enable_q  <= 1'b0;
      freeze_q  <= 1'b0;
      mask_q    <= 1'b0;
      pending_q <= 1'b0;
      hits_q    <= '0;
    end else begin
      if (write && avs_address_i == n2_debug_regmap_pkg::REG_CONTROL) begin
        enable_q <= avs_writedata_i[n2_debug_regmap_pkg::CONTROL_ENABLE_LSB];
        freeze_q <= avs_writedata_i[n2_debug_regmap_pkg::CONTROL_FREEZE_LSB];
        mask_q   <= avs_writedata_i[n2_debug_regmap_pkg::CONTROL_MASK_INTERRUPTS_LSB];
      end
      if (halt) pending_q <= 1'b1;
      else if (event_i.break_m && enable_q) pending_q <= 1'b0;
      else if (watch_e_o && event_i.en) pending_q <= 1'b1;
      if (event_i.return_m && halted_q) hits_q <= '0;
      else if (watch_e_o && event_i.en) hits_q <= hits_q | hits_e;
    end
  end

  always_ff @(posedge clk_i or negedge core_rst_ni) begin
    if (!core_rst_ni) begin
      halted_q <= 1'b0;
      first_q  <= 1'b0;
      count_q  <= 3'd0;
    end else begin
      if (event_i.break_m && enable_q) halted_q <= 1'b1;
      else if (event_i.return_m) halted_q <= 1'b0;
      if (event_i.return_m && halted_q) first_q <= 1'b1;
      else if (event_i.issue_d) first_q <= 1'b0;
      if (write && halted_q && avs_address_i == n2_debug_regmap_pkg::REG_INSTRUCTION) count_q <= 3'd7;
      else if (count_q != 3'd0 && event_i.en) count_q <= count_q - 3'd1;
    end
  end

  // The word goes to D through the register after the instruction memory, which holds it two clocks
  // later; then it is valid for one clock, and in A when the count ends.
  assign state_o.halted = halted_q;
  assign state_o.word   = word_q;
  assign state_o.valid  = count_q == 3'd4;
  assign state_o.data   = data_q;
  assign state_o.mask   = mask_q && pending_q && first_q;
  assign halted_o       = halted_q;
  assign freeze_o       = freeze_q && halted_q;

  // ------------------------------------------------------------------ comparators
  logic [Breakpoints-1:0] stops_d;
  genvar i;
  generate
    for (i = 0; i < Breakpoints; i++) begin : gen_breakpoint
      localparam logic [4:0] Register = n2_debug_regmap_pkg::REG_BREAKPOINT + 5'(i);
      logic on_q;
      logic [29:0] next_q;  // word address after the instruction
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) on_q <= 1'b0;
        else if (write && avs_address_i == Register)
          on_q <= avs_writedata_i[n2_debug_regmap_pkg::BREAKPOINT_ENABLE_LSB];
      end
      always_ff @(posedge clk_i) begin
        if (write && avs_address_i == Register)
          next_q <= avs_writedata_i[n2_debug_regmap_pkg::BREAKPOINT_ADDRESS_LSB+:30] + 30'd1;
      end
      assign stops_d[i] = on_q && next_q == address_i.next_d;
    end

    for (i = 0; i < Watchpoints; i++) begin : gen_watchpoint
      localparam logic [4:0] Address = n2_debug_regmap_pkg::REG_WATCH_ADDRESS + 5'(i);
      localparam logic [4:0] Mask = n2_debug_regmap_pkg::REG_WATCH_MASK + 5'(i);
      localparam logic [4:0] Control = n2_debug_regmap_pkg::REG_WATCH_CONTROL + 5'(i);
      logic on_read_q, on_write_q;
      logic [3:0] lanes_q;
      logic [29:0] address_q, ignored_q;
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) begin
          on_read_q  <= 1'b0;
          on_write_q <= 1'b0;
        end else if (write && avs_address_i == Control) begin
          on_read_q  <= avs_writedata_i[n2_debug_regmap_pkg::WATCH_CONTROL_READ_LSB];
          on_write_q <= avs_writedata_i[n2_debug_regmap_pkg::WATCH_CONTROL_WRITE_LSB];
        end
      end
      always_ff @(posedge clk_i) begin
        if (write && avs_address_i == Control)
          lanes_q <= avs_writedata_i[n2_debug_regmap_pkg::WATCH_CONTROL_LANES_LSB+:4];
        if (write && avs_address_i == Address)
          address_q <= avs_writedata_i[n2_debug_regmap_pkg::WATCH_ADDRESS_ADDRESS_LSB+:30];
        if (write && avs_address_i == Mask)
          ignored_q <= avs_writedata_i[n2_debug_regmap_pkg::WATCH_MASK_IGNORED_LSB+:30];
      end
      assign hits_e[i] = enable_q && !halted_q && address_i.access_e &&
                       (address_i.store_e ? on_write_q : on_read_q) &&
                       (address_i.lanes_e & lanes_q) != 4'd0 &&
                       ((address_i.data_e ^ address_q) & ~ignored_q) == 30'd0;
    end
  endgenerate

  assign break_d_o = enable_q && !halted_q && !first_q && (pending_q || stops_d != '0);
  assign watch_e_o = hits_e != '0;

endmodule
