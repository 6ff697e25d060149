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

# Virtual pins stand for the host's bus interconnect, which is not part of this design: what is
# measured is register to register. Paths of the bus must be timed in the system that holds the host.
set_false_path -from [get_ports {address_i[*] read_i write_i writedata_i[*]}]
set_false_path -to [get_ports {readdata_o[*] waitrequest_o irq_o}]
