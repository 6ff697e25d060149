# SPDX-License-Identifier: Apache-2.0
"""Set-points of a program with exact stops (G61.1), one per control tick.

Stops: the tool stops exactly at the end of every block. The only exception is a joint at which the
path continues with the same direction, the same curvature and the same speed limit (a line cut into
pieces, a circle cut into arcs that carry the table axes on at the same rate); such blocks form one
chain with one S-curve. A tangent joint of a line and an arc is a stop, because its curvature jumps
and with it the centripetal acceleration. So position, velocity and acceleration of the five axes
are continuous everywhere.

Ticks: each chain is slowed down by less than one tick over its whole duration to last a whole
number of ticks, so it begins and ends on a tick. A block inside a chain begins at the first tick
that is on it.

Number grid: controllers take set-points as binary32. Every stop is moved to the nearest pose of a
grid of 2^-24 m (by at most 30 nm) and binary32 angles, and the chain between two stops is shifted
linearly along its length to meet them. So an axis that rests or is held has no rounding error,
neither itself nor as its distance from a leg's base, which the controller's integrators would add
up.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.curves import Block, FloatArray, RateLimits, build_path, check_positive
from sim.motion.geometry.moves import GcodeProgram
from sim.motion.geometry.workspace import GRID, NAMES, Workspace, shown
from sim.motion.planner.scurve import SCurve
from sim.robot.parameters import Robot

AXIS_NAMES = ("x", "y", "z", "alpha", "gamma")

# Joint of a chain: largest difference of a unit direction's component and, relative to the
# curvature, of the second derivative. Only rounding is let through: a velocity step of 1e-10 m/s
# at 0.1 m/s.
JOINT_TOLERANCE = 1e-9

# Excess over a whole number of ticks that is rounding of the duration and needs no further tick.
TICK_ROUNDING = 1e-9

# Greatest number of set-points, which are all held in memory: some 5 GB while they are made.
MOST_TICKS = 20_000_000
BLOCK = 20_000  # most set-points made together


class WorkspaceError(ValueError):
    """A set-point is outside the workspace. file, line: the block; tick, axis, value, limit."""

    def __init__(
        self, file: str, line: int, source: str, tick: int, axis: int, value: float, limit: float
    ) -> None:
        self.file, self.line, self.tick = file, line, tick
        self.axis, self.value, self.limit = NAMES[axis], value, limit
        relation = ">=" if value < limit else "<="
        super().__init__(
            f"{file}:{line}: error: tick {tick} leaves the workspace; "
            f"got {self.axis} = {shown(axis, value, '.4f')}; expected {self.axis} {relation} "
            f"{shown(axis, limit)}\n"
            f"{line:5d} |   {source}"
        )


class TooLongError(ValueError):
    """A trajectory would have more than MOST_TICKS set-points; names the block that takes most."""


@dataclass(frozen=True)
class MotionSettings:
    """How a program is run: robot, S-curve times [s], rates, rest at the start [s].

    rates: None means the table's limit of the robot. 0 < jerk_time <= acceleration_time/2
    keeps the acceleration continuous; anything else raises ValueError.
    """

    robot: Robot = field(default_factory=Robot.load)
    acceleration_time: float = 0.36
    jerk_time: float = 0.18
    rates: RateLimits | None = None
    lead_in: float = 0.1

    @property
    def period(self) -> float:
        """Control period of the robot [s]."""
        return self.robot.T_s

    def __post_init__(self) -> None:
        if self.rates is None:
            object.__setattr__(self, "rates", RateLimits(table=self.robot.v_max_table))
        check_positive(acceleration_time=self.acceleration_time, jerk_time=self.jerk_time)
        if self.jerk_time > self.acceleration_time / 2:
            raise ValueError(
                f"jerk_time = {self.jerk_time!r} is outside its limit: "
                f"jerk_time <= acceleration_time/2 = {self.acceleration_time / 2!r}"
            )
        if not (self.lead_in >= 0.0 and math.isfinite(self.lead_in)):
            raise ValueError(f"lead_in = {self.lead_in!r} is outside its limit: lead_in >= 0")


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Set-points of n ticks. Axes x, y, z, alpha, gamma; SI units.

    t (n,) [s]; position, velocity, acceleration (n, 5) in m or rad and per s, per s^2;
    block (n,) index into blocks of the block under way, -1 during the rest at the start;
    first_ticks (blocks + 1,): blocks[i] covers ticks first_ticks[i] .. first_ticks[i + 1] - 1,
    the last entry is the last tick, at rest.
    """

    t: FloatArray
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    block: NDArray[np.int64]
    blocks: tuple[Block, ...]
    first_ticks: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.t)


def _joins(before: Block, after: Block) -> bool:
    """Whether the path may run through the joint of two blocks without a stop."""
    if not math.isclose(before.speed, after.speed, rel_tol=JOINT_TOLERANCE):
        return False
    _, direction, bend = before.curve.evaluate(np.array([before.curve.length]))
    _, next_direction, next_bend = after.curve.evaluate(np.array([0.0]))
    scale = max(1.0, float(np.max(np.abs(bend))))
    return (
        float(np.max(np.abs(next_direction - direction))) <= JOINT_TOLERANCE
        and float(np.max(np.abs(next_bend - bend))) <= JOINT_TOLERANCE * scale
    )


def chains_of(blocks: Iterable[Block]) -> Iterator[list[Block]]:
    """Blocks that are run without a stop between them, together."""
    chain: list[Block] = []
    for block in blocks:
        if chain and not _joins(chain[-1], block):
            yield chain
            chain = []
        chain.append(block)
    if chain:
        yield chain


def on_number_grid(pose: FloatArray) -> FloatArray:
    """The nearest pose of whole multiples of `GRID` and binary32 angles, (..., 5) in m and rad."""
    angles = pose[..., 3:].astype(np.float32).astype(np.float64)
    return np.concatenate([np.rint(pose[..., :3] / GRID) * GRID, angles], axis=-1)


def _ends(chain: Sequence[Block]) -> FloatArray:
    """Lengths run at the ends of the blocks of a chain."""
    return np.cumsum([block.curve.length for block in chain])


def _speed_along(chain: Sequence[Block], settings: MotionSettings) -> SCurve:
    speed = min(block.speed for block in chain)
    length = float(_ends(chain)[-1])
    return SCurve(0.0, speed, settings.acceleration_time, settings.jerk_time, length)


def chain_time(chain: Sequence[Block], settings: MotionSettings) -> float:
    """Duration of a chain [s], before it is a whole number of ticks."""
    return _speed_along(chain, settings).total_time


def _check_ticks(
    chains: Sequence[list[Block]], settings: MotionSettings, file: str, most_ticks: int
) -> None:
    """Raises TooLongError before anything of that size is made."""
    times = [chain_time(chain, settings) for chain in chains]
    total = settings.lead_in + math.fsum(times)
    if not total / settings.period > most_ticks:
        return
    chain = chains[times.index(max(times))]
    move = min(chain, key=lambda block: block.speed).move
    raise TooLongError(
        f"{file}:{move.line}: error: the motion is too long to be held; got {total:.6g} s, of "
        f"which {max(times):.6g} s here; expected at most {most_ticks * settings.period:g} s\n"
        f"{move.line:5d} |   {move.source}\n"
        "      |   help: check F and the acceleration time; python -m sim.motion.lookahead plans "
        "motions of any length"
    )


ChainTicks = tuple[FloatArray, FloatArray, FloatArray, NDArray[np.int64]]
"""Positions, velocities, accelerations (n, 5); number (n,) of the block in the chain."""


def sample_chain(chain: Sequence[Block], settings: MotionSettings) -> Iterator[ChainTicks]:
    """The ticks of one chain, its first at rest included, its last at rest left to the next."""
    ends = _ends(chain)
    scurve = _speed_along(chain, settings)
    ticks = math.ceil(scurve.total_time / settings.period - TICK_ROUNDING)
    stretch = ticks * settings.period / scurve.total_time
    first, last = chain[0].curve, chain[-1].curve
    start, end = first.evaluate(np.zeros(1))[0][0], last.evaluate(np.array([last.length]))[0][0]
    shift = on_number_grid(start) - start
    slope = (on_number_grid(end) - end - shift) / ends[-1]
    for tick in range(0, ticks, BLOCK):
        count = min(BLOCK, ticks - tick)
        along = scurve.profile(np.arange(tick, tick + count) * (scurve.total_time / ticks))
        owner = np.minimum(np.searchsorted(ends, along.position, side="right"), len(chain) - 1)
        rate = (along.velocity / stretch)[:, np.newaxis]
        change = (along.acceleration / stretch**2)[:, np.newaxis]
        position, velocity, acceleration = (np.empty((count, 5)) for _ in range(3))
        for index in range(owner[0], owner[-1] + 1):
            block, part = chain[index], owner == index
            begin = ends[index] - block.curve.length
            s = np.clip(along.position[part] - begin, 0.0, block.curve.length)
            point, direction, bend = block.curve.evaluate(s)
            position[part] = point
            velocity[part] = direction * rate[part]
            acceleration[part] = direction * change[part] + bend * rate[part] ** 2
        position += shift + slope * along.position[:, np.newaxis]
        velocity += slope * rate
        acceleration += slope * change
        yield position, velocity, acceleration, owner


def _at_rest(pose: FloatArray, ticks: int) -> list[FloatArray]:
    """Positions, velocities, accelerations of ticks at a pose (1, 5)."""
    return [np.repeat(on_number_grid(pose), ticks, axis=0), *np.zeros((2, ticks, 5))]


def checked_chain(
    chain: Sequence[Block], settings: MotionSettings, tick: int, file: str
) -> Iterator[ChainTicks]:
    """As sample_chain; raises WorkspaceError at the first tick outside the workspace.

    tick: number of the first one.
    """
    workspace, last = Workspace.of(settings.robot), chain[-1].curve

    def check(position: FloatArray, owner: NDArray[np.int64]) -> None:
        outside = workspace.outside(position)
        if outside is None:
            return
        row, axis = outside
        value = float(position[row, axis])
        low, high = workspace.lower[axis], workspace.upper[axis]
        move = chain[owner[row]].move
        limit = low if value < low else high
        raise WorkspaceError(file, move.line, move.source, tick + row, axis, value, limit)

    for part in sample_chain(chain, settings):
        check(part[0], part[3])
        tick += len(part[0])
        yield part
    end = on_number_grid(last.evaluate(np.array([last.length]))[0])
    check(end, np.array([len(chain) - 1]))


def generate(
    program: GcodeProgram, settings: MotionSettings | None = None, most_ticks: int = MOST_TICKS
) -> Trajectory:
    """Set-points of a program from rest at its start to rest at its end.

    Raises WorkspaceError at the first set-point outside the workspace, TooLongError, and ValueError
    for a program without any motion.
    """
    settings = settings or MotionSettings()
    blocks = build_path(program, settings.rates)
    if not blocks:
        raise ValueError(
            f"{program.file}: error: the program has no motion; expected a move such as G0 X10"
        )
    chains = list(chains_of(blocks))
    _check_ticks(chains, settings, program.file, most_ticks)
    rest = math.ceil(settings.lead_in / settings.period - TICK_ROUNDING)
    start, _, _ = blocks[0].curve.evaluate(np.array([0.0]))
    parts = [_at_rest(start, rest)]
    first_ticks: list[int] = []
    tick = rest
    for chain in chains:
        begin, owners = tick, []
        for *part, owner in checked_chain(chain, settings, tick, program.file):
            parts.append(part)
            owners.append(owner)
            tick += len(owner)
        firsts = np.searchsorted(np.concatenate(owners), np.arange(len(chain)))
        first_ticks += (begin + firsts).tolist()
    last = blocks[-1].curve
    end, _, _ = last.evaluate(np.array([last.length]))
    parts.append(_at_rest(end, 1))
    first_ticks.append(tick)
    ticks = np.arange(tick + 1)
    position, velocity, acceleration = map(np.concatenate, zip(*parts, strict=True))
    return Trajectory(
        t=ticks.astype(np.float64) * settings.period,
        position=position,
        velocity=velocity,
        acceleration=acceleration,
        block=np.minimum(np.searchsorted(first_ticks, ticks, side="right") - 1, len(blocks) - 1),
        blocks=blocks,
        first_ticks=np.array(first_ticks),
    )
