# SPDX-License-Identifier: Apache-2.0
"""A board of `microtick bitstream` without the board: its Verilated top, a serial port as device.

python -m sim.rtl.board ulx3s
"""
