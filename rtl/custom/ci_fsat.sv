// SPDX-License-Identifier: Apache-2.0
// ci_fsat: custom instruction, saturation with bounds in internal registers: 32 pairs {low, high}.
// Contract: fixed latency, three cycles. What happens depends on where c, a, b come from (1: CPU):
//   writerc readra readrb   result
//      1      1      1      a limited to -|b| .. |b|
//      1      1      0      a limited to the bounds in register b
//      1      0      1 / 0  lower / upper bound in register a
//      0      1      1      0; register c takes {a, b} at the first edge with start and clk_en
//      0     else           0; nothing is written
// A NaN operand or a lower bound above the upper one gives the canonical NaN, as FP_CMP_SAT of
// fp_cmp. Registers keep their contents through reset and hold anything before they are written.
module ci_fsat (
    input  logic        clk_i,
    input  logic        reset_i,
    input  logic        clk_en_i,
    input  logic        start_i,
    input  logic [31:0] dataa_i,
    input  logic [31:0] datab_i,
    input  logic        readra_i,
    input  logic        readrb_i,
    input  logic        writerc_i,
    input  logic [4:0]  a_i,
    input  logic [4:0]  b_i,
    input  logic [4:0]  c_i,
    output logic [31:0] result_o
);

  logic unused_reset;
  assign unused_reset = reset_i;

  logic [63:0] read;
  ram_lut #(
      .Words(32),
      .Width(64)
  ) u_bounds (
      .clk_i,
      .write_i        (start_i && clk_en_i && !writerc_i && readra_i && readrb_i),
      .write_address_i(c_i),
      .write_data_i   ({dataa_i, datab_i}),
      .read_address_i (readra_i ? b_i : a_i),
      .read_data_o    (read)
  );

  // Both ranks run freely on held operands, as the pipelines of the other components. The first one
  // takes the bounds, the second one compares.
  logic symmetric;
  logic [31:0] low, high;
  assign symmetric = readra_i && readrb_i;
  always_ff @(posedge clk_i) begin
    low  <= symmetric ? {1'b1, datab_i[30:0]} : read[63:32];
    high <= symmetric ? {1'b0, datab_i[30:0]} : read[31:0];
  end

  logic under, over, exchanged;
  logic [2:0] unused_below, unused_equal;
  ci_order u_under_low (
      .a_i    (dataa_i),
      .b_i    (low),
      .below_o(unused_below[0]),
      .less_o (under),
      .equal_o(unused_equal[0])
  );
  ci_order u_over_high (
      .a_i    (high),
      .b_i    (dataa_i),
      .below_o(unused_below[1]),
      .less_o (over),
      .equal_o(unused_equal[1])
  );
  ci_order u_high_low (
      .a_i    (high),
      .b_i    (low),
      .below_o(unused_below[2]),
      .less_o (exchanged),
      .equal_o(unused_equal[2])
  );

  logic nan;
  logic [31:0] result;
  assign nan = exchanged || fp_pkg::is_nan(dataa_i) || fp_pkg::is_nan(low) || fp_pkg::is_nan(high);
  always_comb begin
    if (!writerc_i) result = 32'd0;
    else if (!readra_i) result = readrb_i ? low : high;
    else if (nan) result = fp_pkg::CANON_NAN;
    else if (under) result = low;
    else if (over) result = high;
    else result = dataa_i;
  end
  always_ff @(posedge clk_i) result_o <= result;

endmodule
