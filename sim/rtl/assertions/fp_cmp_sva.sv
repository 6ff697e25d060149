// SPDX-License-Identifier: Apache-2.0
// fp_cmp_sva: fp_cmp gives a result for every operation, FP_CMP_LATENCY clocks later.
bind fp_cmp latency_rules #(
    .Latency(fp_pkg::FP_CMP_LATENCY)
) u_sva (
    .clk_i,
    .rst_ni,
    .start(valid_i),
    .done (valid_o)
);
