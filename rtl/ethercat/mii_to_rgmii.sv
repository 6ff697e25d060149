// SPDX-License-Identifier: Apache-2.0
// mii_to_rgmii: one RGMII port at 100 Mbit/s in front of an MII port of ethercat_slave. Source: RGMII 2.0 (2002),
// timing with internal delay (RGMII-ID).
// Contract: clk_i is 100 MHz and samples all pins; mii_tick_i is that of ethercat_slave.
// Receive: RXC is 25 MHz, high and low for 15 ns at least. RXD and RX_CTL are stable from 1 ns before each edge of RXC to
// 11 ns after it: the PHY or the board delays RXC by 1 ns to 3 ns. The nibble is that of the rising edge; what RXD has at
// the falling edge is not looked at, RX_ER comes from RX_CTL at both. mii_rx_* change together, when mii_rx_clk_o rises.
// Latency: 3 clocks, from the clock that samples RXC low to the one that samples mii_rx_clk_o high. With the half period
// of RXC before them a nibble comes 5 clocks later than by MII without the adapter.
// Transmit: latency 1 clock, from mii_tx_* to TXD and TX_CTL. TXC rises 1 clock after them and falls 1 clock before they
// change: the PHY needs no delay of its own, and one of up to 8 ns does no harm. TX_ER is never sent. No TXC in reset.
// Link: link_o follows the in-band status, which the PHY must send: link, 100 Mbit/s and full duplex, all else is no link.
// It changes after 8 status nibbles in a row that contradict it, frames between them not counted, and falls 18 clocks
// after the clock that sampled the last edge of RXC. 10 and 1000 Mbit/s are not served.
module mii_to_rgmii (
    input  logic       clk_i,
    input  logic       rst_ni,
    // RGMII
    input  logic       rgmii_rxc_i,
    input  logic       rgmii_rx_ctl_i,
    input  logic [3:0] rgmii_rxd_i,
    output logic       rgmii_txc_o,
    output logic       rgmii_tx_ctl_o,
    output logic [3:0] rgmii_txd_o,
    // to a port of ethercat_slave
    input  logic       mii_tick_i,
    output logic       link_o,
    output logic       mii_rx_clk_o,
    output logic       mii_rx_dv_o,
    output logic       mii_rx_er_o,
    output logic [3:0] mii_rxd_o,
    input  logic       mii_tx_en_i,
    input  logic [3:0] mii_txd_i
);

  localparam logic [3:0] FullDuplex100Up = 4'b1011;  // duplex, speed 01, link
  localparam logic [2:0] LastStatus = 3'd7;
  localparam logic [3:0] LastClock = 4'd15;

  // Receive.
  logic [2:0] clock_q;
  logic [4:0] now_q, then_q;
  logic [3:0] data_q;
  logic valid_q, rise, fall;

  assign rise = clock_q[1] && !clock_q[2];
  assign fall = !clock_q[1] && clock_q[2];

  always_ff @(posedge clk_i) begin
    now_q  <= {rgmii_rx_ctl_i, rgmii_rxd_i};
    then_q <= now_q;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      clock_q      <= '0;
      valid_q      <= 1'b0;
      data_q       <= '0;
      mii_rx_clk_o <= 1'b0;
      mii_rx_dv_o  <= 1'b0;
      mii_rx_er_o  <= 1'b0;
      mii_rxd_o    <= '0;
    end else begin
      clock_q <= {clock_q[1:0], rgmii_rxc_i};
      if (rise) begin
        {valid_q, data_q} <= then_q;
        mii_rx_clk_o      <= 1'b0;
      end
      if (fall) begin
        mii_rx_clk_o <= 1'b1;
        mii_rx_dv_o  <= valid_q;
        mii_rx_er_o  <= valid_q ^ then_q[4];
        mii_rxd_o    <= data_q;
      end
    end
  end

  // Link.
  logic [2:0] count_q;  // status nibbles in a row that contradict link_o
  logic [3:0] still_q;  // clocks without an edge of RXC
  logic status, good;

  assign status = fall && !valid_q && !then_q[4];
  assign good   = data_q == FullDuplex100Up;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q <= '0;
      still_q <= '0;
      link_o  <= 1'b0;
    end else begin
      if (rise || fall) still_q <= '0;
      else if (still_q != LastClock) still_q <= still_q + 1'b1;

      if (still_q == LastClock) begin
        link_o  <= 1'b0;
        count_q <= '0;
      end else if (status) begin
        count_q <= '0;
        if (good != link_o) begin
          count_q <= count_q + 1'b1;
          if (count_q == LastStatus) link_o <= good;
        end
      end
    end
  end

  // Transmit.
  logic [2:0] tick_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      tick_q         <= '0;
      rgmii_txc_o    <= 1'b0;
      rgmii_tx_ctl_o <= 1'b0;
      rgmii_txd_o    <= '0;
    end else begin
      tick_q         <= {tick_q[1:0], mii_tick_i};
      rgmii_txc_o    <= tick_q[1] || tick_q[2];
      rgmii_tx_ctl_o <= mii_tx_en_i;
      rgmii_txd_o    <= mii_txd_i;
    end
  end

endmodule
