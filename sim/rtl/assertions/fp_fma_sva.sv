// SPDX-License-Identifier: Apache-2.0
// fp_fma_sva: fp_fma gives a result for every operation, FP_FMA_LATENCY clocks later.
bind fp_fma latency_rules #(
    .Latency(fp_pkg::FP_FMA_LATENCY)
) u_sva (
    .clk_i,
    .rst_ni,
    .start(valid_i),
    .done (valid_o)
);
