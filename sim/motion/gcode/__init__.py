# SPDX-License-Identifier: Apache-2.0
"""Reader of G-code (RS274/NGC): `interpreter` makes moves of a text; its header names the parts.

`tools` reads tool tables, `oracle` compares with LinuxCNC's interpreter. What is accepted:
docs/gcode.md. Run: python -m sim.motion.gcode.oracle part.ngc
"""
