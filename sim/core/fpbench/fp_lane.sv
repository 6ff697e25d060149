// SPDX-License-Identifier: Apache-2.0
// fp_lane: one arithmetic unit of rtl/fpu with the pins that all lanes of the fast bench share.
// The macro FPBENCH_<UNIT> chooses the unit. Simulation only.
// Contract: control_i is the operation as numbered in operations.h; operands that the unit does not
// have are ignored; ready_o is high whenever the unit takes a new operation at the next edge.
module fp_lane (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        valid_i,
    input  logic [3:0]  control_i,
    input  logic [31:0] a_i,
    input  logic [31:0] b_i,
    input  logic [31:0] c_i,
    output logic        ready_o,
    output logic        valid_o,
    output logic [31:0] result_o,
    output logic [4:0]  flags_o,
    output logic [31:0] latency_o     // register ranks from operands to result
);

`ifdef FPBENCH_FP_ADD
  assign latency_o = fp_pkg::FP_ADD_LATENCY;
  assign ready_o   = 1'b1;
  fp_add unit (
      .clk_i,
      .rst_ni,
      .valid_i,
      .sub_i(control_i[0]),
      .a_i,
      .b_i,
      .valid_o,
      .result_o,
      .flags_o
  );
`elsif FPBENCH_FP_MUL
  assign latency_o = fp_pkg::FP_MUL_LATENCY;
  assign ready_o   = 1'b1;
  fp_mul unit (
      .clk_i,
      .rst_ni,
      .valid_i,
      .a_i,
      .b_i,
      .valid_o,
      .result_o,
      .flags_o
  );
`elsif FPBENCH_FP_FMA
  // control_i: {negate addend, negate product, kind: 0 a*b + c, 1 a*b, 2 a + b}. The unit adds c_i.
  localparam logic [7:0] KINDS = {2'b00, fp_pkg::FMA_KIND_ADD, fp_pkg::FMA_KIND_MUL, fp_pkg::FMA_KIND_FMA};
  logic swap;
  assign swap      = control_i[1];
  assign latency_o = fp_pkg::FP_FMA_LATENCY;
  assign ready_o   = 1'b1;
  fp_fma unit (
      .clk_i,
      .rst_ni,
      .valid_i,
      .kind_i(KINDS[2*control_i[1:0]+:2]),
      .neg_product_i(control_i[2]),
      .neg_addend_i(control_i[3]),
      .a_i,
      .b_i(swap ? c_i : b_i),
      .c_i(swap ? b_i : c_i),
      .valid_o,
      .result_o,
      .flags_o
  );
`elsif FPBENCH_FP_DIVSQRT
  assign latency_o = fp_pkg::FP_DIVSQRT_LATENCY;
  assign ready_o   = 1'b1;
  fp_divsqrt unit (
      .clk_i,
      .rst_ni,
      .valid_i,
      .sqrt_i(control_i[0]),
      .a_i,
      .b_i,
      .valid_o,
      .result_o,
      .flags_o
  );
`elsif FPBENCH_FP_CMP
  assign latency_o = fp_pkg::FP_CMP_LATENCY;
  assign ready_o   = 1'b1;
  fp_cmp unit (
      .clk_i,
      .rst_ni,
      .valid_i,
      .op_i(control_i),
      .a_i,
      .b_i,
      .c_i,
      .valid_o,
      .result_o,
      .flags_o
  );
`elsif FPBENCH_FP_I2F
  assign latency_o = fp_pkg::FP_I2F_LATENCY;
  assign ready_o   = 1'b1;
  fp_i2f unit (
      .clk_i,
      .rst_ni,
      .valid_i,
      .unsigned_i(control_i[0]),
      .a_i,
      .valid_o,
      .result_o,
      .flags_o
  );
`elsif FPBENCH_FP_F2I
  assign latency_o = fp_pkg::FP_F2I_LATENCY;
  assign ready_o   = 1'b1;
  fp_f2i unit (
      .clk_i,
      .rst_ni,
      .valid_i,
      .truncate_i(control_i[0]),
      .a_i,
      .valid_o,
      .result_o,
      .flags_o
  );
`elsif FPBENCH_FP_SINCOS
  assign latency_o = fp_pkg::FP_SINCOS_LATENCY;
  fp_sincos unit (
      .clk_i,
      .rst_ni,
      .valid_i,
      .cos_i(control_i[0]),
      .a_i,
      .ready_o,
      .valid_o,
      .result_o,
      .flags_o
  );
`else
  $error("fp_lane: no FPBENCH_<UNIT> is defined");
`endif

endmodule
