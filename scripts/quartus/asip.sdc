# SPDX-License-Identifier: Apache-2.0
# Timing constraints of asip_de3 (TimeQuest, Quartus II 13.1).

# The board's oscillator. The PLL's 125 MHz clock (x 5/2) follows from it; jitter and skew of both
# come from the device model.
create_clock -name osc_50 -period 20.000 [get_ports {OSC1_50}]
derive_pll_clocks
derive_clock_uncertainty

# The button and the PLL's lock signal only reach the asynchronous clears of the reset synchroniser.
# Its release (rst_nq to every clear of the core) stays timed as recovery and removal.
set_false_path -to [get_pins -compatibility_mode {release_q|clrn rst_nq|clrn}]
set_false_path -from [get_ports {BUTTON_N}]

# Virtual pins stand for the host's bus interconnect, which is not part of this design. It is taken to work with
# the core clock and to use a quarter of its period on each side. Its clock is a virtual one, so the Fmax of the
# core clock remains that of the paths between registers of the core.
set bus_period 8.000
set bus_delay  2.000
create_clock -name bus -period $bus_period
set bus_inputs  [get_ports {address_i[*] read_i write_i writedata_i[*]}]
set bus_outputs [get_ports {readdata_o[*] waitrequest_o irq_o}]
set_input_delay  -clock bus -max $bus_delay $bus_inputs
set_input_delay  -clock bus -min 0.000      $bus_inputs
set_output_delay -clock bus -max $bus_delay $bus_outputs
set_output_delay -clock bus -min 0.000      $bus_outputs
