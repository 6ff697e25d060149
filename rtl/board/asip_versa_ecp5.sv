// SPDX-License-Identifier: Apache-2.0
// asip_versa_ecp5: asip_ecp5 with three axes on Lattice's ECP5-5G Versa board (LFE5UM5G-45F-8BG381C).
// Pins: asip_versa_ecp5.lpf.
// Contract: core clock 100 MHz from the 100 MHz oscillator; the serial line is that of the board's USB bridge
// FT2232H, 3 Mbit/s after reset; the reset button resets. led_n is low when lit: 0 alive, 1 held by the debug
// block, 2 done or a fault.
module asip_versa_ecp5 (
    input  logic       clk_100mhz,
    input  logic       reset_n,
    input  logic       uart_rx,
    output logic       uart_tx,
    output logic [2:0] led_n,
    output logic [2:0] step,
    output logic [2:0] direction,
    input  logic [2:0] encoder_a,
    input  logic [2:0] encoder_b,
    input  logic [2:0] encoder_z
);

  logic [2:0] led;

  assign led_n = ~led;

  asip_ecp5 #(
      .Axes       (3),
      .PllFeedback(1)
  ) u_asip (
      .osc_i      (clk_100mhz),
      .button_ni  (reset_n),
      .rx_i       (uart_rx),
      .tx_o       (uart_tx),
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
