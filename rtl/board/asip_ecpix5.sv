// SPDX-License-Identifier: Apache-2.0
// asip_ecpix5: asip_ecp5 on an ECPIX-5 (LambdaConcept; LFE5UM5G-85F-8BG554I). Pins: asip_ecpix5.lpf.
// Contract: core clock 100 MHz from the 100 MHz oscillator; the serial line is that of the board's USB bridge
// FT2232H, 3 Mbit/s after reset; the reset button resets. Lamps are low when lit: green alive, blue held by
// the debug block, red done or a fault.
module asip_ecpix5 (
    input  logic       clk_100mhz,
    input  logic       reset_n,
    input  logic       uart_rx,
    output logic       uart_tx,
    output logic       red_n,
    output logic       green_n,
    output logic       blue_n,
    output logic [4:0] step,
    output logic [4:0] direction,
    input  logic [4:0] encoder_a,
    input  logic [4:0] encoder_b,
    input  logic [4:0] encoder_z
);

  logic alive, held, irq;

  assign green_n = !alive;
  assign blue_n  = !held;
  assign red_n   = !irq;

  asip_ecp5 #(
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
      .alive_o    (alive),
      .held_o     (held),
      .irq_o      (irq)
  );

endmodule
