# SPDX-License-Identifier: Apache-2.0
"""Compiler of control laws: from a `casadi.Function` to a program in linear assembly.

read -> Graph of real operations -> passes (simplify, functions, sums) -> Graph of core operations
-> emit. Every pass maps a graph to a graph; `compile_law` in `compiler` runs them.
"""
