# SPDX-License-Identifier: Apache-2.0
"""A board of `make bitstream` without the board: its Verilated top, its serial port as a device.

python -m sim.rtl.board ulx3s
"""
