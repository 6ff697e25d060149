// SPDX-License-Identifier: Apache-2.0
// dual_asip_sva: the two-processor system's Avalon-MM port.
bind dual_asip avalon_rules #(
    .AddressWidth(dual_regmap_pkg::ADDRESS_WIDTH)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    (address_i),
    .read       (read_i),
    .write      (write_i),
    .writedata  (writedata_i),
    .waitrequest(waitrequest_o)
);
