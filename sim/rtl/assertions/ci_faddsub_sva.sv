// SPDX-License-Identifier: Apache-2.0
// ci_faddsub_sva: the only NaN is the canonical one.
module ci_faddsub_sva (
    input logic        clk_i,
    input logic [31:0] result_o
);

  CanonicalNan : assert property (@(posedge clk_i)
      fp_pkg::is_nan(result_o) |-> result_o == fp_pkg::CANON_NAN)
  else $error("a NaN that is not the canonical one");

endmodule

bind ci_faddsub ci_faddsub_sva u_sva (.*);
