# SPDX-License-Identifier: Apache-2.0
"""Set-points of a whole program, one per control tick, in the path control that it requests.

Moves under G61 and G64 are planned with look-ahead (sim/motion/lookahead/planner.py): corners under
G64 are rounded within P, the machine's limits are used. Moves under G61.1 are S-curves of set times
from rest to rest (exact_stop.py). A program may change between both; where it does, it stops.
G4 rests.

Number grid: controllers take set-points as binary32. Every set-point is on the grid of
`on_number_grid`: exact stops begin and end there, and every tick of the look-ahead is moved there
(by at most 30 nm). So an axis that rests or is held has no rounding error, neither itself nor as
its distance from a leg's base, which the controller's integrators would add up. Speed and
acceleration are continuous.

Programs may be of any length: moves come as a stream, and of a path too long to be simulated only
windows stay in memory (windows.py). Every tick is planned all the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain, groupby

import numpy as np
from numpy.typing import NDArray

from asip_asm.project import ROOT
from sim.motion.geometry.curves import FloatArray, RateLimits, blocks_of, curve_of, feed_of, to_si
from sim.motion.geometry.moves import Dwell, GcodeProgram, Item, Motion, Move, Pose
from sim.motion.lookahead.joints import SlowestJoints
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import LookaheadSettings
from sim.motion.trajectory.exact_stop import (
    BLOCK,
    TICK_ROUNDING,
    MotionSettings,
    TooLongError,
    Trajectory,
    chain_time,
    chains_of,
    checked_chain,
    on_number_grid,
)
from sim.motion.trajectory.path_limits import LimitMeter
from sim.motion.trajectory.ticks import Ticks, at_rest, joined
from sim.motion.trajectory.windows import Place, Windows, path_of
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints

REST_AT_START = 0.1  # s, in which the controller settles
AGH = ROOT / "sim/paths/agh.ngc"
MOST_TICKS = 1_500_000  # simulated in one run, which needs some 2.5 kB a tick
MOST_TIME = 86_400.0  # s of motion that a plan may have
TOGETHER = 4096  # ticks, at least, that are looked at together


@dataclass
class Corners:
    """What became of the places where two moves meet; rests of G4 [s]; the slowest rounded ones."""

    rounded: int = 0
    smooth: int = 0
    stops: int = 0
    rest: float = 0.0
    slowest: SlowestJoints = field(default_factory=SlowestJoints)


@dataclass(frozen=True, eq=False)
class ProgramPath(Ticks):
    """The ticks of a program that a job runs; `move` is a number in `moves`, those under way.

    period [s]; rest: ticks of that at the start; whole: False where the program goes on after the
    last tick; count: moves of the program that were planned; planned: ticks planned, without the
    rest at the start; limited_by: shares of their moving time, by the limit that bounds it;
    windows: where the ticks are in the plan, empty if all ticks follow each other from its start.
    """

    period: float
    moves: tuple[Move, ...]
    rest: int
    whole: bool
    corners: Corners
    count: int
    planned: int
    limited_by: dict[str, float]
    windows: tuple[Place, ...] = ()

    @property
    def time(self) -> float:
        """Duration of the planned path [s], without the rest at the start."""
        return max(0, self.planned - 1) * self.period

    def _of_moves(self, values: Iterable[bool]) -> NDArray[np.bool_]:
        """Values of the moves at each tick (n,), False where none is under way."""
        return np.array([*values, False])[self.move]

    @property
    def drawing(self) -> NDArray[np.bool_]:
        """Whether a tick (n,) is of a move at a feed rate, not of a rapid one."""
        return self._of_moves(move.motion is not Motion.RAPID for move in self.moves)


def plan(
    program: GcodeProgram,
    robot: Robot,
    ticks: int | None = None,
    seconds: tuple[float, float] | None = None,
) -> ProgramPath:
    """As `plan_stream`, of a program that is held."""
    return plan_stream(_in_order(program), program.file, robot, ticks, seconds)


def plan_stream(
    items: Iterable[Item],
    file: str,
    robot: Robot,
    ticks: int | None = None,
    seconds: tuple[float, float] | None = None,
    watch: Callable[[int, float], None] = lambda moves, time: None,
) -> ProgramPath:
    """Set-points from rest at the program's start to rest at its end.

    Of a path of more than MOST_TICKS ticks, windows of it (windows.py). ticks: only the first so
    many; seconds: only the motion between two times, the rest at the start not counted; at most
    MOST_TICKS; watch: gets the moves read and the time planned. Raises WorkspaceError and
    OutsideError for a motion that leaves the workspace, TooLongError for one of more than MOST_TIME
    before that, ValueError for a program without any motion, or none in the requested time.
    """
    period = robot.T_s
    rest = math.ceil(REST_AT_START / period - TICK_ROUNDING)
    meter = LimitMeter(robot, MachineLimits.of(robot), period)
    fixed = _ticks_of(seconds, rest, period) if seconds else None
    windows = Windows(period, meter.names, fixed)
    end = fixed[1] if fixed else ticks if ticks is not None and ticks <= MOST_TICKS else math.inf
    motion = _Motion(items, file, robot)
    held: list[Ticks] = []  # all ticks, while they are few
    count = 0
    parts = motion.parts(rest)
    for part in _together(parts):
        part = part.part(0, int(min(len(part), end - count)))
        feed, alone, exact = motion.of_ticks(part)
        values = part.position, part.velocity, part.acceleration
        ratios = meter.see(values, feed, alone, exact)
        count += len(part)
        if fixed or end == math.inf:
            windows.see(part, dict(zip(meter.names, ratios, strict=True)), motion.moves)
        if not fixed and count <= MOST_TICKS:
            held.append(part)
        elif ticks is not None:
            raise ValueError(
                f"{file}: error: {ticks} ticks are too many to be simulated in one run; expected "
                f"at most {MOST_TICKS}, or windows of the path: without --ticks"
            )
        else:
            held.clear()
            motion.forget(windows.oldest_move)
        watch(motion.count, (count - rest) * period)
        if count >= end:
            break
    parts.close()  # counts the corners of what was planned
    whole = motion.ended and count == motion.ticks
    places: tuple[Place, ...] = ()
    if held:
        path, moves = joined(held), motion.moves
    else:
        found = windows.found(motion.moves)
        if not found and seconds:
            raise ValueError(
                f"{file}: error: the path takes {(count - rest) * period:g} s; got a window from "
                f"{seconds[0]:g} s on; expected an earlier one (--seconds)"
            )
        path, places = path_of(found, MachineLimits.of(robot), period, rest)
        moves = {number: move for window in found for number, move in window.moves.items()}
    if len(path) > MOST_TICKS:
        raise TooLongError(
            f"{file}: error: the windows are too far apart to be simulated in one run; got "
            f"{len(path) * period:g} s with the ways between them; expected at most "
            f"{MOST_TICKS * period:g} s\n      |   help: run one window: --seconds 0:10"
        )
    numbers = np.unique(path.move[path.move >= 0])
    own = np.where(path.move >= 0, np.searchsorted(numbers, path.move), -1)
    return ProgramPath(
        path.position,
        path.velocity,
        path.acceleration,
        own,
        period=period,
        moves=tuple(moves[number] for number in numbers.tolist()),
        rest=min(rest, len(path)),
        whole=whole,
        corners=motion.corners,
        count=motion.count,
        planned=max(0, count - rest),
        limited_by=meter.shares(),
        windows=places,
    )


def _ticks_of(seconds: tuple[float, float], rest: int, period: float) -> tuple[int, int]:
    """First tick and end of the motion between two times."""
    begin, end = seconds
    first, last = round(begin / period), round(min(end, MOST_TIME) / period)
    if end == math.inf:
        last = first + MOST_TICKS
    if not 0 < last - first <= MOST_TICKS:
        raise ValueError(
            f"--seconds {begin:g}:{end:g} is outside its limit: a window of 1 to {MOST_TICKS} "
            f"ticks, which last {MOST_TICKS * period:g} s, before {MOST_TIME:g} s"
        )
    return (first + rest if first else 0), last + rest


def _in_order(program: GcodeProgram) -> Iterator[Item]:
    dwells = list(program.dwells)
    for number, move in enumerate(program.moves):
        while dwells and dwells[0][0] <= number:
            yield dwells.pop(0)[1]
        yield move
    for _, dwell in dwells:
        yield dwell


def _together(parts: Iterable[Ticks]) -> Iterator[Ticks]:
    """Parts of at least TOGETHER ticks; the last may be shorter."""
    held: list[Ticks] = []
    for part in parts:
        held.append(part)
        if sum(map(len, held)) >= TOGETHER:
            yield joined(held)
            held = []
    if held:
        yield joined(held)


_Entry = tuple[bool, int, Pose, Item]
"""Whether under G61.1, number of the move, pose after it, item."""


class _Motion:
    """The ticks of a stream of moves and rests.

    moves: those whose ticks may come or are held, by number; count: moves read; ticks: made;
    ended: the last tick is the program's.
    """

    def __init__(self, items: Iterable[Item], file: str, robot: Robot) -> None:
        self._items, self._file, self._robot = items, file, robot
        self.corners = Corners()
        self.moves: dict[int, Move] = {}
        self.count, self.ticks, self.ended = 0, 0, False
        self._pose: Pose = (math.nan,) * 5  # after the last item; before the first move nan

    def parts(self, rest: int) -> Generator[Ticks]:
        """The ticks of the whole program; the last part is the last tick, at rest at the end.

        rest: ticks of that at the start. Raises TooLongError before the ticks of a stretch of
        motion are made that ends after MOST_TIME.
        """
        entries, head = self._entries(), []
        for entry in entries:
            head.append(entry)
            if isinstance(entry[3], Move) and curve_of(entry[3]) is not None:
                break
        else:
            raise ValueError(
                f"{self._file}: error: the program has no motion; expected a move such as G0 X10"
            )
        self.ticks += rest
        yield at_rest(on_number_grid(to_si(entry[3].start)), rest, -1)
        last = -1
        for exact, group in groupby(chain(head, entries), key=lambda entry: entry[0]):
            self.corners.stops += last >= 0
            for part in self._exact_stops(group) if exact else self._looking_ahead(group):
                self.ticks += len(part)
                yield part
                last = int(part.move[-1])
        self.ticks, self.ended = self.ticks + 1, True
        yield at_rest(on_number_grid(to_si(self._pose)), 1, last)

    def forget(self, number: int) -> None:
        """Forgets the moves before this one."""
        while self.moves and next(iter(self.moves)) < number:
            del self.moves[next(iter(self.moves))]

    def of_ticks(self, part: Ticks) -> tuple[FloatArray, NDArray[np.bool_], NDArray[np.bool_]]:
        """At each tick: feed, whether the table turns alone, whether under G61.1."""
        numbers, own = np.unique(part.move, return_inverse=True)
        moves = [self.moves.get(number) for number in numbers.tolist()]
        feed = np.array([feed_of(move) if move else math.inf for move in moves])
        alone = np.array([move is not None and move.turns_only_the_table for move in moves])
        exact = np.array([move is not None and move.exact_stop for move in moves])
        return feed[own], alone[own], exact[own]

    def _entries(self) -> Iterator[_Entry]:
        """Moves and rests in order. A rest belongs to the moves before it, or to the first one."""
        early: list[Dwell] = []
        exact = False
        for item in self._items:
            if isinstance(item, Dwell):
                if not self.count:
                    early.append(item)
                else:
                    yield exact, max(self.count - 1, 0), self._pose, item
                continue
            if not self.count:
                yield from ((item.exact_stop, 0, item.start, dwell) for dwell in early)
            if item.start != item.end or item.motion.is_arc:
                self.moves[self.count] = item
            exact, self._pose = item.exact_stop, item.end
            self.count += 1
            yield exact, self.count - 1, item.end, item

    def _check_time(self, seconds: float, move: Item) -> None:
        """Raises TooLongError if the motion so far and these seconds take too long."""
        if self.ticks * self._robot.T_s + seconds > MOST_TIME:
            raise TooLongError(
                f"{self._file}:{move.line}: error: the motion is too long to be planned; got more "
                f"than {MOST_TIME / 3600:g} h up to here; expected at most that\n"
                f"{move.line:5d} |   {move.source}\n"
                "      |   help: check F, or take a part: --seconds 0:100, --from LINE"
            )

    def _resting(self, pose: Pose, dwell: Dwell, number: int) -> Iterator[Ticks]:
        self.corners.rest += dwell.seconds
        self._check_time(dwell.seconds, dwell)
        ticks = math.ceil(dwell.seconds / self._robot.T_s - TICK_ROUNDING)
        for tick in range(0, ticks, BLOCK):
            yield at_rest(on_number_grid(to_si(pose)), min(BLOCK, ticks - tick), number)

    def _exact_stops(self, entries: Iterable[_Entry]) -> Iterator[Ticks]:
        """The ticks of moves and rests under G61.1, without the last one."""
        settings = MotionSettings(self._robot, lead_in=0.0)
        rates = settings.rates or RateLimits()
        for is_dwell, group in groupby(entries, key=lambda entry: isinstance(entry[3], Dwell)):
            if is_dwell:
                for _, number, pose, item in group:
                    if isinstance(item, Dwell):
                        yield from self._resting(pose, item, number)
                continue
            numbers: list[int] = []
            tick = 0
            for blocks in chains_of(blocks_of(_moving(group, numbers), rates)):
                self._check_time(chain_time(blocks, settings), blocks[0].move)
                self.corners.stops += tick > 0
                self.corners.smooth += len(blocks) - 1
                own = np.array(numbers[: len(blocks)])
                del numbers[: len(blocks)]
                for q, v, a, owner in checked_chain(blocks, settings, tick, self._file):
                    tick += len(owner)
                    yield Ticks(q, v, a, own[owner])

    def _looking_ahead(self, entries: Iterable[_Entry]) -> Iterator[Ticks]:
        """The ticks of moves and rests under G61 and G64, without the last one."""
        base = -1  # number of the first move
        alone: list[tuple[int, Pose, Dwell]] = []  # rests before it

        def items() -> Iterator[Item]:
            nonlocal base
            for _, number, pose, item in entries:
                if isinstance(item, Move):
                    base = number if base < 0 else base
                else:
                    self.corners.rest += item.seconds
                    if base < 0:
                        alone.append((number, pose, item))
                yield item

        settings = LookaheadSettings(robot=self._robot)
        before = self.ticks
        lookahead = Lookahead(items(), settings, self.corners.slowest, self._file)
        held = None  # the last one is the last tick
        try:
            for points in lookahead.setpoints():
                if held is not None:
                    position = on_number_grid(held.position)
                    yield Ticks(position, held.velocity, held.acceleration, held.move + base)
                held = points
                left = lookahead.summary.duration - (self.ticks - before) * settings.period
                self._check_time(left, self.moves[int(points.move[0]) + base])
        finally:  # also where the caller takes only the first ticks
            summary = lookahead.summary
            self.corners.rounded += summary.blends + summary.turns
            self.corners.smooth += summary.smooth
            self.corners.stops += summary.stops
        if held is None:  # rests alone
            for number, pose, dwell in alone:
                self.corners.rest -= dwell.seconds
                yield from self._resting(pose, dwell, number)


def _moving(entries: Iterable[_Entry], numbers: list[int]) -> Iterator[Move]:
    """The moves that go anywhere; numbers: gets theirs."""
    for _, number, _, move in entries:
        if isinstance(move, Move) and curve_of(move) is not None:
            numbers.append(number)
            yield move


def set_points(trajectory: Trajectory | ProgramPath, ticks: int | None = None) -> SetPoints:
    """The first `ticks` set-points of a trajectory, None: all."""
    whole = (trajectory.position, trajectory.velocity, trajectory.acceleration)
    parts = [part[:ticks] for part in whole]
    return SetPoints(*(part[:, :3] for part in parts), *(part[:, 3:] for part in parts))
