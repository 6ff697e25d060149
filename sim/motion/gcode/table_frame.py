# SPDX-License-Identifier: Apache-2.0
"""Coordinates of the table (G43.4): the tool point follows the work piece as the table turns.

The table tilts by A about the x axis through PIVOT and turns by C about its own z axis, which
goes through PIVOT too (robot specification, eq. 17: the table centre is at Rx(A) (0, 0, h) from
there). A point p of the frame, which coincides with the machine's at A0 C0, is at

  m = PIVOT + Rx(A) Rz(C) (p - PIVOT)

PIVOT is that of the robot (`sim.motion.geometry.workspace.pivot_of`): the centre of the level
table is where a program starts.
"""

from __future__ import annotations

import math

import numpy as np

from sim.motion.geometry.curves import Arc, curve_of, to_si
from sim.motion.geometry.moves import Move, Pose

Point = tuple[float, float, float]
TOLERANCE_MM = 0.0005  # error of the chords that replace the tool's curve in the machine
MAX_PIECES = 100_000


class TooManyPiecesError(ValueError):
    """A move needs more than MAX_PIECES chords."""


def _turned(u: float, v: float, degree: float) -> tuple[float, float]:
    """A point of a plane, turned about its origin."""
    cos, sin = math.cos(math.radians(degree)), math.sin(math.radians(degree))
    return u * cos - v * sin, u * sin + v * cos


def to_machine(pose: Pose, pivot: Point) -> Pose:
    """Machine pose [mm, degree] of a pose in the frame of the table; pivot [mm]."""
    x, y, z = (value - middle for value, middle in zip(pose[:3], pivot, strict=True))
    x, y = _turned(x, y, pose[4])
    y, z = _turned(y, z, pose[3])
    return (x + pivot[0], y + pivot[1], z + pivot[2], pose[3], pose[4])


def from_machine(pose: Pose, pivot: Point) -> Pose:
    """Pose in the frame of the table of a machine pose [mm, degree]; pivot [mm]."""
    x, y, z = (value - middle for value, middle in zip(pose[:3], pivot, strict=True))
    y, z = _turned(y, z, -pose[3])
    x, y = _turned(x, y, -pose[4])
    return (x + pivot[0], y + pivot[1], z + pivot[2], pose[3], pose[4])


def pieces(move: Move, pivot: Point) -> list[Pose]:
    """Ends, as machine poses, of the pieces of a move given in the frame of the table.

    A chord of share h of a curve m misses it by at most h^2/8 max|m''|; here m'' is at most
    |bend| + 2 |w| |way| + |w|^2 r, w the table's turn and r the distance from the pivot. Raises
    TooManyPiecesError.
    """
    curve = curve_of(move)
    if curve is None:
        return [to_machine(move.end, pivot)]
    start, end = to_si(move.start), to_si(move.end)
    turn = float(np.abs(end[3:] - start[3:]).sum())
    arc = curve if isinstance(curve, Arc) else None
    if turn == 0.0 and arc is None:
        return [to_machine(move.end, pivot)]
    bend = arc.radius * arc.sweep**2 if arc else 0.0
    way = arc.length if arc else float(np.linalg.norm((end - start)[:3]))
    middle = np.array(pivot) / 1e3
    reach = max(float(np.linalg.norm(pose[:3] - middle)) for pose in (start, end))
    reach += 2 * arc.radius if arc else 0.0
    second = bend + 2 * turn * way + turn * turn * reach
    count = math.ceil(math.sqrt(second / (8 * TOLERANCE_MM / 1e3)))
    count = max(count, 1)
    if count > MAX_PIECES:
        raise TooManyPiecesError(f"{count} chords")
    points = curve.evaluate(curve.length * np.arange(1, count) / count)[0]
    poses = ((*(p[:3] * 1e3).tolist(), *np.degrees(p[3:]).tolist()) for p in points)
    return [*(to_machine(pose, pivot) for pose in poses), to_machine(move.end, pivot)]
