# SPDX-License-Identifier: Apache-2.0
"""cocotb tests of the project's hardware: builds for Verilator and Icarus, drivers, golden models.

docs/cocotb.md shows how to use it. `Simulation` and `run` belong outside of the simulator, the
drivers of `asip`, `custom` and `unit` inside, `golden` on both sides.
"""
