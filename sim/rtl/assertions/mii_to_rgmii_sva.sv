// SPDX-License-Identifier: Apache-2.0
// mii_to_rgmii_sva: latencies both ways, MII changes with its clock, TXC is in the middle of the data, which link counts.
module mii_to_rgmii_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic rgmii_rxc_i,
    input logic rgmii_txc_o,
    input logic rgmii_tx_ctl_o,
    input logic [3:0] rgmii_txd_o,
    input logic link_o,
    input logic mii_rx_clk_o,
    input logic mii_rx_dv_o,
    input logic mii_rx_er_o,
    input logic [3:0] mii_rxd_o,
    input logic mii_tx_en_i,
    input logic [3:0] mii_txd_i,
    input logic status,
    input logic [3:0] data_q
);

  logic [3:0] rxc_q;    // RXC in the clocks before, the last one at bit 0
  logic [3:0] known_q;  // and whether reset was over
  logic [4:0] still_q;  // clocks without an edge of RXC, as sampled

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      rxc_q   <= '0;
      known_q <= '0;
      still_q <= '0;
    end else begin
      rxc_q   <= {rxc_q[2:0], rgmii_rxc_i};
      known_q <= {known_q[2:0], 1'b1};
      if (rgmii_rxc_i != rxc_q[0]) still_q <= '0;
      else if (still_q != '1) still_q <= still_q + 1'b1;
    end
  end

  ReceivedInTime : assert property (@(posedge clk_i) disable iff (!rst_ni)
      known_q[3] && !rxc_q[2] && rxc_q[3] |-> $rose(mii_rx_clk_o))
  else $error("a nibble is not there 3 clocks behind the falling RXC");

  ChangesWithTheClock : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !$stable({mii_rx_dv_o, mii_rx_er_o, mii_rxd_o}) |-> $rose(mii_rx_clk_o))
  else $error("MII changes while its clock does not rise");

  SentInTime : assert property (@(posedge clk_i) disable iff (!rst_ni)
      known_q[0] |-> {rgmii_tx_ctl_o, rgmii_txd_o} == $past({mii_tx_en_i, mii_txd_i}))
  else $error("TXD is not what MII gave a clock ago");

  ClockInTheMiddle : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !$stable({rgmii_tx_ctl_o, rgmii_txd_o}) |-> !rgmii_txc_o && !$past(rgmii_txc_o))
  else $error("TXD changes less than a clock from an edge of TXC");

  OneKindOfLink : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $rose(link_o) |-> $past(status) && $past(data_q) == 4'b1011)
  else $error("a link that is not 100 Mbit/s in full duplex");

  LinkNeedsTheClock : assert property (@(posedge clk_i) disable iff (!rst_ni) still_q >= 5'd18 |-> !link_o)
  else $error("a link without RXC");

endmodule

bind mii_to_rgmii mii_to_rgmii_sva u_sva (.*);
