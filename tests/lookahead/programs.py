# SPDX-License-Identifier: Apache-2.0
"""Runs and distances for the look-ahead tests."""

from itertools import pairwise

import numpy as np

from sim.motion.lookahead.check import from_line
from sim.motion.lookahead.planner import Lookahead, Setpoints
from sim.motion.lookahead.settings import LookaheadSettings


def sampled(moves, settings: LookaheadSettings, joints=None) -> tuple[Setpoints, Lookahead]:
    """All set-points of moves as one block, and the run."""
    run = Lookahead(iter(moves), settings, joints)
    blocks = list(run.setpoints())
    ticks = np.cumsum([0, *(len(block) for block in blocks)])
    assert [block.first for block in blocks] == ticks[:-1].tolist()
    columns = ("position", "velocity", "acceleration", "line", "move")
    return Setpoints(
        0, *(np.concatenate([getattr(block, name) for block in blocks]) for name in columns)
    ), run


def distance_to_polyline(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distance (n,) of points (n, d) from the line through the corners (m, d)."""
    return np.min([from_line(points, a, b) for a, b in pairwise(corners)], axis=0)
