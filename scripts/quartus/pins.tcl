# SPDX-License-Identifier: Apache-2.0
# Ports of asip_de3 that are real pins of the DE3: {port location}. An empty location is left to the
# fitter, which is right for area and timing but not for a board: fill in the numbers of the board's
# manual (System Builder writes them) before a device is configured.
set real_pins {
    {OSC1_50  ""}
    {BUTTON_N ""}
}
