// SPDX-License-Identifier: Apache-2.0
// ci_fsign: custom instruction, signum of a. Combinational.
// Contract: -1.0, +0.0 for either zero, 1.0; the canonical NaN for a NaN. Subnormal numbers have a
// sign like any other.
module ci_fsign (
    input  logic [31:0] dataa_i,
    output logic [31:0] result_o
);

  always_comb begin
    result_o = {dataa_i[31], fp_pkg::ONE[30:0]};
    if (fp_pkg::is_zero(dataa_i)) result_o = 32'd0;
    if (fp_pkg::is_nan(dataa_i)) result_o = fp_pkg::CANON_NAN;
  end

endmodule
