# SPDX-License-Identifier: Apache-2.0
"""Lines and arcs of the contour of a lathe cycle, as complex numbers: z is real, x imaginary.

All lengths are in the unit of the program, because the tolerances of LinuxCNC's cycles count in it.
The contour lies as lathe.py turns it: z falls along it, the material is at greater x. A `level` is
the x of a pass. The order of the operations is that of LinuxCNC, whose choices between two ways
depend on the last bit at some corners.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from sim.motion.geometry.moves import Motion

NEAR = 1e-6  # points nearer than this are one
SHORT = 1e-3  # shorter moves are left out, and z may go back by so much
GAP = 1e-2  # a gap of this size in z gets an arc, when the contour is offset
PARALLEL = 1e-9  # sine of the angle below which two lines have the same direction


class ContourError(Exception):
    """The contour cannot be cut: what, expected, help."""


Step = tuple[Motion, complex, complex | None]
"""A motion, its end and the centre of an arc."""
Try = tuple[bool, complex, tuple[Step, ...]]
"""Whether the move goes the other way, the place after it, and the steps to there."""


@dataclass
class Line:
    """A straight move. line: number of its line in the program; chamfer: the size of a chamfer
    whose ends are not yet known, 0 for other moves."""

    start: complex
    end: complex
    line: int = 0
    chamfer: float = 0.0

    @property
    def open(self) -> float:
        """Size of a chamfer or rounding without ends."""
        return self.chamfer

    @property
    def size(self) -> float:
        return abs(self.start - self.end)

    @property
    def falls(self) -> bool:
        """Whether z does not grow along it."""
        return (self.end - self.start).real <= SHORT

    def changed(self, *, mirrored: bool = False, by: complex = 1.0) -> None:
        """Mirrors x, then multiplies."""
        self.start, self.end = (_turned(p, mirrored, by) for p in (self.start, self.end))

    def offset(self, distance: float) -> None:
        """Moves it aside, to the right of its direction for positive z of the machine."""
        aside = 1j * distance * (self.start - self.end) / abs(self.start - self.end)
        self.start += aside
        self.end += aside

    def crossings(self, level: float) -> list[float]:
        """z where it meets the level."""
        low, high = sorted((self.start.imag, self.end.imag))
        if low > level + NEAR or high < level - NEAR:
            return []
        if abs((self.start - self.end).imag) < NEAR:
            return [self.start.real, self.end.real]
        rise = self.end.imag - self.start.imag
        run = self.end.real - self.start.real
        return [(level - self.start.imag) / rise * run + self.start.real]

    def dive(self, place: complex, level: float, rapid: bool) -> Try:
        """Down to the level, or to its end above that."""
        if self.start.imag <= self.end.imag + NEAR:
            return True, place, ()
        motion = Motion.RAPID if rapid else Motion.LINEAR
        if level < self.end.imag:
            return False, self.end, ((motion, self.end, None),)
        found = self.crossings(level)
        if not found:
            raise ContourError(
                f"the pass at x = {level:g} does not reach the move of line {self.line}",
                "a start X Z at the side of the material",
                "check X and Z of the cycle, and D",
            )
        end = complex(found[0], level)
        return False, end, ((motion, end, None),)

    def climb(self, place: complex) -> Try:
        """Along it, out of a pocket."""
        if self.end.imag + NEAR < self.start.imag:
            return True, place, ()
        if abs(place - self.start) > NEAR:
            raise ContourError(
                f"the cycle does not arrive at the move of line {self.line}",
                "a contour that the cycle can follow",
                "check D, which is perhaps larger than an arc or a groove",
            )
        return False, self.end, ((Motion.LINEAR, self.end, None),)

    def leave(self, place: complex) -> tuple[complex, tuple[Step, ...]]:
        """From the end of the last pass without pockets along it."""
        found = [] if self.end.imag < self.start.imag else self.crossings(place.imag)
        if not found:
            return place, ()
        begin = complex(found[0], place.imag)
        return self.end, ((Motion.LINEAR, begin, None), (Motion.LINEAR, self.end, None))

    def drawn(self) -> Step:
        return Motion.LINEAR, self.end, None


@dataclass
class Arc:
    """An arc. rounding: the radius of a rounding whose ends are not yet known, 0 for others."""

    start: complex
    end: complex
    centre: complex
    ccw: bool
    line: int = 0
    rounding: float = 0.0

    @property
    def open(self) -> float:
        return self.rounding

    @property
    def size(self) -> float:
        return min(abs(self.start - self.end), abs(self.start - self.centre))

    @property
    def motion(self) -> Motion:
        return Motion.ARC_CCW if self.ccw else Motion.ARC_CW

    @property
    def falls(self) -> bool:
        """Whether z falls along it, so that it stays on one side of its centre in x."""
        if self.rounding:
            return True
        sides = [(p - self.centre).imag * (1 if self.ccw else -1) for p in (self.start, self.end)]
        return min(sides) >= -SHORT and (self.end - self.start).real <= -SHORT

    def changed(self, *, mirrored: bool = False, by: complex = 1.0) -> None:
        points = self.start, self.end, self.centre
        self.start, self.end, self.centre = (_turned(p, mirrored, by) for p in points)
        self.ccw = self.ccw != mirrored

    def offset(self, distance: float) -> None:
        radius = abs(self.start - self.centre)
        factor = (radius + (1 if self.ccw else -1) * distance) / radius
        self.start = factor * (self.start - self.centre) + self.centre
        self.end = factor * (self.end - self.centre) + self.centre

    def crossings(self, level: float) -> list[float]:
        """Of two, the greater z first."""
        radius = abs(self.start - self.centre)
        square = -(level - radius - self.centre.imag) * (level + radius - self.centre.imag)
        if square < -NEAR:
            return []
        half = math.sqrt(max(square, 0.0))
        places = (self.centre.real + half, self.centre.real - half)
        return [z for z in places if self._has(complex(z, level))]

    def _has(self, point: complex) -> bool:
        """Whether a point of its circle is on it."""
        toward = point - self.centre
        begin = ((self.start - self.centre).conjugate() * toward).imag
        end = ((self.end - self.centre).conjugate() * toward).imag
        if self.ccw:
            return begin >= -NEAR and end <= NEAR
        return begin <= NEAR and end >= -NEAR

    def _to(self, end: complex) -> tuple[Step, ...]:
        return ((self.motion, end, self.centre),)

    def dive(self, place: complex, level: float, rapid: bool) -> Try:
        if abs(place - self.end) < NEAR or (place - self.end).real <= NEAR:
            return False, self.end, ()
        found = self.crossings(level) or self.crossings(level - NEAR)
        middle = self.centre.real
        if self.ccw:
            if place.real - NEAR > middle:
                return True, place, ()
            end = self.end
            if found and found[-1] <= middle:
                end = complex(found[-1], level)
        elif place.real <= middle:
            return True, place, ()
        elif not found:
            end = self.end
        elif found[0] < middle:
            return False, place, ()  # only its rising half is there: a lower level comes next
        else:
            end = complex(found[0], level)
        return False, end, self._to(end)

    def _top(self) -> complex:
        """Where it ends, or where a counter-clockwise one begins to fall."""
        if self.ccw and self.end.real < self.centre.real:
            radius = abs(self.start - self.centre)
            return complex(self.centre.real, self.centre.imag + radius)
        return self.end

    def climb(self, place: complex) -> Try:
        outside = place.real < self.centre.real if self.ccw else place.real > self.centre.real
        if outside:
            return True, place, ()
        top = self._top()
        return self.ccw, top, self._to(top) if abs(place - top) > SHORT else ()

    def leave(self, place: complex) -> tuple[complex, tuple[Step, ...]]:
        found = self.crossings(place.imag)
        middle = self.centre.real
        if not found or (found[0] < middle if self.ccw else found[-1] > middle):
            return place, ()
        begin = complex(found[0] if self.ccw else found[-1], place.imag)
        top = self._top()
        arc = self._to(top) if abs(begin - top) > SHORT else ()
        return top, ((Motion.LINEAR, begin, None), *arc)

    def drawn(self) -> Step:
        return self.motion, self.end, self.centre


Segment = Line | Arc


def _turned(point: complex, mirrored: bool, by: complex) -> complex:
    return (point.conjugate() if mirrored else point) * by


def join(first: Segment, second: Segment) -> None:
    """Moves the end of `first` and the start of `second` to where both meet, after an offset.

    A line and an arc that touch stay. Raises ContourError.
    """
    mixed = isinstance(first, Arc) != isinstance(second, Arc)
    if mixed and abs(second.start - first.end) < NEAR:
        return
    try:
        if isinstance(first, Line) and isinstance(second, Line):
            met = _lines(first, second)
        elif isinstance(first, Arc) and isinstance(second, Arc):
            met = _arcs(first, second)
        elif isinstance(first, Arc):
            way = second.end, second.start
            met = _on_both(*way, first.end, first.centre, second.start)
        else:
            assert isinstance(second, Arc)
            way = first.end, first.start
            met = _on_both(*way, second.end, second.centre, second.start)
    except ZeroDivisionError:
        raise vanished() from None
    first.end = second.start = met


def vanished() -> ContourError:
    return ContourError(
        "the contour has no move left at that distance",
        "D and E smaller than the arcs and grooves of the contour",
        "check D, which is the distance that remains to the contour",
    )


def _lines(first: Line, second: Line) -> complex:
    back = (second.start - second.end).conjugate() / abs(second.start - second.end)
    begin, end = (first.start - second.end) * back, (first.end - second.end) * back
    if abs((begin - end).imag) <= PARALLEL * abs(begin - end):
        raise ContourError(
            f"the lines {first.line} and {second.line} go in the same direction or back",
            "two moves with a corner, if D or E is not 0 or at a chamfer or rounding",
            f"write both as one move; LinuxCNC cannot offset them (lines {first.line} and "
            f"{second.line})",
        )
    share = begin.imag / (begin - end).imag
    return (begin + share * (end - begin)) / back + second.end


def _on_both(
    base: complex, other: complex, on_arc: complex, centre: complex, near: complex
) -> complex:
    """The point of a line from `base` to `other` and of a circle that is nearer to `near`."""
    back = (other - base).conjugate() / abs(other - base)
    arc, middle = (on_arc - base) * back, (centre - base) * back
    radius = middle - arc
    square = radius.real * radius.real + radius.imag * radius.imag - middle.imag * middle.imag
    half = math.sqrt(max(square, 0.0))
    far, close = ((middle.real + way) / back + base for way in (half, -half))
    return far if abs(near - far) < abs(near - close) else close


def _arcs(first: Arc, second: Arc) -> complex:
    a = abs(second.start - second.centre)
    b = abs(first.start - first.centre)
    c = abs(second.centre - first.centre)
    cosine = (c * c + a * a - b * b) / 2.0 / a / c
    turn = complex(cosine, math.sqrt(1 - min(cosine * cosine, 1.0)))
    return turn * (first.centre - second.centre) / c * a + second.centre


def corner(before: Segment, between: Segment, after: Segment) -> None:
    """Gives a chamfer or rounding (`between`) its ends, and cuts its neighbours there."""
    size = between.open
    no_room = ContourError(
        f"there is no room for the corner of line {between.line}",
        "A or C smaller than both moves of the corner",
        "check A (rounding) or C (chamfer) of that line",
    )
    ways = [(before, before.end - before.start), (after, after.end - after.start)]
    for side in (size, -size):
        first, second = replace(before), replace(after)
        first.offset(side)
        second.offset(side)
        if (first.end - second.start).real <= GAP:
            break
    else:
        raise no_room
    join(first, second)
    middle = (first.end + second.start) / 2.0
    first.offset(-side)
    second.offset(-side)
    between.start = before.end = first.end
    between.end = after.start = second.start
    for part, way in ways:
        # LinuxCNC goes back along a line that is too short.
        if isinstance(part, Line) and ((part.end - part.start) * way.conjugate()).real < 0:
            raise no_room
    if isinstance(between, Arc):
        between.centre, between.rounding = middle, 0.0
        above = (p - middle for p in (between.start, between.end))
        between.ccw = any(p.imag > 0 for p in above)
