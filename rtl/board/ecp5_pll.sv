// SPDX-License-Identifier: Apache-2.0
// ecp5_pll: core clock from the oscillator of an ECP5 board. The only part that knows the device.
// Contract: clk_o is osc_i x Feedback / Input; the oscillator of the PLL runs Output times as fast as clk_o,
// within 400..800 MHz (Lattice FPGA-TN-02200). locked_o is asynchronous. With macro ECP5 (set by
// scripts/bitstream.py) the device's EHXPLLL; without it a pass-through for lint and simulation: clk_o is
// osc_i itself and locked_o is always 1.
module ecp5_pll #(
    parameter int unsigned Input    = 1,
    parameter int unsigned Feedback = 4,
    parameter int unsigned Output   = 6
) (
    input  logic osc_i,
    output logic clk_o,
    output logic locked_o
);

`ifdef ECP5
  EHXPLLL #(
      .PLLRST_ENA      ("DISABLED"),
      .INTFB_WAKE      ("DISABLED"),
      .STDBY_ENABLE    ("DISABLED"),
      .DPHASE_SOURCE   ("DISABLED"),
      .OUTDIVIDER_MUXA ("DIVA"),
      .OUTDIVIDER_MUXB ("DIVB"),
      .OUTDIVIDER_MUXC ("DIVC"),
      .OUTDIVIDER_MUXD ("DIVD"),
      .CLKI_DIV        (Input),
      .CLKFB_DIV       (Feedback),
      .FEEDBK_PATH     ("CLKOP"),
      .CLKOP_ENABLE    ("ENABLED"),
      .CLKOP_DIV       (Output),
      .CLKOP_CPHASE    (Output - 1),
      .CLKOP_FPHASE    (0)
  ) u_pll (
      .CLKI        (osc_i),
      .CLKFB       (clk_o),
      .CLKOP       (clk_o),
      .LOCK        (locked_o),
      .RST         (1'b0),
      .STDBY       (1'b0),
      .PHASESEL0   (1'b0),
      .PHASESEL1   (1'b0),
      .PHASEDIR    (1'b0),
      .PHASESTEP   (1'b0),
      .PHASELOADREG(1'b0),
      .PLLWAKESYNC (1'b0),
      .ENCLKOP     (1'b0)
  );
`else
  localparam int unsigned UNUSED_RATIO = Input + Feedback + Output;

  assign clk_o    = osc_i;
  assign locked_o = UNUSED_RATIO != 0;
`endif

endmodule
