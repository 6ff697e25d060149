# SPDX-License-Identifier: Apache-2.0
"""Set-points of a whole program, one per control tick, in the path control that it asks for.

Moves under G61 and G64 are planned with look-ahead (sim/motion/lookahead/planner.py): corners under
G64 are rounded within P, the machine's limits are used. Moves under G61.1 are S-curves of set times
from rest to rest (exact_stop.py). A program may change between both; where it does, it stops.
G4 rests.

Number grid: controllers take set-points as binary32. Every set-point is on the grid of
`on_number_grid`: exact stops begin and end there, and every tick of the look-ahead is moved there
(by at most 30 nm). So an axis that rests or is held has no rounding error, neither itself nor as
its distance from a leg's base, which the controller's integrators would add up. Speed and
acceleration are continuous.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from asip_asm.project import ROOT
from sim.motion.geometry.curves import FloatArray, curve_of, to_si
from sim.motion.geometry.moves import Dwell, GcodeProgram, Motion, Move, Pose
from sim.motion.lookahead.joints import SlowestJoints
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import LookaheadSettings
from sim.motion.trajectory.exact_stop import (
    TICK_ROUNDING,
    MotionSettings,
    TooLongError,
    Trajectory,
    generate,
    on_number_grid,
)
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints

REST_AT_START = 0.1  # s, in which the controller settles
AGH = ROOT / "sim/paths/agh.ngc"
MOST_TICKS = 1_500_000  # of a program to be simulated, which needs some 2.5 kB a tick


@dataclass
class Corners:
    """What became of the places where two moves meet; rests of G4 [s]; the slowest rounded ones."""

    rounded: int = 0
    smooth: int = 0
    stops: int = 0
    rest: float = 0.0
    slowest: SlowestJoints = field(default_factory=SlowestJoints)


@dataclass(frozen=True, eq=False)
class Ticks:
    """Set-points of n consecutive ticks. Axes x, y, z, alpha, gamma; SI units.

    position, velocity, acceleration (n, 5) in m or rad and per s, per s^2; move (n,): number of
    the move under way, -1 during the rest at the start.
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    move: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.position)

    def first(self, count: int) -> Ticks:
        """The first so many."""
        return Ticks(*(values[:count] for values in vars(self).values()))


@dataclass(frozen=True, eq=False)
class ProgramPath(Ticks):
    """All ticks of a program, or its first ones; `move` is a number in `moves`.

    period [s]; rest: ticks of that at the start; whole: False where the program goes on behind the
    last tick.
    """

    period: float
    moves: tuple[Move, ...]
    rest: int
    whole: bool
    corners: Corners

    @property
    def time(self) -> float:
        """Duration of the path [s], without the rest at the start."""
        return max(0, len(self) - 1 - self.rest) * self.period

    @property
    def drawing(self) -> NDArray[np.bool_]:
        """Whether a tick (n,) is of a move at a feed rate, not of a rapid one."""
        feed: NDArray[np.bool_] = np.array([move.motion is not Motion.RAPID for move in self.moves])
        drawn: NDArray[np.bool_] = feed[self.move]
        return np.asarray(drawn & (self.move >= 0))

    @property
    def exact_stop(self) -> NDArray[np.bool_]:
        """Whether a tick (n,) is of a move under G61.1."""
        exact: NDArray[np.bool_] = np.array([move.exact_stop for move in self.moves])
        stops: NDArray[np.bool_] = exact[self.move]
        return np.asarray(stops & (self.move >= 0))


def plan(program: GcodeProgram, robot: Robot, ticks: int | None = None) -> ProgramPath:
    """Set-points from rest at the program's start to rest at its end; only the first `ticks`.

    Raises WorkspaceError and OutsideError for a motion that leaves the workspace, TooLongError for
    more than MOST_TICKS ticks, ValueError for a program without any motion.
    """
    first = next((move for move in program.moves if curve_of(move) is not None), None)
    if first is None:
        raise ValueError(
            f"{program.file}: error: the program has no motion; expected a move such as G0 X10"
        )
    corners = Corners()
    rest = math.ceil(REST_AT_START / robot.T_s - TICK_ROUNDING)
    most = MOST_TICKS if ticks is None else min(ticks, MOST_TICKS)
    parts, count, whole = [], 0, True
    most_time = math.inf if ticks is not None and ticks <= MOST_TICKS else MOST_TICKS * robot.T_s
    for part in _parts(program, robot, first, rest, corners, most_time):
        if count + len(part) > most:
            if most_time < math.inf:
                raise _too_long(program, robot, int(part.move[0]))
            part = part.first(most - count)
            whole = False
        parts.append(part)
        count += len(part)
        if not whole:
            break
    return ProgramPath(
        position=np.concatenate([part.position for part in parts]),
        velocity=np.concatenate([part.velocity for part in parts]),
        acceleration=np.concatenate([part.acceleration for part in parts]),
        move=np.concatenate([part.move for part in parts]),
        period=robot.T_s,
        moves=program.moves,
        rest=min(rest, count),
        whole=whole,
        corners=corners,
    )


def _too_long(program: GcodeProgram, robot: Robot, number: int) -> TooLongError:
    move = program.moves[number]
    return TooLongError(
        f"{program.file}:{move.line}: error: the motion is too long to be simulated; got more than "
        f"{MOST_TICKS * robot.T_s:g} s up to here; expected at most that\n"
        f"{move.line:5d} |   {move.source}\n"
        "      |   help: check F, or take only its beginning: --ticks 100000"
    )


def _parts(
    program: GcodeProgram, robot: Robot, first: Move, rest: int, corners: Corners, most_time: float
) -> Iterator[Ticks]:
    """The ticks of the whole program; the last part is the last tick, at rest at the end.

    Raises TooLongError before the ticks of a stretch of motion are made that exceeds most_time [s].
    """
    here = on_number_grid(to_si(first.start))
    yield _at_rest(here, rest, -1)
    last = -1
    for exact, group in groupby(_numbered(program), key=lambda entry: entry[0]):
        items = [entry[1:] for entry in group]
        corners.stops += last >= 0
        if exact:
            section = _exact_stops(program.file, items, robot, corners)
        else:
            section = _looking_ahead(program, items, robot, corners, most_time)
        for part in section:
            yield part
            last = int(part.move[-1])
        here = on_number_grid(to_si(items[-1][1]))
    yield _at_rest(here, 1, last)


_Item = tuple[int, Pose, Move | Dwell]


def _numbered(program: GcodeProgram) -> Iterator[tuple[bool, int, Pose, Move | Dwell]]:
    """Moves and rests in order: whether under G61.1, number of the move, pose behind it, item.

    A rest belongs to the moves before it, or to the first one.
    """
    dwells = list(program.dwells)
    exact, number, pose = program.moves[0].exact_stop, 0, program.moves[0].start
    for number, move in enumerate(program.moves):
        while dwells and dwells[0][0] <= number:
            yield exact, max(number - 1, 0), pose, dwells.pop(0)[1]
        exact, pose = move.exact_stop, move.end
        yield exact, number, pose, move
    for _, dwell in dwells:
        yield exact, number, pose, dwell


def _at_rest(pose: FloatArray, ticks: int, number: int) -> Ticks:
    rest, zero = np.broadcast_to(pose, (ticks, 5)), np.broadcast_to(0.0, (ticks, 5))
    return Ticks(rest, zero, zero, np.broadcast_to(number, ticks))


def _resting(pose: Pose, seconds: float, period: float, number: int) -> Ticks:
    ticks = math.ceil(min(seconds / period - TICK_ROUNDING, MOST_TICKS + 1))
    return _at_rest(on_number_grid(to_si(pose)), ticks, number)


def _exact_stops(file: str, items: list[_Item], robot: Robot, corners: Corners) -> Iterator[Ticks]:
    """The ticks of moves and rests under G61.1, without the last one."""
    settings = MotionSettings(robot, lead_in=0.0)
    for _, group in groupby(items, key=lambda item: isinstance(item[2], Dwell)):
        moving_moves: list[tuple[int, Move]] = []
        for number, pose, item in group:
            if isinstance(item, Dwell):
                corners.rest += item.seconds
                yield _resting(pose, item.seconds, robot.T_s, number)
            elif curve_of(item) is not None:
                moving_moves.append((number, item))
        if not moving_moves:
            continue
        numbers = np.array([number for number, _ in moving_moves])
        moves = tuple(move for _, move in moving_moves)
        part = GcodeProgram(file, moves[0].start, moves)
        found = generate(part, settings, most_ticks=MOST_TICKS)
        moving = found.velocity[found.first_ticks[1:-1]].any(axis=1)
        corners.smooth += int(moving.sum())
        corners.stops += int((~moving).sum())
        yield Ticks(
            found.position[:-1],
            found.velocity[:-1],
            found.acceleration[:-1],
            numbers[found.block][:-1],
        )


def _looking_ahead(
    program: GcodeProgram, items: list[_Item], robot: Robot, corners: Corners, most_time: float
) -> Iterator[Ticks]:
    """The ticks of moves and rests under G61 and G64, without the last one."""
    settings = LookaheadSettings(robot=robot)
    numbers = np.array([n for n, _, item in items if isinstance(item, Move)])
    rests = [item.seconds for _, _, item in items if isinstance(item, Dwell)]
    corners.rest += math.fsum(rests)
    lookahead = Lookahead((item for _, _, item in items), settings, corners.slowest, program.file)
    held = None  # the last one is the last tick
    try:
        for points in lookahead.setpoints():
            if held is not None:
                position = on_number_grid(held.position)
                yield Ticks(position, held.velocity, held.acceleration, numbers[held.move])
            held = points
            if lookahead.summary.duration > most_time:
                raise _too_long(program, robot, int(numbers[points.move[0]]))
    finally:  # also where the caller takes only the first ticks
        summary = lookahead.summary
        corners.rounded += summary.blends + summary.turns
        corners.smooth += summary.smooth
        corners.stops += summary.stops
    if held is None:  # rests alone
        number, pose, _ = items[0]
        yield _resting(pose, math.fsum(rests), robot.T_s, number)


def set_points(trajectory: Trajectory | ProgramPath, ticks: int | None = None) -> SetPoints:
    """The first `ticks` set-points of a trajectory, None: all."""
    whole = (trajectory.position, trajectory.velocity, trajectory.acceleration)
    parts = [part[:ticks] for part in whole]
    return SetPoints(*(part[:, :3] for part in parts), *(part[:, 3:] for part in parts))
