// SPDX-License-Identifier: Apache-2.0
// biss_master_sva: the rules of every absolute encoder's master.
bind biss_master absolute_rules #(
    .Width(Width)
) u_rules (
    .clk_i,
    .rst_ni,
    .start    (start_i),
    .clock    (ma_o),
    .busy     (busy_o),
    .done     (done_o),
    .position (position_o),
    .crc_error(crc_error_o),
    .lost     (lost_o)
);
