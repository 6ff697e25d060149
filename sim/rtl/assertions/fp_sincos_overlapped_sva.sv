// SPDX-License-Identifier: Apache-2.0
// fp_sincos_overlapped_sva: fp_sincos_overlapped gives a result for every operation that it accepts, FP_SINCOS_OVERLAPPED_LATENCY clocks later.
bind fp_sincos_overlapped latency_rules #(
    .Latency(fp_pkg::FP_SINCOS_OVERLAPPED_LATENCY)
) u_sva (
    .clk_i,
    .rst_ni,
    .start(valid_i && ready_o),
    .done (valid_o)
);
