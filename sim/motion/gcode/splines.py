# SPDX-License-Identifier: Apache-2.0
"""Splines in the plane XY (LinuxCNC, "G5", "G5.1", "G5.2 G5.3"): G words to chords.

G5 X Y I J P Q      cubic; I J: from the start to the first control point, P Q: from the end to the
                    second; without I J after another G5: its direction goes on
G5.1 X Y I J        quadratic; I J: from the start to the control point
G5.2 X Y P L        control point of a NURBS with its weight P; the first is the position, with
                    weight 1 or that of G5.2 P alone; L: order, 3 if not given. Blocks with X Y P
                    may follow without G5.2
G5.3                ends the control points and makes the curve

The curve is evaluated exactly and run in chords that miss it by at most TOLERANCE_MM. The chords
are parts of one block: look-ahead rounds the joints between them (INNER_TOLERANCE), and runs
through.
"""

from __future__ import annotations

from sim.motion.gcode.state import State
from sim.motion.gcode.targets import target
from sim.motion.gcode.words import Word
from sim.motion.geometry.moves import Plane
from sim.motion.geometry.nurbs import MAX_CHORDS, Nurbs, TooManyChordsError

TOLERANCE_MM = 0.0005
MAX_POINTS = 10_000  # control points of a NURBS
MAX_ORDER = 20

_BESIDE_POINTS = ("motion", "spindle", "coolant")  # groups of words allowed from G5.2 to G5.3
Point = tuple[float, float]


class Splines:
    """Control points that are being collected, and the direction in which G5 may go on."""

    def __init__(self, state: State) -> None:
        self.state = state
        self.open = False  # a G5.2 waits for its G5.3
        self.points: list[Point] = []  # control points of G5.2, programmed coordinates [mm]
        self.weights: list[float] = []
        self.order = 3
        self.onward: Point | None = None  # I J of a G5 that follows

    def block(self, codes: dict[str, Word], values: dict[str, Word], at: Word) -> list[Point]:
        """Ends of the chords of a block, none after a mistake and for control points."""
        code = codes["motion"].code if "motion" in codes else "G5.2"
        if not self._accepted(code, codes, values, at):
            return []
        if code == "G5.2":
            self._collect(values, at)
            return []
        if code == "G5.3":
            return self._finish(at)
        start, end = self.state.programmed()[:2], target(self.state, values)[:2]
        if code == "G5.1":
            return self._quadratic(start, end, values, at)
        return self._cubic(start, end, values, at)

    def _fail(self, at: Word, what: str, expected: str, help: str) -> list[Point]:
        self.state.report(at, what, expected, help)
        return []

    def _accepted(
        self, code: str, codes: dict[str, Word], values: dict[str, Word], at: Word
    ) -> bool:
        strange = [word for group, word in codes.items() if group not in _BESIDE_POINTS]
        if self.open and (strange or code not in ("G5.2", "G5.3")):
            word = strange[0] if strange else at
            self.state.report(
                word,
                f"{word.code} between G5.2 and G5.3",
                "control points of the NURBS",
                f"write G5.3 before {word.text}",
            )
        elif code == "G5.3" and not self.open:
            self.state.report(
                at, "G5.3 without G5.2", "G5.2 with control points before", "see G5.2"
            )
        elif self.state.modes.plane is not Plane.XY:
            self.state.report(at, f"{code} outside of the plane XY", "G17", "write G17 before")
        elif code in ("G5", "G5.1") and not ("X" in values or "Y" in values):
            self.state.report(at, f"{code} without a position", "X Y", "give the end of the curve")
        else:
            return True
        return False

    def _way(self, values: dict[str, Word], letters: str) -> Point | None:
        """Two lengths of the block [mm], None if one is missing."""
        if any(letter not in values for letter in letters):
            return None
        scale = self.state.modes.mm_per_unit
        return values[letters[0]].value * scale, values[letters[1]].value * scale

    def _quadratic(
        self, start: Point, end: Point, values: dict[str, Word], at: Word
    ) -> list[Point]:
        way = self._way(values, "IJ")
        if way is None:
            return self._fail(at, "G5.1 without I and J", "both", "give the control point")
        return self._chords([start, _sum(start, way), end], [1.0] * 3, 3, at)

    def _cubic(self, start: Point, end: Point, values: dict[str, Word], at: Word) -> list[Point]:
        first, last = self._way(values, "IJ"), self._way(values, "PQ")
        if first is None and "I" not in values and "J" not in values:
            first = self.onward
        if first is None:
            return self._fail(
                at,
                "G5 without I and J",
                "both, or neither after another G5",
                "give the first control point from the start of the curve",
            )
        if last is None:
            return self._fail(
                at,
                "G5 without P and Q",
                "both",
                "give the second control point from the end of the curve",
            )
        self.onward = -last[0], -last[1]
        points = [start, _sum(start, first), _sum(end, last), end]
        return self._chords(points, [1.0] * 4, 4, at)

    def _collect(self, values: dict[str, Word], at: Word) -> None:
        if not self.open:
            self.points, self.weights, self.order = [self.state.programmed()[:2]], [1.0], 3
        first, self.open = not self.open, True
        weight, order = values.get("P"), values.get("L")
        self.state.motion = "G5.2"
        if order is not None and (
            not order.value.is_integer() or not 3 <= order.value <= MAX_ORDER
        ):
            self._fail(
                order,
                f"the order of the NURBS is {order.value:g}",
                f"an integer from 3 to {MAX_ORDER}",
                "L3 is a quadratic curve, L4 a cubic one",
            )
        elif order is not None:
            self.order = int(order.value)
        if weight is None or not weight.value > 0.0:
            self._fail(
                weight or at,
                "a control point without a positive weight",
                "P greater than 0",
                "write for instance P1",
            )
            return
        if first and not ("X" in values or "Y" in values):
            self.weights = [weight.value]
        elif "X" not in values or "Y" not in values:
            self._fail(
                at,
                "a control point needs X and Y",
                "both; P alone in the first block only",
                "give the other coordinate too",
            )
        elif len(self.points) == MAX_POINTS:
            self._fail(
                at,
                f"a NURBS of more than {MAX_POINTS} control points",
                "G5.3 before",
                "divide the curve",
            )
        else:
            self.points.append(target(self.state, values)[:2])
            self.weights.append(weight.value)

    def _finish(self, at: Word) -> list[Point]:
        self.state.motion, self.open = None, False
        if len(self.points) < self.order:
            return self._fail(
                at,
                f"{len(self.points)} control points for a NURBS of order {self.order}",
                f"at least {self.order}, the position at the first G5.2 among them",
                "give more control points or a smaller L",
            )
        return self._chords(self.points, self.weights, self.order, at)

    def _chords(
        self, points: list[Point], weights: list[float], order: int, at: Word
    ) -> list[Point]:
        try:
            return Nurbs(points, weights, order).chords(TOLERANCE_MM)
        except TooManyChordsError:
            return self._fail(
                at,
                f"the curve needs more than {MAX_CHORDS} chords of {TOLERANCE_MM * 1e3:g} um",
                "a smaller curve",
                "check the decimal points, or divide the curve",
            )


def _sum(a: Point, b: Point) -> Point:
    return a[0] + b[0], a[1] + b[1]
