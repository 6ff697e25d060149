// SPDX-License-Identifier: Apache-2.0
// dual_host: Avalon-MM agent of the two-processor system and its registers (map: docs/dual_regmap.md).
// Contract: word addresses, 32-bit words only. Registers and lists: writes take one cycle, reads two. An
// address inside a core's block goes on to that core.
module dual_host #(
    parameter int unsigned Words    = 15,
    parameter int unsigned Measured = 5,
    parameter int unsigned Commands = 5
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    // Avalon-MM
    input  logic [dual_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic        read_i,
    input  logic        write_i,
    input  logic [31:0] writedata_i,
    output logic [31:0] readdata_o,
    output logic        waitrequest_o,
    output logic        irq_o,
    // to the cores: address and data are those of the bus
    output logic [1:0]  core_read_o,
    output logic [1:0]  core_write_o,
    input  logic [1:0]  core_wait_i,
    input  logic [63:0] core_data_i,
    // to the sequencer
    output logic        run_o,
    output logic        clear_o,
    output logic [15:0] period_o,
    output logic        list_write_o,
    output logic [5:0]  set_points_o,
    output logic [5:0]  inputs_o,
    output logic [5:0]  commands_o,
    output logic [31:0] zero_on_hold_o,
    // state
    input  logic        cleared_i,
    input  logic        active_i,
    input  logic        valid_i,
    input  logic        hold_i,
    input  logic        underrun_i,       // pulses
    input  logic [1:0]  overrun_i,
    input  logic [1:0]  fault_i,
    input  logic [31:0] periods_i,
    input  logic [31:0] overruns_i,
    input  logic [63:0] core_last_i,
    input  logic [63:0] core_min_i,
    input  logic [63:0] core_max_i,
    input  logic [15:0] command_last_i,
    input  logic [15:0] command_max_i,
    input  logic [15:0] copy_last_i,
    input  logic [15:0] copy_max_i,
    input  logic [15:0] used_last_i,
    input  logic [15:0] used_max_i,
    input  logic [31:0] left_min_i
);

  logic [4:0] index;
  logic in_first, in_second, in_core, in_csr, in_lists, csr_write, read_q, run_q;
  logic [15:0] period_q;
  logic [5:0] set_points_q, inputs_q, commands_q;
  logic [31:0] zero_on_hold_q, underruns_q, read_data, readdata_q;
  logic [1:0] irq_enable_q, overrun_q;
  logic underrun_q;

  // Blocks are aligned powers of two.
  function automatic logic in_block(input logic [dual_regmap_pkg::ADDRESS_WIDTH-1:0] address, input int unsigned base,
                                    input int unsigned words);
    in_block = (32'(address) & ~(words - 1)) == base;
  endfunction

  assign index     = address_i[$clog2(dual_regmap_pkg::WORDS_CSR)-1:0];
  assign in_first  = in_block(address_i, dual_regmap_pkg::BASE_TRAJECTORY,
                              dual_regmap_pkg::WORDS_TRAJECTORY);
  assign in_second = in_block(address_i, dual_regmap_pkg::BASE_TRACKING,
                              dual_regmap_pkg::WORDS_TRACKING);
  assign in_core   = in_first || in_second;
  assign in_csr    = in_block(address_i, dual_regmap_pkg::BASE_CSR, dual_regmap_pkg::WORDS_CSR);
  assign in_lists  = in_block(address_i, dual_regmap_pkg::BASE_LISTS,
                              dual_regmap_pkg::WORDS_LISTS);
  assign csr_write = write_i && in_csr;

  assign core_read_o   = read_i ? {in_second, in_first} : 2'd0;
  assign core_write_o  = write_i ? {in_second, in_first} : 2'd0;
  assign readdata_o    = in_core ? core_data_i[32*in_second+:32] : readdata_q;
  assign waitrequest_o = in_core ? (core_wait_i[in_second] && (read_i || write_i))
                                 : (read_i && !read_q);
  assign list_write_o  = write_i && in_lists;
  assign clear_o       = csr_write && index == dual_regmap_pkg::REG_CONTROL
                         && writedata_i[dual_regmap_pkg::CONTROL_CLEAR_LSB];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      read_q         <= 1'b0;
      run_q          <= 1'b0;
      period_q       <= dual_regmap_pkg::RESET_PERIOD[dual_regmap_pkg::PERIOD_VALUE_LSB+:16];
      set_points_q   <= 6'd0;
      inputs_q       <= 6'd0;
      commands_q     <= 6'd0;
      zero_on_hold_q <= 32'd0;
      irq_enable_q   <= 2'd0;
      underrun_q     <= 1'b0;
      overrun_q      <= 2'd0;
      underruns_q    <= 32'd0;
    end else begin
      read_q <= read_i && !in_core && !read_q;
      if (csr_write) begin
        case (index)
          dual_regmap_pkg::REG_CONTROL: run_q <= writedata_i[dual_regmap_pkg::CONTROL_RUN_LSB];
          dual_regmap_pkg::REG_PERIOD: period_q <= writedata_i[dual_regmap_pkg::PERIOD_VALUE_LSB+:16];
          dual_regmap_pkg::REG_LENGTHS: begin
            set_points_q <= writedata_i[dual_regmap_pkg::LENGTHS_SET_POINTS_LSB+:6];
            inputs_q     <= writedata_i[dual_regmap_pkg::LENGTHS_INPUTS_LSB+:6];
            commands_q   <= writedata_i[dual_regmap_pkg::LENGTHS_COMMANDS_LSB+:6];
          end
          dual_regmap_pkg::REG_ZERO_ON_HOLD: zero_on_hold_q <= writedata_i;
          dual_regmap_pkg::REG_IRQ_ENABLE: begin
            irq_enable_q[0] <= writedata_i[dual_regmap_pkg::IRQ_ENABLE_STOP_LSB];
            irq_enable_q[1] <= writedata_i[dual_regmap_pkg::IRQ_ENABLE_LATE_LSB];
          end
          default: ;
        endcase
      end
      if (cleared_i) begin
        underrun_q  <= 1'b0;
        overrun_q   <= 2'd0;
        underruns_q <= 32'd0;
      end else begin
        underrun_q <= underrun_q || underrun_i;
        overrun_q  <= overrun_q | overrun_i;
        if (underrun_i) underruns_q <= underruns_q + 32'd1;
      end
    end
  end

  always_comb begin
    read_data = 32'd0;
    if (in_csr) begin
      case (index)
        dual_regmap_pkg::REG_ID: read_data = dual_regmap_pkg::RESET_ID;
        dual_regmap_pkg::REG_CONFIG: begin
          read_data[dual_regmap_pkg::CONFIG_WORDS_LSB+:8]    = 8'(Words);
          read_data[dual_regmap_pkg::CONFIG_MEASURED_LSB+:8] = 8'(Measured);
          read_data[dual_regmap_pkg::CONFIG_COMMANDS_LSB+:8] = 8'(Commands);
        end
        dual_regmap_pkg::REG_CONTROL: read_data[dual_regmap_pkg::CONTROL_RUN_LSB] = run_q;
        dual_regmap_pkg::REG_STATUS: begin
          read_data[dual_regmap_pkg::STATUS_ACTIVE_LSB]             = active_i;
          read_data[dual_regmap_pkg::STATUS_VALID_LSB]              = valid_i;
          read_data[dual_regmap_pkg::STATUS_HOLD_LSB]               = hold_i;
          read_data[dual_regmap_pkg::STATUS_STOP_LSB]               = fault_i != 2'd0;
          read_data[dual_regmap_pkg::STATUS_UNDERRUN_LSB]           = underrun_q;
          read_data[dual_regmap_pkg::STATUS_TRAJECTORY_OVERRUN_LSB] = overrun_q[0];
          read_data[dual_regmap_pkg::STATUS_TRACKING_OVERRUN_LSB]   = overrun_q[1];
          read_data[dual_regmap_pkg::STATUS_TRAJECTORY_FAULT_LSB]   = fault_i[0];
          read_data[dual_regmap_pkg::STATUS_TRACKING_FAULT_LSB]     = fault_i[1];
        end
        dual_regmap_pkg::REG_PERIOD: read_data[dual_regmap_pkg::PERIOD_VALUE_LSB+:16] = period_q;
        dual_regmap_pkg::REG_LENGTHS: begin
          read_data[dual_regmap_pkg::LENGTHS_SET_POINTS_LSB+:6] = set_points_q;
          read_data[dual_regmap_pkg::LENGTHS_INPUTS_LSB+:6]     = inputs_q;
          read_data[dual_regmap_pkg::LENGTHS_COMMANDS_LSB+:6]   = commands_q;
        end
        dual_regmap_pkg::REG_ZERO_ON_HOLD: read_data = zero_on_hold_q;
        dual_regmap_pkg::REG_IRQ_ENABLE: begin
          read_data[dual_regmap_pkg::IRQ_ENABLE_STOP_LSB] = irq_enable_q[0];
          read_data[dual_regmap_pkg::IRQ_ENABLE_LATE_LSB] = irq_enable_q[1];
        end
        dual_regmap_pkg::REG_PERIODS: read_data = periods_i;
        dual_regmap_pkg::REG_UNDERRUNS: read_data = underruns_q;
        dual_regmap_pkg::REG_OVERRUNS: read_data = overruns_i;
        dual_regmap_pkg::REG_TRAJECTORY_LAST: read_data = core_last_i[31:0];
        dual_regmap_pkg::REG_TRAJECTORY_MIN: read_data = core_min_i[31:0];
        dual_regmap_pkg::REG_TRAJECTORY_MAX: read_data = core_max_i[31:0];
        dual_regmap_pkg::REG_TRACKING_LAST: read_data = core_last_i[63:32];
        dual_regmap_pkg::REG_TRACKING_MIN: read_data = core_min_i[63:32];
        dual_regmap_pkg::REG_TRACKING_MAX: read_data = core_max_i[63:32];
        dual_regmap_pkg::REG_COMMAND_LAST:
        read_data[dual_regmap_pkg::COMMAND_LAST_VALUE_LSB+:16] = command_last_i;
        dual_regmap_pkg::REG_COMMAND_MAX:
        read_data[dual_regmap_pkg::COMMAND_MAX_VALUE_LSB+:16] = command_max_i;
        dual_regmap_pkg::REG_COPY_LAST:
        read_data[dual_regmap_pkg::COPY_LAST_VALUE_LSB+:16] = copy_last_i;
        dual_regmap_pkg::REG_COPY_MAX:
        read_data[dual_regmap_pkg::COPY_MAX_VALUE_LSB+:16] = copy_max_i;
        dual_regmap_pkg::REG_USED_LAST:
        read_data[dual_regmap_pkg::USED_LAST_VALUE_LSB+:16] = used_last_i;
        dual_regmap_pkg::REG_USED_MAX:
        read_data[dual_regmap_pkg::USED_MAX_VALUE_LSB+:16] = used_max_i;
        dual_regmap_pkg::REG_LEFT_MIN: read_data = left_min_i;
        default: ;
      endcase
    end
  end

  always_ff @(posedge clk_i) readdata_q <= read_data;

  assign run_o          = run_q;
  assign period_o       = period_q;
  assign set_points_o   = set_points_q;
  assign inputs_o       = inputs_q;
  assign commands_o     = commands_q;
  assign zero_on_hold_o = zero_on_hold_q;
  assign irq_o = (irq_enable_q[0] && fault_i != 2'd0)
                 || (irq_enable_q[1] && (underrun_q || overrun_q != 2'd0));

endmodule
