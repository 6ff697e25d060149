// SPDX-License-Identifier: Apache-2.0
// mii_slave: port 0 of ethercat_slave as a PHY sees it, a scalar or a nibble a signal. Port 1 has no link.
// source_clk_i, inverted, is RX_CLK: a source that puts its data out at the rising edge changes them 20 ns before
// the slave takes them. tx_clk_o rises in the middle of a nibble.
module mii_slave (
    input  logic       clk_i,         // 100 MHz
    input  logic       rst_ni,
    input  logic       source_clk_i,  // 25 MHz
    input  logic       rx_dv_i,
    input  logic       rx_er_i,
    input  logic [3:0] rxd_i,
    output logic       tx_clk_o,
    output logic       tx_en_o,
    output logic [3:0] txd_o
);

  logic [1:0] phase_q, tx_en;
  logic [7:0] txd;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) phase_q <= '0;
    else phase_q <= phase_q + 1'b1;
  end
  assign tx_clk_o = phase_q[1];
  assign tx_en_o  = tx_en[0];
  assign txd_o    = txd[3:0];

  logic [31:0] unused_data;
  logic [63:0] unused_time;
  logic [1:0] unused_sync;
  logic [4:0] unused_port;
  logic unused_wait, unused_irq, unused_reset;
  assign unused_port = {tx_en[1], txd[7:4]};

  ethercat_slave u_slave (
      .clk_i,
      .rst_ni,
      .mii_tick_i       (phase_q == 2'd3),
      .link_i           (2'b01),
      .mii_rx_clk_i     ({1'b0, ~source_clk_i}),
      .mii_rx_dv_i      ({1'b0, rx_dv_i}),
      .mii_rx_er_i      ({1'b0, rx_er_i}),
      .mii_rxd_i        ({4'd0, rxd_i}),
      .mii_tx_en_o      (tx_en),
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
