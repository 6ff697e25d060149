// SPDX-License-Identifier: Apache-2.0
// rgmii_slave: ethercat_slave with an adapter to RGMII at each port, as docs/ethercat.md connects them.
module rgmii_slave (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        mii_tick_i,
    // RGMII, port n at bit n (nibble n)
    input  logic [1:0]  rgmii_rxc_i,
    input  logic [1:0]  rgmii_rx_ctl_i,
    input  logic [7:0]  rgmii_rxd_i,
    output logic [1:0]  rgmii_txc_o,
    output logic [1:0]  rgmii_tx_ctl_o,
    output logic [7:0]  rgmii_txd_o,
    // between adapters and controller
    output logic [1:0]  link_o,
    output logic [1:0]  mii_rx_clk_o,
    output logic [1:0]  mii_rx_dv_o,
    output logic [1:0]  mii_tx_en_o
);

  logic [1:0] rx_er;
  logic [7:0] rxd, txd;

  for (genvar n = 0; n < 2; n++) begin : g_port
    mii_to_rgmii u_rgmii (
        .clk_i,
        .rst_ni,
        .rgmii_rxc_i   (rgmii_rxc_i[n]),
        .rgmii_rx_ctl_i(rgmii_rx_ctl_i[n]),
        .rgmii_rxd_i   (rgmii_rxd_i[4*n+:4]),
        .rgmii_txc_o   (rgmii_txc_o[n]),
        .rgmii_tx_ctl_o(rgmii_tx_ctl_o[n]),
        .rgmii_txd_o   (rgmii_txd_o[4*n+:4]),
        .mii_tick_i,
        .link_o        (link_o[n]),
        .mii_rx_clk_o  (mii_rx_clk_o[n]),
        .mii_rx_dv_o   (mii_rx_dv_o[n]),
        .mii_rx_er_o   (rx_er[n]),
        .mii_rxd_o     (rxd[4*n+:4]),
        .mii_tx_en_i   (mii_tx_en_o[n]),
        .mii_txd_i     (txd[4*n+:4])
    );
  end

  logic [31:0] unused_data;
  logic [63:0] unused_time;
  logic [1:0] unused_sync;
  logic unused_wait, unused_irq, unused_reset;

  ethercat_slave u_slave (
      .clk_i,
      .rst_ni,
      .mii_tick_i,
      .link_i           (link_o),
      .mii_rx_clk_i     (mii_rx_clk_o),
      .mii_rx_dv_i      (mii_rx_dv_o),
      .mii_rx_er_i      (rx_er),
      .mii_rxd_i        (rxd),
      .mii_tx_en_o,
      .mii_txd_o        (txd),
      .avs_address_i    ('0),
      .avs_read_i       (1'b0),
      .avs_write_i      (1'b0),
      .avs_byteenable_i ('0),
      .avs_writedata_i  ('0),
      .avs_readdata_o   (unused_data),
      .avs_waitrequest_o(unused_wait),
      .irq_o            (unused_irq),
      .reset_no         (unused_reset),
      .latch_i          ('0),
      .sync_o           (unused_sync),
      .time_o           (unused_time)
  );

endmodule
