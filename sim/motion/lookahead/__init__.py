# SPDX-License-Identifier: Apache-2.0
"""Look-ahead with blended corners: moves in, set-points out (`planner.Lookahead`), any length.

Stages: `segments`, `joints`, `elements`, `limits`, `speed`. `check` measures set-points without the
plan, `stress` makes random programs. Run: python -m sim.motion.lookahead part.ngc
"""
