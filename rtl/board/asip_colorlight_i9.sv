// SPDX-License-Identifier: Apache-2.0
// asip_colorlight_i9: asip_ecp5 on a Colorlight i9 v7.2 (LFE5U-45F-6BG381C) in Muse Lab's extension board.
// Pins: asip_colorlight_i9.lpf.
// Contract: core clock 75 MHz from the 25 MHz oscillator; the serial line is that of the extension board's
// debug probe, 115 200 bit/s after reset; the extension board's button resets. led_n is low every other 2^25
// clocks while the core is alive.
module asip_colorlight_i9 (
    input  logic       clk_25mhz,
    input  logic       reset_n,
    input  logic       uart_rx,
    output logic       uart_tx,
    output logic       led_n,
    output logic [4:0] step,
    output logic [4:0] direction,
    input  logic [4:0] encoder_a,
    input  logic [4:0] encoder_b,
    input  logic [4:0] encoder_z
);

  logic alive;
  logic unused_held, unused_irq;

  assign led_n = !alive;

  asip_ecp5 #(
      .Clock      (75),
      .UartDivider(651),
      .PllFeedback(3),
      .PllOutput  (8)
  ) u_asip (
      .osc_i      (clk_25mhz),
      .button_ni  (reset_n),
      .rx_i       (uart_rx),
      .tx_o       (uart_tx),
      .step_o     (step),
      .direction_o(direction),
      .a_i        (encoder_a),
      .b_i        (encoder_b),
      .z_i        (encoder_z),
      .alive_o    (alive),
      .held_o     (unused_held),
      .irq_o      (unused_irq)
  );

endmodule
