# SPDX-License-Identifier: Apache-2.0
"""Records of moves for `asip_asm/programs/path_set_points.s`, made of a planned path.

The host does the geometry once per move, in double precision: stops on the number grid, lengths,
speeds slowed down to whole ticks, radius vectors. The core does everything of every tick.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.curves import MISSES, Arc, Block, Spiral, TurnedArc
from sim.motion.planner.scurve import SCurve
from sim.motion.trajectory.exact_stop import MotionSettings, Trajectory, on_number_grid

FloatArray = NDArray[np.float64]
RECORD_WORDS = 32
RING_RECORDS = 32


class PathNotSuitedError(ValueError):
    """The path has something that no record can say; names file position and cause."""


@dataclass(frozen=True, eq=False)
class Move:
    """A straight move or arc from rest to rest, SI units; the words of a record in its order.

    duration [ticks]; v0, vm, tr, tm, length of the S-curve; half_turn: half the angle turned per
    unit of length [rad]; start, end, direction (5,); radius vectors and normal (3,), zero for a
    straight move.
    """

    duration: int
    v0: float
    vm: float
    tr: float
    tm: float
    length: float
    half_turn: float
    start: FloatArray
    end: FloatArray
    direction: FloatArray
    radius_start: FloatArray
    radius_end: FloatArray
    normal: FloatArray

    def words(self) -> NDArray[np.uint32]:
        """The record, (32,): the duration as integer, the rest as binary32."""
        words = np.zeros(RECORD_WORDS, dtype=np.uint32)
        words[0], *numbers = vars(self).values()  # in the order of the fields
        values = np.hstack(numbers).astype(np.float32)
        words[1 : 1 + len(values)] = values.view(np.uint32)
        return words


def rest(pose: FloatArray, duration: int) -> Move:
    """Rest of so many ticks at a pose (5,); the S-curve of a unit leads nowhere."""
    none = np.zeros(3)
    return Move(duration, 0.0, 1.0, 1.0, 0.5, 1.0, 0.0, pose, pose, np.zeros(5), none, none, none)


def _move(block: Block, ticks: int, settings: MotionSettings) -> Move:
    curve = block.curve
    ends = curve.evaluate(np.array([0.0, curve.length]))[0]
    start, end = on_number_grid(ends[0]), on_number_grid(ends[1])
    tr, tm = settings.acceleration_time, settings.jerk_time
    total = SCurve(0.0, block.speed, tr, tm, curve.length).total_time
    stretch = ticks * settings.period / total
    way, half_turn = end - start, 0.0
    radius_start, radius_end, normal = np.zeros(3), np.zeros(3), np.zeros(3)
    flat = curve.flat if isinstance(curve, TurnedArc) else curve
    if isinstance(flat, Spiral):
        move = block.move
        raise PathNotSuitedError(
            f"line {move.line}: the radii at both ends of an arc differ by "
            f"{abs(flat.growth) * 1e3:.4f} mm; expected {MISSES * 1e3:g} mm at most; correct the "
            "end or the centre"
        )
    if isinstance(curve, Arc):
        first, second = curve.axes
        half_turn = curve.sweep / curve.length / 2.0
        for radius, angle in (
            (radius_start, curve.first_angle),
            (radius_end, curve.first_angle + curve.sweep),
        ):
            radius[first] = curve.radius * np.cos(angle)
            radius[second] = curve.radius * np.sin(angle)
        normal[3 - first - second] = 1.0 if (second - first) % 3 == 1 else -1.0
        if isinstance(curve, TurnedArc):
            radius_start, radius_end, normal = (
                curve.turn.turned_rows(np.array([[*vector, 0.0, 0.0]]))[0, :3]
                for vector in (radius_start, radius_end, normal)
            )
        way[:3] -= radius_end - radius_start
    return Move(
        duration=ticks,
        v0=0.0,
        vm=block.speed / stretch,
        tr=tr * stretch,
        tm=tm * stretch,
        length=curve.length,
        half_turn=half_turn,
        start=start,
        end=end,
        direction=way / curve.length,
        radius_start=radius_start,
        radius_end=radius_end,
        normal=normal,
    )


def moves_of(trajectory: Trajectory, settings: MotionSettings) -> tuple[Move, ...]:
    """Moves of a whole trajectory made with the same settings: the rest at its start, every block.

    Raises PathNotSuitedError at a block that does not begin at rest: blocks that run into one
    another share an S-curve, which a record does not know.
    """
    firsts = trajectory.first_ticks
    moves = [rest(trajectory.position[0], int(firsts[0]))] if firsts[0] else []
    for i, block in enumerate(trajectory.blocks):
        if np.any(trajectory.velocity[firsts[i]] != 0.0):
            raise PathNotSuitedError(
                f"line {block.move.line}: error: the move before runs into this one without a "
                f"stop; got {block.move.source.strip()!r}; expected moves from rest to rest: "
                "join them to one move, or let them meet at an angle"
            )
        moves.append(_move(block, int(firsts[i + 1] - firsts[i]), settings))
    return tuple(moves)
