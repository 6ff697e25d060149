# SPDX-License-Identifier: Apache-2.0
"""Lathe cycles G70, G71 and G72 with their forms .1 and .2: the moves that cut a contour.

They make the moves of LinuxCNC 2.9 ("G70 Lathe finishing cycle", "G71 G72 Lathe roughing cycles";
rs274 is the reference of the tests). The contour is turned so that z falls along it and its end is
at the greater x. G72 turns it by 90 degrees before. An offset goes in steps of at most half of the
smallest move, so that arcs and lines which vanish are found one after the other.

A roughing cycle goes down to the level of a pass, along it to the contour, and back by the distance
of R. At the lowest level it follows the contour up to the next place that falls, and begins there
again (a pocket). The form .1 leaves out the pockets, .2 cuts them alone.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace

from sim.motion.gcode.segments import (
    GAP,
    NEAR,
    SHORT,
    Arc,
    ContourError,
    Line,
    Segment,
    Step,
    corner,
    join,
    vanished,
)
from sim.motion.geometry.moves import Motion

MAX_SEGMENTS = 10_000  # moves of a contour
MAX_STEPS = 50_000  # moves of one cycle
MAX_WORK = 500_000  # moves of the contour that a cycle looks at: a few seconds
FAR = 1e9  # below every contour


@dataclass(frozen=True)
class Numbers:
    """Numbers of a cycle in the unit of the program, with LinuxCNC's defaults: D, E, P, I, R."""

    distance: float = 0.0
    last: float = 0.0
    passes: int = 1
    increment: float = 1.0
    retract: float = 0.5


class Work:
    """Counts what a cycle does. Raises ContourError beyond the limits."""

    def __init__(self) -> None:
        self.done, self.steps = 0, 0

    def spend(self, count: int = 1) -> None:
        self.done += count
        if self.done > MAX_WORK:
            raise ContourError(
                f"the cycle looks at more than {MAX_WORK} moves of its contour",
                "a larger I, a smaller D, or fewer and longer moves in the contour",
                "check I, which counts in the unit of the program; write chords as arcs",
            )

    def step(self) -> None:
        self.steps += 1
        if self.steps > MAX_STEPS:
            raise ContourError(
                f"the cycle makes more than {MAX_STEPS} moves",
                "a larger I, or fewer passes P",
                "check I, which counts in the unit of the program",
            )


class Profile:
    """A contour and how it is turned: from z + ix it is mirrored in x, then multiplied by `by`."""

    def __init__(self, segments: list[Segment], work: Work) -> None:
        self.segments, self.work = segments, work
        self.mirrored, self.by = False, 1 + 0j

    def copy(self) -> Profile:
        found = Profile([replace(segment) for segment in self.segments], self.work)
        found.mirrored, found.by = self.mirrored, self.by
        return found

    def _change(self, *, mirrored: bool = False, by: complex = 1 + 0j) -> None:
        for segment in self.segments:
            segment.changed(mirrored=mirrored, by=by)
        self.by = (self.by.conjugate() if mirrored else self.by) * by
        self.mirrored = self.mirrored != mirrored

    def quarter(self) -> None:
        """Exchanges z and x."""
        self._change(by=-1j)

    def orient(self) -> None:
        """Turns the contour so that it ends at less z and greater x than its first move."""
        way = self.segments[0].end - self.segments[-1].end
        if way.imag > 0:
            self._change(mirrored=True)
        if way.real < 0:
            self._change(mirrored=True, by=-1 + 0j)

    def placed(self, step: Step) -> Step:
        """A step in the coordinates of the program."""
        motion, end, centre = step
        if self.mirrored and motion.is_arc:
            motion = Motion.ARC_CW if motion is Motion.ARC_CCW else Motion.ARC_CCW
        return motion, self._back(end), None if centre is None else self._back(centre)

    def _back(self, point: complex) -> complex:
        if self.mirrored:
            return self.by * point.conjugate()
        return self.by.conjugate() * point

    def finish_corners(self) -> None:
        """Gives chamfers and roundings their place, and leaves out moves that are too short."""
        parts = self.segments
        for before, between, after in zip(parts, parts[1:], parts[2:], strict=False):
            if between.open:
                corner(before, between, after)
        self.segments = [segment for segment in parts if segment.size >= SHORT]
        if len(self.segments) < 2:
            raise vanished()

    def check_falls(self, axis: str) -> None:
        """axis: the letter of z, as it is turned."""
        front = self.segments[0]
        if (front.end - front.start).real > 0:
            front.start = complex(front.end.real, front.start.imag)
        for segment in self.segments:
            if not segment.falls:
                raise ContourError(
                    f"the contour goes back in {axis} in line {segment.line}",
                    f"{axis} that grows or falls all along the contour, and arcs of at most half "
                    f"a turn that do not go back in {axis}",
                    "check that line and its A (rounding); G71 needs this of Z, G72 of X; the "
                    "start X Z of the cycle is a point of the contour",
                )

    # Offset

    def offset(self, distance: float) -> None:
        """Moves all but the first move aside, away from the side where it comes from."""
        front = self.segments.pop(0)
        toward, whole = front.end - front.start, self.segments[-1].start - front.start
        if whole and (toward / whole).imag < 0:
            distance = -distance
        done = 0.0
        while done != distance:
            done += self._step(distance, done)
        for first, second in zip(self.segments, self.segments[1:], strict=False):
            first.end = second.start = (first.end + second.start) / 2.0
        front.end = self.segments[0].start
        self.segments.insert(0, front)

    def _step(self, distance: float, done: float) -> float:
        """One step of an offset; its length."""
        self.work.spend(len(self.segments))
        step = min(FAR, *(segment.size / 2 for segment in self.segments), abs(distance - done))
        if distance < 0:
            step = -step
        for segment in self.segments:
            segment.offset(step)
        self.segments = [segment for segment in self.segments if segment.size >= SHORT]
        self._close_gaps(step, distance > 0)
        self._join()
        return step

    def _close_gaps(self, step: float, ccw: bool) -> None:
        """Arcs about the corners that the offset has opened."""
        found = self.segments[:1]
        for first, second in zip(self.segments, self.segments[1:], strict=False):
            if (first.end - second.start).real > GAP:
                before, after = replace(first), replace(second)
                before.offset(-step)
                after.offset(-step)
                middle = (before.end + after.start) / 2.0
                found.append(Arc(first.end, second.start, middle, ccw, second.line))
            found.append(second)
        self.segments = found

    def _join(self) -> None:
        """Lets neighbours meet; moves that the offset has turned round or used up are left out."""
        parts, at = self.segments, 0
        while at != len(parts) - 1:
            self.work.spend()
            if at >= len(parts):
                raise vanished()
            if not parts[at].falls:
                if at == 0:
                    raise vanished()
                del parts[at if parts[at].size < parts[at - 1].size else at - 1]
                at = 0
                if len(parts) < 2:
                    raise vanished()
            if parts[at].size < SHORT:
                del parts[at]
                at = 0
            else:
                join(parts[at], parts[at + 1])
            at += 1


def finishing(segments: list[Segment], start: complex, numbers: Numbers) -> Iterator[Step]:
    """Steps of G70 after the way to its start: along the contour at falling distances.

    segments: two moves or more, the first of them leads to the contour. Raises ContourError.
    """
    work = Work()
    profile = Profile(segments, work)
    segments[0].start = start
    axis = "Z"
    rest = Profile([replace(segment) for segment in segments[1:]], work)
    rest.orient()
    if not all(segment.falls for segment in rest.segments):
        rest.quarter()
        rest.orient()
        rest.check_falls("Z and X")
        profile.quarter()
        axis = "X"
    else:
        rest.check_falls(axis)
    profile.orient()
    profile.finish_corners()
    profile.check_falls(axis)
    passes = numbers.passes
    for number in range(passes, 0, -1):
        distance = (number - 1) * (numbers.distance - numbers.last) / passes + numbers.last
        path = profile.copy()
        path.offset(distance)
        front, *others = path.segments
        steps: list[Step] = [(Motion.RAPID, front.start, None), (Motion.RAPID, front.end, None)]
        for step in (*steps, *(segment.drawn() for segment in others)):
            work.step()
            yield profile.placed(step)


def roughing(
    segments: list[Segment], start: complex, numbers: Numbers, facing: bool, form: int
) -> Iterator[Step]:
    """Steps of G71, of G72 (facing), after the way to the start; form: 0, 1 or 2 of its number.

    segments: as of `finishing`. Raises ContourError.
    """
    work = Work()
    profile = Profile(segments, work)
    segments[0].start = start
    if facing:
        profile.quarter()
    profile.orient()
    profile.finish_corners()
    profile.check_falls("X" if facing else "Z")
    profile.offset(numbers.distance)
    front, back = profile.segments[0], profile.segments[-1]
    if back.end.imag < front.start.imag:
        end = complex(back.end.real, front.start.imag)
        profile.segments.append(Line(back.end, end, back.line))
    cut = Roughing(profile.segments, numbers, work)
    yield profile.placed((Motion.RAPID, front.start, None))
    for step in cut.steps(form):
        work.step()
        yield profile.placed(step)


class Roughing:
    """Passes of a roughing cycle over a contour that is turned and offset."""

    def __init__(self, segments: list[Segment], numbers: Numbers, work: Work) -> None:
        self.segments, self.work = segments, work
        self.depth = numbers.increment
        self.retract = numbers.retract * (1 + 1j)
        self.place, self.at = segments[0].start, 0
        self.tops = [self.place]  # where the passes begin to count their levels

    def steps(self, form: int) -> Iterator[Step]:
        if form == 2:
            yield from self._skip_first()
        again = True
        while again:
            again = yield from self._passes(form)

    def _skip_first(self) -> Iterator[Step]:
        """Down into the contour to the first move that does not fall."""
        while self.at < len(self.segments):
            up, self.place, steps = self._dive(-FAR)
            if up:
                return
            yield from steps
            self.at += 1

    def _dive(self, level: float) -> tuple[bool, complex, tuple[Step, ...]]:
        self.work.spend()
        return self.segments[self.at].dive(self.place, level, self.at == 0)

    def _passes(self, form: int) -> Generator[Step, None, bool]:
        """Passes down to the ground of a pocket, and the way up; whether another one follows."""
        level, before = self.tops[-1].imag, None
        while self.at < len(self.segments):
            while level - NEAR > self.place.imag:
                level -= self.depth
                self.work.spend()
            up, self.place, steps = self._dive(level)
            yield from steps
            if up:
                follow = self._leave() if form == 1 else self._climb(form)
                return (yield from follow)
            if abs(self.place.imag - level) > NEAR:
                self.at += 1
                continue
            if before == (self.at, self.place, level):
                raise _stuck(self.segments[self.at])
            before = self.at, self.place, level
            if (yield from self._along(level)):
                level -= self.depth
        return False

    def _along(self, level: float) -> Generator[Step, None, bool]:
        """One pass to the contour and back; whether the next one is lower."""
        for number in range(self.at, len(self.segments)):
            self.work.spend()
            segment = self.segments[number]
            found = segment.crossings(self.place.imag)
            if not found:
                continue
            own = number == self.at
            z = found[-1] if own else found[0]  # an arc can be met again at its other side
            way = abs(z - self.place.real)
            if z - NEAR > self.place.real or (way < NEAR and own):
                continue
            if way < NEAR:
                if abs(self.place - segment.start) < NEAR:
                    self.at = number
                    return False
                return True
            yield from self._pass(z, way)
            return True
        return False

    def _pass(self, z: float, way: float) -> Iterator[Step]:
        end = complex(z, self.place.imag)
        yield Motion.LINEAR, end, None
        share = 1.0
        if self.retract.real:
            share = min(1.0, way / 2 / self.retract.real)
        back = share * self.retract
        yield Motion.RAPID, end + back, None
        yield Motion.RAPID, self.place - back.conjugate(), None
        yield Motion.RAPID if self.at == 0 else Motion.LINEAR, self.place, None

    def _leave(self) -> Generator[Step, None, bool]:
        """Form 1: along the contour, over its pockets, to the end."""
        for segment in self.segments[self.at :]:
            self.work.spend()
            self.place, steps = segment.leave(self.place)
            yield from steps
        return False

    def _climb(self, form: int) -> Generator[Step, None, bool]:
        """Along the contour up to where it falls again; whether it does."""
        begin = self.at, self.place
        while self.at < len(self.segments):
            self.work.spend()
            down, self.place, steps = self.segments[self.at].climb(self.place)
            yield from steps
            if down:
                if begin == (self.at, self.place):
                    raise _stuck(self.segments[self.at])
                if form == 2:
                    self._count_from_here()
                return True
            self.at += 1
        return False

    def _count_from_here(self) -> None:
        """Form 2: passes of a pocket count from its own edge, not from the start of the cycle."""
        if self.place.imag > self.tops[-1].imag and len(self.tops) > 1:
            self.tops.pop()
        if len(self.tops) == 1:
            self.tops.append(self.place)


def _stuck(segment: Segment) -> ContourError:
    return ContourError(
        f"the cycle finds no way on from the move of line {segment.line}",
        "a contour that ends at the level of the start X Z, or beyond it",
        "check the end of the contour, X and Z of the cycle, and D",
    )
