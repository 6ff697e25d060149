// SPDX-License-Identifier: Apache-2.0
// ci_fph1: multiply (n 0), add (1), subtract (2), divide (3) with the numbers and cycles of the
// vendor's first floating-point custom instructions (generation FPH1); own implementation.
// Contract: variable latency, done_o in cycle ci_pkg::FPGA1_FPH1_*_CYCLES from start, counted with
// clk_en high; one operation at a time, operands are taken at start. Rounds to nearest even. A
// subnormal operand is a zero of its sign, and so is a result that is subnormal once rounded. Any
// NaN result is 7fc00000. No flags.
module ci_fph1 (
    input  logic        clk_i,
    input  logic        reset_i,     // active high, asynchronous, released with the clock
    input  logic        clk_en_i,
    input  logic        start_i,
    input  logic [1:0]  n_i,
    input  logic [31:0] dataa_i,
    input  logic [31:0] datab_i,
    output logic        done_o,
    output logic [31:0] result_o
);

  localparam logic [1:0] Mul = ci_pkg::FPGA1_N_FMUL[1:0];
  localparam logic [1:0] Sub = ci_pkg::FPGA1_N_FSUB[1:0];
  localparam logic [1:0] Div = ci_pkg::FPGA1_N_FDIV[1:0];

  function automatic logic [31:0] flushed(input logic [31:0] x);
    flushed = (|x[30:23]) ? x : {x[31], 31'd0};
  endfunction

  // ---- control: cycles that are left after this one ----
  logic rst_n, last_q;  // last_q: left_q is 1
  logic [5:0] left_q, cycles;
  assign rst_n = !reset_i;
  always_comb begin
    case (n_i)
      Mul:     cycles = 6'(ci_pkg::FPGA1_FPH1_FMUL_CYCLES);
      Div:     cycles = 6'(ci_pkg::FPGA1_FPH1_FDIV_CYCLES);
      default: cycles = 6'(ci_pkg::FPGA1_FPH1_FADD_CYCLES);
    endcase
  end
  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) begin
      left_q <= 6'd0;
      last_q <= 1'b0;
    end else if (clk_en_i) begin
      if (start_i) left_q <= cycles - 6'd1;
      else if (left_q != 6'd0) left_q <= left_q - 6'd1;
      last_q <= !start_i && left_q == 6'd2;
    end
  end
  assign done_o = !start_i && last_q;

  logic [1:0] n_q;
  logic [31:0] a_q, b_q;
  always_ff @(posedge clk_i) begin
    if (clk_en_i && start_i) begin
      n_q <= n_i;
      a_q <= flushed(dataa_i);
      b_q <= flushed(datab_i);
    end
  end

  // ---- units: they run freely on the held operands and are done long before the counter ----
  logic [31:0] product, sum, quotient;
  logic [2:0] unused_valid;
  fp_pkg::flags_t unused_mul_flags, unused_add_flags, unused_div_flags;
  fp_mul u_multiply (
      .clk_i   (clk_i),
      .rst_ni  (rst_n),
      .valid_i (1'b0),
      .a_i     (a_q),
      .b_i     (b_q),
      .valid_o (unused_valid[0]),
      .result_o(product),
      .flags_o (unused_mul_flags)
  );
  fp_add u_add (
      .clk_i   (clk_i),
      .rst_ni  (rst_n),
      .valid_i (1'b0),
      .sub_i   (n_q == Sub),
      .a_i     (a_q),
      .b_i     (b_q),
      .valid_o (unused_valid[1]),
      .result_o(sum),
      .flags_o (unused_add_flags)
  );
  fp_divsqrt u_divide (
      .clk_i   (clk_i),
      .rst_ni  (rst_n),
      .valid_i (1'b0),
      .sqrt_i  (1'b0),
      .a_i     (a_q),
      .b_i     (b_q),
      .valid_o (unused_valid[2]),
      .result_o(quotient),
      .flags_o (unused_div_flags)
  );
  // Of the unit that n_q names the sign, and the rest unless that is subnormal, decided a cycle ahead.
  logic [2:0] mine, mine_q, normal_q;
  assign mine = {n_q == Div, n_q == Mul, n_q != Div && n_q != Mul};
  always_ff @(posedge clk_i) begin
    mine_q   <= mine;
    normal_q <= mine & {|quotient[30:23], |product[30:23], |sum[30:23]};
  end
  assign result_o[31]   = |(mine_q & {quotient[31], product[31], sum[31]});
  assign result_o[30:0] = ({31{normal_q[2]}} & quotient[30:0]) |
                          ({31{normal_q[1]}} & product[30:0]) | ({31{normal_q[0]}} & sum[30:0]);

`ifndef SYNTHESIS
  // Operand register, unit, register of the selection must fit in the cycles promised.
  generate
    if (fp_pkg::FP_MUL_LATENCY + 3 > ci_pkg::FPGA1_FPH1_FMUL_CYCLES) begin : gen_mul_check
      $error("ci_fph1: fp_mul is slower than ci_pkg::FPGA1_FPH1_FMUL_CYCLES allow");
    end
    if (fp_pkg::FP_ADD_LATENCY + 3 > ci_pkg::FPGA1_FPH1_FADD_CYCLES) begin : gen_add_check
      $error("ci_fph1: fp_add is slower than ci_pkg::FPGA1_FPH1_FADD_CYCLES allow");
    end
    if (fp_pkg::FP_DIVSQRT_LATENCY + 3 > ci_pkg::FPGA1_FPH1_FDIV_CYCLES) begin : gen_div_check
      $error("ci_fph1: fp_divsqrt is slower than ci_pkg::FPGA1_FPH1_FDIV_CYCLES allow");
    end
  endgenerate
`endif

endmodule
