// SPDX-License-Identifier: Apache-2.0
// asip_units: the arithmetic units after the operand registers, and the exceptions of a run.
// Contract: operations and operands in stage E1; results of banks A, B, C when the write schedules say
// so. flags_o gathers the exceptions since clear_flags_i. Idle, the host reaches data memory here.
module asip_units #(
    parameter int unsigned FmaPipes  = 2,
    parameter int unsigned Slots     = 3,
    parameter int unsigned DataWords = 1024
) (
    input  logic                                     clk_i,
    input  logic                                     rst_ni,
    input  logic                                     rst_run_ni,       // also between runs
    input  logic                                     clear_flags_i,
    // from the operand stage, E1
    input  logic                                     valid_e1_i,
    input  logic [Slots*asip_pkg::DECODED_WIDTH-1:0] ops_e1_i,
    input  logic [3*Slots-1:0][31:0]                 operand_e1_i,
    input  fp_pkg::flags_t                           flags_lanes_i,
    // to write-back and control
    output logic [2:0][31:0]                         result_o,
    output fp_pkg::flags_t                           flags_o,
    output logic                                     address_fault_o,  // stage E2
    // from and to the host
    input  logic                                     host_select_i,
    input  logic                                     host_write_i,     // any write
    input  logic                                     host_data_i,      // .. of data memory
    input  logic [15:0]                              host_address_i,
    input  logic [31:0]                              host_word_i,
    output logic [31:0]                              host_word_o,      // to the outputs' safe values
    output logic [31:0]                              host_read_o
);

  localparam int unsigned OpWidth = asip_pkg::DECODED_WIDTH;
  localparam int unsigned Ports = 3 * Slots;

  asip_pkg::decoded_t aux_e1;
  logic [31:0] result_aux;
  logic [1:0][4:0] flags_fma;
  fp_pkg::flags_t flags_aux, flags_q;

  assign aux_e1 = ops_e1_i[OpWidth*(Slots-1)+:OpWidth];

  genvar p;
  generate
    for (p = 0; p < FmaPipes; p++) begin : gen_pipe
      asip_pkg::decoded_t op_e1;
      logic valid;
      fp_pkg::flags_t flags;

      assign op_e1 = ops_e1_i[OpWidth*p+:OpWidth];

      fp_fma u_fma (
          .clk_i,
          .rst_ni       (rst_run_ni),
          .valid_i      (valid_e1_i && op_e1.fma),
          .kind_i       (op_e1.fma_kind),
          .neg_product_i(op_e1.neg_product),
          .neg_addend_i (op_e1.neg_addend),
          .a_i          (operand_e1_i[3*p]),
          .b_i          (operand_e1_i[3*p+1]),
          .c_i          (operand_e1_i[3*p+2]),
          .valid_o      (valid),
          .result_o     (result_o[p]),
          .flags_o      (flags)
      );
      assign flags_fma[p] = valid ? flags : '0;
    end
    if (FmaPipes < 2) begin : gen_no_pipe_b
      assign result_o[1]  = '0;
      assign flags_fma[1] = '0;
    end
  endgenerate

  asip_aux #(
      .DataWords     (DataWords),
      .FoldedDivider (Slots == 1),
      .OverlappedSine(Slots != 1)
  ) u_aux (
      .clk_i,
      .rst_ni        (rst_run_ni),
      .rst_memory_ni (rst_ni),
      .valid_i       (valid_e1_i),
      .op_i          (aux_e1),
      .a_i           (operand_e1_i[Ports-3]),
      .b_i           (operand_e1_i[Ports-2]),
      .c_i           (operand_e1_i[Ports-1]),
      .address_fault_o,
      .result_o      (result_aux),
      .flags_o       (flags_aux),
      .host_select_i,
      .host_write_i  (host_data_i),
      .host_address_i,
      .host_data_i   (host_word_i),
      .host_read_o
  );

  // The auxiliary result is zero while the host may write. With one slot the host's word goes that way.
  generate
    if (Slots == 1) begin : gen_host_word
      assign result_o[2] = result_aux | ({32{host_select_i && host_write_i}} & host_word_i);
      assign host_word_o = '0;
    end else begin : gen_no_host_word
      logic unused_write;
      assign result_o[2]  = result_aux;
      assign host_word_o  = host_word_i;
      assign unused_write = host_write_i;
    end
  endgenerate

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) flags_q <= '0;
    else if (clear_flags_i) flags_q <= '0;
    else flags_q <= flags_q | flags_fma[0] | flags_fma[1] | flags_aux | flags_lanes_i;
  end

  assign flags_o = flags_q;

endmodule
