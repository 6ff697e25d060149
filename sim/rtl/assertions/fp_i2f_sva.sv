// SPDX-License-Identifier: Apache-2.0
// fp_i2f_sva: fp_i2f gives a result for every operation, FP_I2F_LATENCY clocks later.
bind fp_i2f latency_rules #(
    .Latency(fp_pkg::FP_I2F_LATENCY)
) u_sva (
    .clk_i,
    .rst_ni,
    .start(valid_i),
    .done (valid_o)
);
