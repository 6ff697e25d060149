# SPDX-License-Identifier: Apache-2.0
"""GDB's remote serial protocol for the Nios II systems, through the debug module of the RTL.

packets (framing) -> session (commands) -> target (program: registers, memory, breakpoints)
-> module (registers of rtl/nios/n2_debug.sv). system is the simulation around them, server has the
connection and lets time pass.
"""
