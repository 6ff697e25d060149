# SPDX-License-Identifier: Apache-2.0
"""Command asip-run: a program on the Verilated core or on the instruction-set model."""
