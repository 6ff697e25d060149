// SPDX-License-Identifier: Apache-2.0
// fp_add_sva: fp_add gives a result for every operation, FP_ADD_LATENCY clocks later.
bind fp_add latency_rules #(
    .Latency(fp_pkg::FP_ADD_LATENCY)
) u_sva (
    .clk_i,
    .rst_ni,
    .start(valid_i),
    .done (valid_o)
);
