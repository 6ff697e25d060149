// SPDX-License-Identifier: Apache-2.0
// altpll: ports and parameters of the vendor's PLL as board_pll uses it, for tools that do not have it.
(* blackbox *)
module altpll #(
    parameter intended_device_family = "Stratix III",
    parameter lpm_type               = "altpll",
    parameter operation_mode         = "NORMAL",
    parameter pll_type               = "AUTO",
    parameter compensate_clock       = "CLK0",
    parameter inclk0_input_frequency = 20000,
    parameter width_clock            = 10,
    parameter clk0_multiply_by       = 1,
    parameter clk0_divide_by         = 1,
    parameter clk0_duty_cycle        = 50,
    parameter clk0_phase_shift       = "0",
    parameter port_inclk0            = "PORT_USED",
    parameter port_clk0              = "PORT_USED",
    parameter port_locked            = "PORT_USED"
) (
    input  wire [1:0]             inclk,
    output wire [width_clock-1:0] clk,
    output wire                   locked
);
endmodule
