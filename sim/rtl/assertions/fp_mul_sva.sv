// SPDX-License-Identifier: Apache-2.0
// fp_mul_sva: fp_mul gives a result for every operation, FP_MUL_LATENCY clocks later.
bind fp_mul latency_rules #(
    .Latency(fp_pkg::FP_MUL_LATENCY)
) u_sva (
    .clk_i,
    .rst_ni,
    .start(valid_i),
    .done (valid_o)
);
