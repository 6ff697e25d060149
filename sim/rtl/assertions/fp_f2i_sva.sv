// SPDX-License-Identifier: Apache-2.0
// fp_f2i_sva: fp_f2i gives a result for every operation, FP_F2I_LATENCY clocks later.
bind fp_f2i latency_rules #(
    .Latency(fp_pkg::FP_F2I_LATENCY)
) u_sva (
    .clk_i,
    .rst_ni,
    .start(valid_i),
    .done (valid_o)
);
