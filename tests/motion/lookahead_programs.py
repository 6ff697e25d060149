# SPDX-License-Identifier: Apache-2.0
"""Random programs of short segments, and paths with known answers, for the look-ahead tests."""

import math

import numpy as np

from sim.motion.gcode import Motion, Move, Plane
from sim.motion.lookahead import Lookahead, LookaheadSettings, Setpoints

TOLERANCES = (0.0, math.inf, 1e-6, 0.001, 0.005, 0.01, 0.025, 0.1, 1.0)  # mm
LOW = np.array([-140.0, -140.0, 460.0, -80.0, -1e4])
HIGH = np.array([140.0, 140.0, 740.0, 80.0, 1e4])


def random_moves(seed: int, count: int) -> list[Move]:
    """Lines and arcs of 0.01 to 15 mm with or without the table, repeats and reversals included."""
    rng = np.random.default_rng(seed)
    size, turn = 10 ** rng.uniform(-2, 1.2), 10 ** rng.uniform(-2, 0.5)
    five, arcs = rng.random() < 0.5, rng.random() < 0.3
    tolerance = TOLERANCES[rng.integers(len(TOLERANCES))]
    place, direction = np.array([0.0, 0.0, 600.0, 0.0, 0.0]), rng.normal(size=5)
    moves = []
    for line in range(1, count + 1):
        direction = direction + turn * rng.normal(size=5)
        direction /= np.linalg.norm(direction[:3])
        way = direction * size * rng.uniform(0.1, 1) * (1.0 if five else np.array([1, 1, 1, 0, 0]))
        kind = rng.random()
        if kind < 0.04:
            way = -way if kind < 0.02 else 0 * way
        end = np.clip(place + way, LOW, HIGH)
        feed = float(10 ** rng.uniform(2, 4.5)) if rng.random() < 0.1 else 15000.0
        start, finish = tuple(place.tolist()), tuple(end.tolist())
        chord = end[:2] - place[:2]
        if arcs and rng.random() < 0.3 and np.abs(place[:2]).max() < 100 and chord @ chord > 1e-6:
            height = rng.uniform(0.05, 1) * np.array([-chord[1], chord[0]])
            centre = tuple((place[:2] + chord / 2 + height).tolist())
            motion = Motion.ARC_CCW if rng.random() < 0.9 else Motion.ARC_CW
            moves.append(Move(line, "", motion, start, finish, feed, Plane.XY, centre, tolerance))
        elif rng.random() < 0.05:
            moves.append(Move(line, "", Motion.RAPID, start, finish, tolerance=tolerance))
        else:
            moves.append(Move(line, "", Motion.LINEAR, start, finish, feed, tolerance=tolerance))
        place = end
    return moves


def sampled(moves, settings: LookaheadSettings, joints=None) -> tuple[Setpoints, Lookahead]:
    """All set-points of moves as one block, and the run."""
    run = Lookahead(iter(moves), settings, joints)
    blocks = list(run.setpoints())
    ticks = np.cumsum([0, *(len(block) for block in blocks)])
    assert [block.first for block in blocks] == ticks[:-1].tolist()
    columns = ("position", "velocity", "acceleration", "line")
    return Setpoints(
        0, *(np.concatenate([getattr(block, name) for block in blocks]) for name in columns)
    ), run


def distance_to_polyline(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distance (n,) of points (n, d) from the line through the corners (m, d)."""
    best = np.full(len(points), np.inf)
    for a, b in zip(corners[:-1], corners[1:], strict=True):
        way = b - a
        square = way @ way
        share = np.clip((points - a) @ way / square, 0, 1) if square else np.zeros(len(points))
        best = np.minimum(best, np.linalg.norm(points - a - share[:, None] * way, axis=1))
    return best
