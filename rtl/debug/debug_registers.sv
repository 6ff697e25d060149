// SPDX-License-Identifier: Apache-2.0
// debug_registers: agent on the bus for the registers, the stage and the ring (docs/debug_regmap.md).
// Contract: writes take one cycle, reads two. A register that can be written reads as it was written last;
// one with a reset value, as that from reset to the first write. The ring's read port belongs to the bus in
// the cycles of ring_read_o.
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
    input  logic [31:0]         mode_i,
    input  logic [31:0]         enable_i,
    input  logic [7:0]          staged_i,
    input  logic [31:0]         version_i,
    input  logic [31:0]         records_i,
    input  logic [31:0]         triggered_at_i,
    input  logic [31:0]         uart_errors_i,
    output logic [31:0]         runs_o
);

  localparam int unsigned Width = debug_regmap_pkg::ADDRESS_WIDTH;
  localparam int unsigned Registers = debug_regmap_pkg::WORDS_CSR;

  function automatic logic in_block(input logic [Width-1:0] address, input int unsigned base, input int unsigned words);
    in_block = (32'(address) & ~(words - 1)) == base;
  endfunction

  // A register that keeps what is written keeps it in a memory, at the lowest five bits of its index: of the
  // channels' registers, those are bits of registers that are not stored.
  localparam int unsigned Kept = 32;

  function automatic logic kept_at(input int unsigned index);
    case (6'(index))
      debug_regmap_pkg::REG_ID, debug_regmap_pkg::REG_CONFIG, debug_regmap_pkg::REG_CONTROL,
      debug_regmap_pkg::REG_STATUS, debug_regmap_pkg::REG_PLACE, debug_regmap_pkg::REG_MODE,
      debug_regmap_pkg::REG_ENABLE, debug_regmap_pkg::REG_RUNS, debug_regmap_pkg::REG_STAGED,
      debug_regmap_pkg::REG_VERSION, debug_regmap_pkg::REG_RECORDS,
      debug_regmap_pkg::REG_TRIGGERED_AT, debug_regmap_pkg::REG_UART_ERRORS: kept_at = 1'b0;
      default: kept_at = index < 32'(debug_regmap_pkg::REG_CHANNEL) + 32'd8;
    endcase
  endfunction

  function automatic logic has_reset_at(input logic [5:0] index);
    case (index)
      debug_regmap_pkg::REG_RECORD, debug_regmap_pkg::REG_TRIGGER, debug_regmap_pkg::REG_AROUND,
      debug_regmap_pkg::REG_UART: has_reset_at = 1'b1;
      default: has_reset_at = 1'b0;
    endcase
  endfunction

  logic in_csr, done_q, ring_q, keep;
  logic [31:0] config_word, other_word, count_word, kept_word, word, read_q, runs_q;
  logic [1:0] count, select;
  logic [Registers-1:0] kept, ready;

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

    // Numbers of words come first, so that a bit is a selection of four, and one of four with it.
    case (csr_index_o)
      debug_regmap_pkg::REG_RUNS: count = 2'd0;
      debug_regmap_pkg::REG_VERSION: count = 2'd1;
      debug_regmap_pkg::REG_RECORDS: count = 2'd2;
      default: count = 2'd3;
    endcase
    case (count)
      2'd0: count_word = runs_q;
      2'd1: count_word = version_i;
      2'd2: count_word = records_i;
      default: count_word = triggered_at_i;
    endcase

    case (csr_index_o)
      debug_regmap_pkg::REG_ID: other_word = debug_regmap_pkg::RESET_ID;
      debug_regmap_pkg::REG_CONFIG: other_word = config_word;
      debug_regmap_pkg::REG_STATUS: other_word = status_i;
      debug_regmap_pkg::REG_MODE: other_word = mode_i;
      debug_regmap_pkg::REG_ENABLE: other_word = enable_i;
      debug_regmap_pkg::REG_STAGED: other_word = 32'(staged_i);
      debug_regmap_pkg::REG_RECORD: other_word = debug_regmap_pkg::RESET_RECORD;
      debug_regmap_pkg::REG_TRIGGER: other_word = debug_regmap_pkg::RESET_TRIGGER;
      debug_regmap_pkg::REG_UART: other_word = ResetUart;
      debug_regmap_pkg::REG_UART_ERRORS: other_word = uart_errors_i;
      default: other_word = 32'd0;
    endcase

    case (csr_index_o)
      debug_regmap_pkg::REG_RUNS, debug_regmap_pkg::REG_VERSION, debug_regmap_pkg::REG_RECORDS,
      debug_regmap_pkg::REG_TRIGGERED_AT: select = 2'd0;
      debug_regmap_pkg::REG_PLACE: select = 2'd1;
      default: select = ready[csr_index_o] ? 2'd2 : 2'd3;
    endcase
    case (select)
      2'd0: word = count_word;
      2'd1: word = place_i;
      2'd2: word = kept_word;
      default: word = other_word;
    endcase
  end

  assign keep = csr_write_o && kept[csr_index_o];

  ram_lut #(
      .Words(Kept)
  ) u_ram (
      .clk_i,
      .write_i        (keep),
      .write_address_i(csr_index_o[4:0]),
      .write_data_i   (writedata_i),
      .read_address_i (csr_index_o[4:0]),
      .read_data_o    (kept_word)
  );

  genvar i;
  generate
    for (i = 0; i < Registers; i++) begin : gen_kept
      assign kept[i] = kept_at(i);
      if (has_reset_at(6'(i))) begin : gen_written
        logic written_q;
        always_ff @(posedge clk_i or negedge rst_ni) begin
          if (!rst_ni) written_q <= 1'b0;
          else if (csr_write_o && csr_index_o == 6'(i)) written_q <= 1'b1;
        end
        assign ready[i] = written_q;
      end else begin : gen_ready
        assign ready[i] = kept[i];
      end
    end
  endgenerate

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
    ring_q <= ring_read_o;
    read_q <= in_csr ? word : 32'd0;
  end

  assign readdata_o = ring_q ? ring_data_i : read_q;
  assign runs_o     = runs_q;

endmodule
