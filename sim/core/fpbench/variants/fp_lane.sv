// SPDX-License-Identifier: Apache-2.0
// fp_lane: fp_divsqrt_folded or fp_sincos_overlapped in the place of the lane in ../fp_lane.sv, for the
// same operations.
// Contract: as there; ready_o of the divider falls with an operation and rises when the unit may take the next one
// at the edge after next, because fpbench registers operations once more. Simulation only.
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

`ifdef FPBENCH_FP_SINCOS
  logic unused_operands;

  assign latency_o       = fp_pkg::FP_SINCOS_OVERLAPPED_LATENCY;
  assign unused_operands = ^{b_i, c_i, control_i};

  fp_sincos_overlapped unit (
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
  localparam logic [2:0] Interval = 3'(asip_isa_pkg::SMALL_DIVSQRT_INTERVAL);

  logic [2:0] wait_q;  // clocks in which the rank before must stay empty
  logic unused_c;

  assign latency_o = fp_pkg::FP_DIVSQRT_LATENCY;
  assign ready_o   = !valid_i && wait_q == 3'd0;
  assign unused_c  = ^{c_i, control_i};

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) wait_q <= 3'd0;
    else if (valid_i) wait_q <= Interval - 3'd2;
    else if (wait_q != 3'd0) wait_q <= wait_q - 3'd1;
  end

  fp_divsqrt_folded unit (
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
`endif

endmodule
