// SPDX-License-Identifier: Apache-2.0
// asip_ulx3s: asip_ecp5 on a ULX3S (Radiona; LFE5U-85F-6BG381C). Pins: asip_ulx3s.lpf.
// Contract: core clock 75 MHz from the 25 MHz oscillator; the serial line is that of the board's USB bridge
// FT231X, 3 Mbit/s after reset; BTN_PWRn resets. led: 0 alive, 1 held by the debug block, 2 done or a fault.
module asip_ulx3s (
    input  logic       clk_25mhz,
    input  logic       btn_pwr_n,
    input  logic       ftdi_txd,    // from the bridge
    output logic       ftdi_rxd,
    output logic       wifi_gpio0,  // high: the ESP32 leaves the FPGA alone
    output logic [2:0] led,
    output logic [4:0] step,
    output logic [4:0] direction,
    input  logic [4:0] encoder_a,
    input  logic [4:0] encoder_b,
    input  logic [4:0] encoder_z
);

  assign wifi_gpio0 = 1'b1;

  asip_ecp5 #(
      .Clock      (75),
      .UartDivider(25),
      .PllFeedback(3),
      .PllOutput  (8)
  ) u_asip (
      .osc_i      (clk_25mhz),
      .button_ni  (btn_pwr_n),
      .rx_i       (ftdi_txd),
      .tx_o       (ftdi_rxd),
      .step_o     (step),
      .direction_o(direction),
      .a_i        (encoder_a),
      .b_i        (encoder_b),
      .z_i        (encoder_z),
      .alive_o    (led[0]),
      .held_o     (led[1]),
      .irq_o      (led[2])
  );

endmodule
