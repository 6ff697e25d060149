// SPDX-License-Identifier: Apache-2.0
// debug_capture: what the channels of the scope saw last.
// Contract: a channel takes a word in the clock in which it is written; a run that does not write it leaves
// it. Words of bank K are taken as the host writes them, `cycles` when a run ends.
module debug_capture #(
    parameter int unsigned Channels = 8
) (
    input  logic                      clk_i,
    input  logic                      rst_ni,
    // writes of registers
    input  logic                      csr_write_i,
    input  logic [5:0]                csr_index_i,
    input  logic [31:0]               csr_data_i,
    // from the core
    input  logic                      run_start_i,
    input  logic                      ended_i,
    input  logic [31:0]               cycles_i,
    input  logic [3:0]                write_i,        // banks A, B, C, outputs
    input  logic [2:0][5:0]           write_index_i,
    input  logic [2:0][31:0]          write_data_i,
    // writes of bank K
    input  logic                      constant_write_i,
    input  logic [6:0]                constant_index_i,
    input  logic [31:0]               constant_data_i,
    // of one channel
    input  logic [2:0]                channel_i,
    output logic [31:0]               word_o
);

  localparam int unsigned FirstLsb = debug_regmap_pkg::CHANNEL_INDEX_LSB;

  logic [Channels-1:0][6:0]  index_q;
  logic [Channels-1:0][1:0]  bank_q, kind_q;
  logic [Channels-1:0][3:0]  wanted_q, count_q;
  logic [Channels-1:0][31:0] word_q;
  logic [31:0]               cycles_q;

  for (genvar c = 0; c < Channels; c++) begin : gen_channel
    logic [1:0]  from;  // banks A, B, C, bank K
    logic        hit;
    logic [31:0] word;

    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) begin
        index_q[c]  <= '0;
        bank_q[c]   <= '0;
        kind_q[c]   <= '0;
        wanted_q[c] <= '0;
      end else if (csr_write_i && csr_index_i == debug_regmap_pkg::REG_CHANNEL + 6'(c)) begin
        index_q[c]  <= csr_data_i[FirstLsb+:7];
        bank_q[c]   <= csr_data_i[debug_regmap_pkg::CHANNEL_BANK_LSB+:2];
        kind_q[c]   <= csr_data_i[debug_regmap_pkg::CHANNEL_KIND_LSB+:2];
        wanted_q[c] <= csr_data_i[debug_regmap_pkg::CHANNEL_WRITE_LSB+:4];
      end
    end

    always_comb begin
      case (kind_q[c])
        debug_regmap_pkg::CHANNEL_KIND_REGISTER: from = bank_q[c];
        debug_regmap_pkg::CHANNEL_KIND_OUTPUT: from = 2'd2;
        default: from = 2'd3;
      endcase
      hit = from[1] ? (from[0] ? constant_write_i && constant_index_i == index_q[c] :
                       (kind_q[c][0] ? write_i[3] : write_i[2]) &&
                       write_index_i[2] == index_q[c][5:0]) :
            from[0] ? write_i[1] && write_index_i[1] == index_q[c][5:0] :
                      write_i[0] && write_index_i[0] == index_q[c][5:0];
    end

    // Selections of two inputs: one table of six inputs a bit.
    assign word = from[1] ? (from[0] ? constant_data_i : write_data_i[2]) :
                  from[0] ? write_data_i[1] : write_data_i[0];

    // Number of the next write of the run, 0 once there were 15.
    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) count_q[c] <= 4'd1;
      else if (run_start_i) count_q[c] <= 4'd1;
      else if (hit && |count_q[c]) count_q[c] <= count_q[c] + 4'd1;
    end

    always_ff @(posedge clk_i) begin
      if (hit && (wanted_q[c] == 4'd0 || wanted_q[c] == count_q[c])) word_q[c] <= word;
    end
  end

  // A new run clears the core's own before the last channel is recorded.
  always_ff @(posedge clk_i) if (ended_i) cycles_q <= cycles_i;

  assign word_o = kind_q[channel_i] == debug_regmap_pkg::CHANNEL_KIND_CYCLES ? cycles_q :
                  word_q[channel_i];

  logic unused_bits;
  assign unused_bits = ^csr_data_i;

endmodule
