// SPDX-License-Identifier: Apache-2.0
// encoder_registers: incremental encoders as words that a host reads.
// Contract: Avalon-MM agent of the words in docs/encoder_regmap.md, once for each axis; those after the last axis
// read 0. Reads take two cycles, writes one. Lines as quadrature_decoder, with a filter of Filter + 1 clocks.
module encoder_registers #(
    parameter int unsigned Axes   = 5,   // 1..8
    parameter int unsigned Filter = 3
) (
    input  logic            clk_i,
    input  logic            rst_ni,
    // Avalon-MM agent
    input  logic [4:0]      address_i,
    input  logic            read_i,
    input  logic            write_i,
    output logic [31:0]     readdata_o,
    output logic            waitrequest_o,
    // encoders, asynchronous
    input  logic [Axes-1:0] a_i,
    input  logic [Axes-1:0] b_i,
    input  logic [Axes-1:0] z_i
);

  localparam int unsigned Words = encoder_regmap_pkg::WORDS_CSR;
  localparam int unsigned AxisLow = encoder_regmap_pkg::ADDRESS_WIDTH;  // of the address: which axis

  logic [31:0] time_q, readdata_q;
  logic read_q;
  logic [31:0][31:0] words;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      time_q <= '0;
      read_q <= 1'b0;
    end else begin
      time_q <= time_q + 32'd1;
      read_q <= read_i && !read_q;
    end
  end

  always_ff @(posedge clk_i) readdata_q <= words[address_i];

  assign readdata_o    = readdata_q;
  assign waitrequest_o = read_i && !read_q;

  genvar i;
  generate
    for (i = 0; i < 8; i++) begin : gen_axis
      if (i < Axes) begin : gen_decoder
        logic [31:0] position, index_position, edge_time, status;
        logic unused_passes;
        logic [7:0] illegal_count;
        logic index, illegal;

        quadrature_decoder u_decoder (
            .clk_i,
            .rst_ni,
            .a_i             (a_i[i]),
            .b_i             (b_i[i]),
            .z_i             (z_i[i]),
            .filter_i        (4'(Filter)),
            .clear_i         (write_i && address_i[4:AxisLow] == 3'(i)),
            .time_i          (time_q),
            .position_o      (position),
            .edge_time_o     (edge_time),
            .index_o         (index),
            .index_position_o(index_position),
            .passes_o        (unused_passes),
            .illegal_o       (illegal),
            .illegal_count_o (illegal_count)
        );
        always_comb begin
          status = '0;
          status[encoder_regmap_pkg::STATUS_INDEX_LSB]            = index;
          status[encoder_regmap_pkg::STATUS_ILLEGAL_LSB]          = illegal;
          status[encoder_regmap_pkg::STATUS_ILLEGAL_COUNT_LSB+:8] = illegal_count;
        end
        assign words[Words*i+32'(encoder_regmap_pkg::REG_POSITION)]       = position;
        assign words[Words*i+32'(encoder_regmap_pkg::REG_INDEX_POSITION)] = index_position;
        assign words[Words*i+32'(encoder_regmap_pkg::REG_STATUS)]         = status;
        assign words[Words*i+32'(encoder_regmap_pkg::REG_IDLE_CLOCKS)]    = time_q - edge_time;
      end else begin : gen_none
        assign words[Words*i+:Words] = '0;
      end
    end
  endgenerate

endmodule
