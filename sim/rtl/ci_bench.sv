// SPDX-License-Identifier: Apache-2.0
// ci_bench: every custom instruction component alone and both platforms of ci_slaves on the same pins.
// Contract: select_i names the device that sees start_i (numbers: tests/custom/ci_bench.py); done_o and
// result_o are its own, done_o is 0 for fixed latencies. The combinational outputs follow the same
// operands. Simulation only.
module ci_bench (
    input  logic        clk_i,
    input  logic        reset_i,
    input  logic [3:0]  select_i,
    input  logic        clk_en_i,
    input  logic        start_i,
    input  logic [31:0] dataa_i,
    input  logic [31:0] datab_i,
    input  logic [7:0]  n_i,
    input  logic        readra_i,
    input  logic        readrb_i,
    input  logic        writerc_i,
    input  logic [4:0]  a_i,
    input  logic [4:0]  b_i,
    input  logic [4:0]  c_i,
    output logic        done_o,
    output logic [31:0] result_o,
    output logic [31:0] fcmp_o,
    output logic [31:0] fsign_o,
    output logic [31:0] combo1_o,
    output logic [31:0] combo2_o
);

  logic [15:0] start, done;
  logic [15:0][31:0] result;
  always_comb begin
    start = '0;
    start[select_i] = start_i;
  end
  assign done_o   = done[select_i];
  assign result_o = result[select_i];

  for (genvar p = 1; p <= 2; p++) begin : gen_slaves
    logic [31:0] combo;
    ci_slaves #(
        .Platform(p)
    ) slaves (
        .multi_clk_i    (clk_i),
        .multi_reset_i  (reset_i),
        .combo_dataa_i  (dataa_i),
        .combo_datab_i  (datab_i),
        .combo_n_i      (n_i),
        .combo_readra_i (readra_i),
        .combo_readrb_i (readrb_i),
        .combo_writerc_i(writerc_i),
        .combo_a_i      (a_i),
        .combo_b_i      (b_i),
        .combo_c_i      (c_i),
        .combo_result_o (combo),
        .multi_clk_en_i (clk_en_i),
        .multi_start_i  (start[p]),
        .multi_dataa_i  (dataa_i),
        .multi_datab_i  (datab_i),
        .multi_n_i      (n_i),
        .multi_readra_i (readra_i),
        .multi_readrb_i (readrb_i),
        .multi_writerc_i(writerc_i),
        .multi_a_i      (a_i),
        .multi_b_i      (b_i),
        .multi_c_i      (c_i),
        .multi_done_o   (done[p]),
        .multi_result_o (result[p])
    );
  end
  assign combo1_o = gen_slaves[1].combo;
  assign combo2_o = gen_slaves[2].combo;

  // ---- components alone: 0 and 15 are free ----
  ci_fadd fadd (
      .clk_i,
      .reset_i,
      .clk_en_i,
      .start_i(start[3]),
      .dataa_i,
      .datab_i,
      .result_o(result[3])
  );
  ci_fsub fsub (
      .clk_i,
      .reset_i,
      .clk_en_i,
      .start_i(start[4]),
      .dataa_i,
      .datab_i,
      .result_o(result[4])
  );
  ci_fmul fmul (
      .clk_i,
      .reset_i,
      .clk_en_i,
      .start_i(start[5]),
      .dataa_i,
      .datab_i,
      .result_o(result[5])
  );
  ci_fdiv fdiv (
      .clk_i,
      .reset_i,
      .clk_en_i,
      .start_i(start[6]),
      .dataa_i,
      .datab_i,
      .result_o(result[6])
  );
  ci_fsqrt fsqrt (
      .clk_i,
      .reset_i,
      .clk_en_i,
      .start_i(start[7]),
      .dataa_i,
      .result_o(result[7])
  );
  ci_fsin fsin (
      .clk_i,
      .reset_i,
      .clk_en_i,
      .start_i(start[8]),
      .dataa_i,
      .result_o(result[8])
  );
  ci_fcos fcos (
      .clk_i,
      .reset_i,
      .clk_en_i,
      .start_i(start[9]),
      .dataa_i,
      .result_o(result[9])
  );
  ci_fsat fsat (
      .clk_i,
      .reset_i,
      .clk_en_i,
      .start_i(start[10]),
      .dataa_i,
      .datab_i,
      .readra_i,
      .readrb_i,
      .writerc_i,
      .a_i,
      .b_i,
      .c_i,
      .result_o(result[10])
  );
  ci_floatis floatis (
      .clk_i,
      .reset_i,
      .clk_en_i,
      .start_i(start[11]),
      .dataa_i,
      .result_o(result[11])
  );
  ci_fixsi fixsi (
      .clk_i,
      .reset_i,
      .clk_en_i,
      .start_i(start[12]),
      .dataa_i,
      .result_o(result[12])
  );
  ci_fph1 fph1 (
      .clk_i,
      .reset_i,
      .clk_en_i,
      .start_i(start[13]),
      .n_i(n_i[1:0]),
      .dataa_i,
      .datab_i,
      .done_o(done[13]),
      .result_o(result[13])
  );
  ci_fcmp fcmp (
      .dataa_i,
      .datab_i,
      .n_i(n_i[3:0]),
      .result_o(fcmp_o)
  );
  ci_fsign fsign (
      .dataa_i,
      .result_o(fsign_o)
  );

  assign {done[15:14], done[12:3], done[0]} = '0;
  assign {result[15:14], result[0]} = '0;

endmodule
