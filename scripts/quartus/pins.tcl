# SPDX-License-Identifier: Apache-2.0
# Ports of asip_de3 that are real pins of the DE3: {port location I/O standard}. An empty location is left to
# the fitter, which is right for area and timing but not for a board: `build.tcl board` refuses it. The numbers
# are those of the board's manual, as PIN_A1; its System Builder writes them. Both pins are in banks of 2.5 V
# unless the manual of the board's revision says otherwise.
set real_pins {
    {OSC1_50  "" "2.5 V"}
    {BUTTON_N "" "2.5 V"}
}
