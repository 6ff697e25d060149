# SPDX-License-Identifier: Apache-2.0
"""Random programs of short segments through the look-ahead planner: are limits and P met?

    python -m sim.motion.lookahead.stress --count 100
    python -m sim.motion.lookahead.stress --first 1042 --count 1      one program again
    python -m sim.motion.lookahead.stress --odd --count 10000         paths of odd moves: time only

Speeds, accelerations and jerks of tool, legs and table, and the distances from the programmed path
and its corners are measured from the set-points (check.py). Odd paths have moves from
nothing to 10 mm along single axes, repeats, reversals, P from 1e-9 to 10 mm: they must end in time.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from rich.console import Console
from rich.progress import track

from asip_asm.command import command, command_parser
from sim.motion.command import interruptible
from sim.motion.geometry.moves import Motion, Move, Plane
from sim.motion.lookahead.check import ROUNDING, Deviation, demand
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import DEPTH, LookaheadSettings
from sim.robot.parameters import Robot

TOLERANCES = (0.0, math.inf, 1e-6, 0.001, 0.005, 0.01, 0.025, 0.1, 1.0)  # P [mm]
LOW = np.array([-140.0, -140.0, 460.0, -80.0, -1e4])
HIGH = np.array([140.0, 140.0, 740.0, 80.0, 1e4])
DEPTHS = (2, DEPTH, DEPTH, DEPTH, 5, DEPTH, DEPTH, DEPTH)  # depths of successive programs
LOGGED = 100  # programs between two lines of progress in a log
FIRST, MOVES = 1000, 40  # number of the first program, moves of each
VIOLATION = 1.001  # largest share of a limit that passes


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


@dataclass(frozen=True)
class Outcome:
    """What one program did: `worst` ratio to a limit, and of what; excess over P [m] (Deviation).

    ticks: set-points.
    """

    seed: int
    worst: float
    what: str
    path: float
    corner: float
    ticks: int

    @property
    def kept(self) -> bool:
        """Whether every limit and P were met."""
        return self.worst <= VIOLATION and max(self.path, self.corner) <= ROUNDING


def greatest(outcomes: Iterable[Outcome], name: str) -> float:
    """Of a field of the outcomes."""
    return max(getattr(outcome, name) for outcome in outcomes)


def program(seed: int, settings: LookaheadSettings, count: int = MOVES) -> Outcome:
    """Runs random_moves(seed, count). Without a jerk limit the jerks are not looked at."""
    moves = random_moves(seed, count)
    away = Deviation(moves)
    stream = away.watched(Lookahead(iter(moves), settings).setpoints())
    found = demand(stream, settings.robot, settings.period)
    ratios = found.ratios(settings.limits)
    if not settings.limits.jerk_limited:
        ratios = {key: ratio for key, ratio in ratios.items() if key[1] != "jerk"}
    group, quantity = max(ratios, key=lambda key: ratios[key])
    what = f"{quantity} of {group}, line {found.lines.get((group, quantity), 0)}"
    ratio = ratios[group, quantity]
    return Outcome(seed, ratio, what, away.path, away.corner, found.ticks)


def programs(first: int, count: int, robot: Robot | None = None) -> Iterator[Outcome]:
    """Programs first .. first + count - 1, some at depths of 2 and 5 moves (DEPTHS)."""
    settings = LookaheadSettings(robot=robot or Robot.load())
    for seed in range(first, first + count):
        yield program(seed, replace(settings, depth=DEPTHS[seed % len(DEPTHS)]))


ODD_MOVES = 11  # moves of a path
BLOCK = 1000  # odd paths run as one stream
SLOWEST = 0.15  # m/s, the feed of odd paths: no limit of the machine is lower


class StalledError(RuntimeError):
    """Odd paths that took too long, lost a part of their way, or gave what is no number."""


def odd_moves(block: int) -> Iterator[Move]:
    """BLOCK paths, one after the other, each of ODD_MOVES moves of one axis and with its own P."""
    rng = np.random.default_rng([block, 0])
    place, line = np.array([0.0, 0.0, 600.0, 0.0, 0.0]), 0
    middle, reach = (LOW + HIGH) / 2, (HIGH - LOW) / 2
    for _ in range(BLOCK):
        tolerance = float(10 ** rng.uniform(-9, 1))
        for _ in range(ODD_MOVES):
            end, axis = place.copy(), rng.integers(5)
            way = rng.choice([0, 1, -1]) * 10 ** rng.uniform(-7, 1)
            if abs(end[axis] + way - middle[axis]) > reach[axis]:
                way = -way
            end[axis] += way
            line += 1
            start, finish = tuple(place.tolist()), tuple(end.tolist())
            feed = SLOWEST * 60e3
            yield Move(line, "", Motion.LINEAR, start, finish, feed, tolerance=tolerance)
            place = end


def odd_block(block: int, settings: LookaheadSettings) -> float:
    """Plans a block of odd paths; returns its time [s]. Raises StalledError."""
    way = 0.0
    longest = 0.2

    def counted() -> Iterator[Move]:
        nonlocal longest
        for move in odd_moves(block):
            # At most a stop after each move, and five times its time at the feed.
            longest += 0.04 + 5 * math.dist(move.start, move.end) / (SLOWEST * 1e3)
            yield move

    run = Lookahead(counted(), settings)
    for stretch in run.stretches():
        way += stretch.shift
        numbers = (stretch.position, stretch.speed, stretch.acceleration, stretch.jerk)
        if not all(np.isfinite(values).all() for values in numbers):
            raise StalledError(f"odd block {block}: a stretch has a value that is no number")
    time, length = run.summary.duration, run.summary.length
    if not 0.0 <= time <= longest:
        raise StalledError(f"odd block {block}: {time} s, at most {longest} s expected")
    if abs(way - length) > 1e-9 * length:
        raise StalledError(f"odd block {block}: {way} m run, {length} m planned")
    return time


@command("python -m sim.motion.lookahead.stress")
def main(argv: list[str] | None = None) -> int:
    """Command line; exit code 1 if a program broke a limit or left P."""
    prog = "python -m sim.motion.lookahead.stress"
    parser = command_parser(prog, __doc__, f"example: {prog} --count 10000")
    parser.add_argument("--first", type=int, default=FIRST, help="number of the first program")
    parser.add_argument("--count", type=int, default=100, help="programs, or odd paths")
    parser.add_argument("--odd", action="store_true", help=f"odd paths, in blocks of {BLOCK}")
    arguments = parser.parse_args(argv)
    if arguments.first < 0 or arguments.count < 1:
        parser.error("--first must be at least 0 and --count at least 1")
    console, outcomes = Console(highlight=False), []
    if arguments.odd:
        return _odd(arguments.first, -(-arguments.count // BLOCK), console)
    for outcome in track(
        programs(arguments.first, arguments.count),
        "programs",
        arguments.count,
        console=console,
        transient=True,
        disable=not console.is_terminal,
    ):
        outcomes.append(outcome)
        if not outcome.kept:
            console.print(
                f"program {outcome.seed}: {outcome.what} at {outcome.worst:.6f} of its limit; "
                f"path {outcome.path:.3g} m, corner {outcome.corner:.3g} m beyond P"
            )
        if len(outcomes) % LOGGED == 0 and not console.is_terminal:
            console.print(f"{len(outcomes)} of {arguments.count} programs")
    broken = sum(not outcome.kept for outcome in outcomes)
    worst, path, corner = (greatest(outcomes, name) for name in ("worst", "path", "corner"))
    console.print(
        f"{len(outcomes)} programs of {MOVES} moves, {sum(o.ticks for o in outcomes)} set-points: "
        f"{broken} violations; worst ratio to a limit {worst:.6f}, farthest "
        f"beyond P {path:.3g} m (path), {corner:.3g} m (corner)"
    )
    return int(broken > 0)


def _odd(first: int, blocks: int, console: Console) -> int:
    settings, time = LookaheadSettings(), 0.0
    try:
        for block in range(first, first + blocks):
            time += odd_block(block, settings)
            if (block - first + 1) % 10 == 0:
                console.print(f"{(block - first + 1) * BLOCK} of {blocks * BLOCK} odd paths")
    except StalledError as error:
        console.print(f"error: {error}", markup=False)
        return 1
    console.print(f"{blocks * BLOCK} odd paths, {time:.1f} s of motion: no stall")
    return 0


if __name__ == "__main__":
    sys.exit(interruptible(main))
