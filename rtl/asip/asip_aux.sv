// SPDX-License-Identifier: Apache-2.0
// asip_aux: the auxiliary slot's units at one write port.
// Contract: operands in stage E1; each unit has its own fixed latency (fp_pkg, asip_isa_pkg); the issue
// logic guarantees that at most one unit delivers in a cycle, so the results are merged by OR.
module asip_aux #(
    parameter int unsigned DataWords      = 1024,
    parameter bit          FoldedDivider  = 1'b0,  // the smaller one, see its contract
    parameter bit          OverlappedSine = 1'b1  // the larger one, see its contract
) (
    input  logic               clk_i,
    input  logic               rst_ni,
    input  logic               rst_memory_ni,
    // from the operand stage, E1
    input  logic               valid_i,
    input  asip_pkg::decoded_t op_i,
    input  logic [31:0]        a_i,
    input  logic [31:0]        b_i,
    input  logic [31:0]        c_i,
    output logic               address_fault_o,  // stage E2
    // to write-back
    output logic [31:0]        result_o,
    output fp_pkg::flags_t     flags_o,
    // from and to the host
    input  logic               host_select_i,
    input  logic               host_write_i,
    input  logic [15:0]        host_address_i,
    input  logic [31:0]        host_data_i,
    output logic [31:0]        host_read_o
);

  logic div_valid, cmp_valid, i2f_valid, f2i_valid, sin_valid, load_valid;
  logic [31:0] div_result, cmp_result, i2f_result, f2i_result, sin_result, load_result;
  fp_pkg::flags_t div_flags, cmp_flags, i2f_flags, f2i_flags, sin_flags;
  logic unused_sin_ready, unused_op;

  generate
    if (FoldedDivider) begin : gen_folded
      logic unused_valid;
      assign div_valid = 1'b1;  // its outputs are zero while there is no result

      fp_divsqrt_folded u_divsqrt (
          .clk_i,
          .rst_ni,
          .valid_i (valid_i && op_i.divsqrt),
          .sqrt_i  (op_i.sqrt),
          .a_i,
          .b_i,
          .valid_o (unused_valid),
          .result_o(div_result),
          .flags_o (div_flags)
      );
    end else begin : gen_pipelined
      fp_divsqrt u_divsqrt (
          .clk_i,
          .rst_ni,
          .valid_i (valid_i && op_i.divsqrt),
          .sqrt_i  (op_i.sqrt),
          .a_i,
          .b_i,
          .valid_o (div_valid),
          .result_o(div_result),
          .flags_o (div_flags)
      );
    end
  endgenerate

  fp_cmp u_cmp (
      .clk_i,
      .rst_ni,
      .valid_i (valid_i && op_i.cmp),
      .op_i    (op_i.cmp_op),
      .a_i,
      .b_i,
      .c_i,
      .valid_o (cmp_valid),
      .result_o(cmp_result),
      .flags_o (cmp_flags)
  );

  fp_i2f u_i2f (
      .clk_i,
      .rst_ni,
      .valid_i   (valid_i && op_i.i2f),
      .unsigned_i(1'b0),
      .a_i,
      .valid_o   (i2f_valid),
      .result_o  (i2f_result),
      .flags_o   (i2f_flags)
  );

  fp_f2i u_f2i (
      .clk_i,
      .rst_ni,
      .valid_i   (valid_i && op_i.f2i),
      .truncate_i(op_i.truncate),
      .a_i,
      .valid_o   (f2i_valid),
      .result_o  (f2i_result),
      .flags_o   (f2i_flags)
  );

  generate
    if (OverlappedSine) begin : gen_overlapped
      fp_sincos_overlapped u_sincos (
          .clk_i,
          .rst_ni,
          .valid_i (valid_i && op_i.sincos),
          .cos_i   (op_i.cos),
          .a_i,
          .ready_o (unused_sin_ready),
          .valid_o (sin_valid),
          .result_o(sin_result),
          .flags_o (sin_flags)
      );
    end else begin : gen_iterative
      fp_sincos u_sincos (
          .clk_i,
          .rst_ni,
          .valid_i (valid_i && op_i.sincos),
          .cos_i   (op_i.cos),
          .a_i,
          .ready_o (unused_sin_ready),
          .valid_o (sin_valid),
          .result_o(sin_result),
          .flags_o (sin_flags)
      );
    end
  endgenerate

  asip_memory #(
      .Words(DataWords)
  ) u_memory (
      .clk_i,
      .rst_ni    (rst_memory_ni),
      .load_i    (valid_i && op_i.load),
      .store_i   (valid_i && op_i.store),
      .index_i   (b_i),
      .imm_i     (op_i.imm),
      .data_i    (a_i),
      .fault_e2_o(address_fault_o),
      .valid_o   (load_valid),
      .result_o  (load_result),
      .host_write_i,
      .host_address_i,
      .host_data_i,
      .host_select_i,
      .host_read_o
  );

  assign result_o = ({32{div_valid}} & div_result) | ({32{cmp_valid}} & cmp_result) |
                    ({32{i2f_valid}} & i2f_result) | ({32{f2i_valid}} & f2i_result) |
                    ({32{sin_valid}} & sin_result) | ({32{load_valid}} & load_result);
  assign flags_o = ({5{div_valid}} & div_flags) | ({5{cmp_valid}} & cmp_flags) |
                   ({5{i2f_valid}} & i2f_flags) | ({5{f2i_valid}} & f2i_flags) |
                   ({5{sin_valid}} & sin_flags);

  assign unused_op = ^op_i;

endmodule
