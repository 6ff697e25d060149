// SPDX-License-Identifier: Apache-2.0
// debug_registers: agent on the bus for the registers, the stage and the ring (docs/debug_regmap.md).
// Contract: writes take one cycle, reads two. A register that can be written reads as it was written last,
// its reset value before. The ring's read port belongs to the bus in the cycles of ring_read_o.
module debug_registers #(
    parameter int unsigned StageLog2 = 6,
    parameter int unsigned RingLog2  = 12,
    parameter int unsigned Uart      = 1,
    parameter logic [31:0] ResetUart = debug_regmap_pkg::RESET_UART
) (
    input  logic                clk_i,
    input  logic                rst_ni,
    // agent
    input  logic [debug_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic                read_i,
    input  logic                write_i,
    input  logic [31:0]         writedata_i,
    output logic [31:0]         readdata_o,
    output logic                waitrequest_o,
    // writes
    output logic                csr_write_o,
    output logic [5:0]          csr_index_o,
    output logic                stage_write_o,
    // the ring
    output logic                ring_read_o,
    input  logic [31:0]         ring_data_i,
    // from the parts of the block
    input  logic                ended_i,
    input  logic [31:0]         status_i,
    input  logic [31:0]         place_i,
    input  logic [7:0]          staged_i,
    input  logic [31:0]         version_i,
    input  logic [31:0]         records_i,
    input  logic [31:0]         triggered_at_i,
    input  logic [31:0]         uart_errors_i,
    output logic [31:0]         runs_o
);

  localparam int unsigned Width = debug_regmap_pkg::ADDRESS_WIDTH;
  localparam int unsigned Registers = debug_regmap_pkg::WORDS_CSR;

  function automatic logic in_block(input logic [Width-1:0] address, input int unsigned base,
                                    input int unsigned words);
    in_block = (32'(address) & ~(words - 1)) == base;
  endfunction

  // Numbers of the words that are not kept.
  localparam logic [2:0] LiveFixed = 3'd0;
  localparam logic [2:0] LiveStatus = 3'd1;
  localparam logic [2:0] LivePlace = 3'd2;
  localparam logic [2:0] LiveRuns = 3'd3;
  localparam logic [2:0] LiveVersion = 3'd4;
  localparam logic [2:0] LiveRecords = 3'd5;
  localparam logic [2:0] LiveTriggeredAt = 3'd6;
  localparam logic [2:0] LiveUartErrors = 3'd7;

  // Registers that keep what is written.
  function automatic logic kept_at(input int unsigned index);
    case (6'(index))
      debug_regmap_pkg::REG_ID, debug_regmap_pkg::REG_CONFIG, debug_regmap_pkg::REG_CONTROL,
      debug_regmap_pkg::REG_STATUS, debug_regmap_pkg::REG_PLACE, debug_regmap_pkg::REG_RUNS,
      debug_regmap_pkg::REG_STAGED, debug_regmap_pkg::REG_VERSION, debug_regmap_pkg::REG_RECORDS,
      debug_regmap_pkg::REG_TRIGGERED_AT, debug_regmap_pkg::REG_UART_ERRORS: kept_at = 1'b0;
      default: kept_at = index < 32'(debug_regmap_pkg::REG_CHANNEL) + 32'd8;
    endcase
  endfunction

  logic                 in_csr, done_q, ring_q;
  logic [31:0]          config_word, fixed_word, live_word, kept_word, kept, read_q, runs_q;
  logic                 is_live;
  logic [2:0]           live;
  logic [Registers-1:0] written_q;
  logic [31:0]          memory[0:Registers-1];

  assign in_csr        = in_block(address_i, debug_regmap_pkg::BASE_CSR,
                                  debug_regmap_pkg::WORDS_CSR);
  assign csr_index_o   = address_i[$clog2(Registers)-1:0];
  assign csr_write_o   = write_i && in_csr;
  assign stage_write_o = write_i && in_block(address_i, debug_regmap_pkg::BASE_STAGE,
                                             debug_regmap_pkg::WORDS_STAGE);
  assign ring_read_o   = read_i && in_block(address_i, debug_regmap_pkg::BASE_RING,
                                            debug_regmap_pkg::WORDS_RING);
  assign waitrequest_o = read_i && !done_q;

  always_comb begin
    config_word = 32'd0;
    config_word[debug_regmap_pkg::CONFIG_BREAKPOINTS_LSB+:4] = 4'd4;
    config_word[debug_regmap_pkg::CONFIG_WATCHES_LSB+:4]     = 4'd2;
    config_word[debug_regmap_pkg::CONFIG_CHANNELS_LSB+:4]    = 4'd8;
    config_word[debug_regmap_pkg::CONFIG_RING_LOG2_LSB+:4]   = 4'(RingLog2);
    config_word[debug_regmap_pkg::CONFIG_STAGE_LOG2_LSB+:4]  = 4'(StageLog2);
    config_word[debug_regmap_pkg::CONFIG_UART_LSB]           = Uart != 0;

    // Registers that are not kept. Their number comes first, so that a bit is a selection of eight.
    fixed_word = 32'd0;
    if (csr_index_o == debug_regmap_pkg::REG_ID) fixed_word = debug_regmap_pkg::RESET_ID;
    if (csr_index_o == debug_regmap_pkg::REG_CONFIG) fixed_word = config_word;
    if (csr_index_o == debug_regmap_pkg::REG_STAGED) fixed_word = 32'(staged_i);

    is_live = 1'b1;
    live    = LiveFixed;
    case (csr_index_o)
      debug_regmap_pkg::REG_ID, debug_regmap_pkg::REG_CONFIG, debug_regmap_pkg::REG_CONTROL,
      debug_regmap_pkg::REG_STAGED: live = LiveFixed;
      debug_regmap_pkg::REG_STATUS: live = LiveStatus;
      debug_regmap_pkg::REG_PLACE: live = LivePlace;
      debug_regmap_pkg::REG_RUNS: live = LiveRuns;
      debug_regmap_pkg::REG_VERSION: live = LiveVersion;
      debug_regmap_pkg::REG_RECORDS: live = LiveRecords;
      debug_regmap_pkg::REG_TRIGGERED_AT: live = LiveTriggeredAt;
      debug_regmap_pkg::REG_UART_ERRORS: live = LiveUartErrors;
      default: is_live = 1'b0;
    endcase
    case (live)
      LiveStatus: live_word = status_i;
      LivePlace: live_word = place_i;
      LiveRuns: live_word = runs_q;
      LiveVersion: live_word = version_i;
      LiveRecords: live_word = records_i;
      LiveTriggeredAt: live_word = triggered_at_i;
      LiveUartErrors: live_word = uart_errors_i;
      default: live_word = fixed_word;
    endcase

    case (csr_index_o)
      debug_regmap_pkg::REG_RECORD: kept_word = debug_regmap_pkg::RESET_RECORD;
      debug_regmap_pkg::REG_TRIGGER: kept_word = debug_regmap_pkg::RESET_TRIGGER;
      debug_regmap_pkg::REG_UART: kept_word = ResetUart;
      default: kept_word = 32'd0;
    endcase
    if (written_q[csr_index_o]) kept_word = kept;
  end

  assign kept = memory[csr_index_o];

  for (genvar i = 0; i < Registers; i++) begin : gen_written
    if (kept_at(i)) begin : gen_kept
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) written_q[i] <= 1'b0;
        else if (csr_write_o && csr_index_o == 6'(i)) written_q[i] <= 1'b1;
      end
    end else begin : gen_live
      assign written_q[i] = 1'b0;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      done_q    <= 1'b0;
      runs_q    <= '0;
    end else begin
      done_q <= read_i && !done_q;
      if (ended_i) runs_q <= runs_q + 32'd1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (csr_write_o) memory[csr_index_o] <= writedata_i;
    ring_q <= ring_read_o;
    read_q <= !in_csr ? 32'd0 : is_live ? live_word : kept_word;
  end

  assign readdata_o = ring_q ? ring_data_i : read_q;
  assign runs_o     = runs_q;

endmodule
