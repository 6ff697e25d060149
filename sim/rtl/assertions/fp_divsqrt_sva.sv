// SPDX-License-Identifier: Apache-2.0
// fp_divsqrt_sva: fp_divsqrt gives a result for every operation, FP_DIVSQRT_LATENCY clocks later.
bind fp_divsqrt latency_rules #(
    .Latency(fp_pkg::FP_DIVSQRT_LATENCY)
) u_sva (
    .clk_i,
    .rst_ni,
    .start(valid_i),
    .done (valid_o)
);
