// SPDX-License-Identifier: Apache-2.0
// board_pll: 125 MHz core clock from the 50 MHz oscillator. The only part of it that knows the vendor.
// Contract: with macro QUARTUS (set by scripts/quartus/build.tcl) an altpll of Stratix III, VCO
// within 600..1300 MHz by choice of the tool, ratio 5/2; locked_o is asynchronous. Without it a
// pass-through for lint and simulation: clk_o is osc_i itself and locked_o is always 1.
module board_pll (
    input  logic osc_i,
    output logic clk_o,
    output logic locked_o
);

`ifdef QUARTUS
  logic [9:0] clocks;

  altpll #(
      .intended_device_family("Stratix III"),
      .lpm_type              ("altpll"),
      .operation_mode        ("NORMAL"),
      .pll_type              ("AUTO"),
      .compensate_clock      ("CLK0"),
      .inclk0_input_frequency(20000),  // ps
      .width_clock           (10),
      .clk0_multiply_by      (5),
      .clk0_divide_by        (2),
      .clk0_duty_cycle       (50),
      .clk0_phase_shift      ("0"),
      .port_inclk0           ("PORT_USED"),
      .port_clk0             ("PORT_USED"),
      .port_locked           ("PORT_USED")
  ) u_altpll (
      .inclk ({1'b0, osc_i}),
      .clk   (clocks),
      .locked(locked_o)
  );
  assign clk_o = clocks[0];
`else
  assign clk_o    = osc_i;
  assign locked_o = 1'b1;
`endif

endmodule
