# SPDX-License-Identifier: Apache-2.0
"""Cutter radius compensation (G41 G42): the path of the tool's centre next to the contour.

The contour comes in as moves, the path of the centre comes out; both are in coordinates of the
machine. Corners and entry moves are those of LinuxCNC ("Cutter Compensation"), as its interpreter
rs274 makes them, and are compared with it in the tests:

- the entry move, the first one, is not shorter than the radius; it ends next to the end of
  the contour's move, and no corner is made before it. An entry arc becomes another one that is
  tangent there;
- at a convex corner of more than CORNER the tool turns on an arc about the corner, in a rapid on a
  line; the table axes turn during that arc;
- at a concave corner both moves are cut where the offset curves meet. So each move is held until
  the next one with a way in the plane is known. A move that would have to go backwards, or an arc
  that would have to become longer, gouges: that is an error.

Points of the plane are complex numbers; side is +1 with the tool on the left of the contour.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace

from sim.motion.geometry.curves import FULL_TURN_BELOW
from sim.motion.geometry.moves import Dwell, Motion, Move, Plane, Pose, pose_of

CORNER = 0.05  # rad; as rs274 (2.9): smaller turns are no corners
MAX_HELD = 1000  # moves without a way in the plane between two that have one
NOWHERE = 1e-9  # mm; shorter ways in the plane are rounding
_PERPENDICULAR = 1e-4  # cosine below which no arc of entry exists, as rs274


class CompensationError(ValueError):
    """The tool cannot follow: what, expected, help."""


@dataclass
class _Held:
    """A move of the centre whose end may change. move.start does not count.

    way: of a line, to see whether it is reversed; sweep: of an arc on the contour [rad], 0 if its
    end stays.
    """

    move: Move
    end: complex
    way: complex = 0j
    sweep: float = 0.0

    @property
    def centre(self) -> complex:
        return complex(*self.move.circle[1])

    @property
    def turn(self) -> int:
        return _turn(self.move)


class Compensation:
    """From G41 or G42 to G40. start: pose of machine and contour at the beginning."""

    def __init__(self, plane: Plane, side: int, radius: float, start: Pose) -> None:
        self.plane, self.side, self.radius = plane, side, radius
        self.entered = False
        self.at = start  # end of the last move given out
        self.contour = self.centre = self._point(start)  # ends of the last move taken
        self.height = start[3 - sum(plane.axes)]
        self.anchor: complex | None = None  # where the first move held begins
        self.held: list[_Held | Dwell] = []
        self.out: list[Move | Dwell] = []

    def add(self, item: Move | Dwell) -> list[Move | Dwell]:
        """Takes a move of the contour or a rest, gives what is final; raises CompensationError."""
        if isinstance(item, Dwell):
            (self.held if self.held else self.out).append(item)
        elif not self.entered:
            (self._entry_arc if item.motion.is_arc else self._entry_line)(item)
            self.entered = True
        else:
            (self._arc if item.motion.is_arc else self._line)(item)
        if len(self.held) > MAX_HELD:
            raise CompensationError(
                f"{MAX_HELD} moves and rests follow each other without a way in the plane",
                "a move in the plane of the compensation",
                "end the compensation with G40 before",
            )
        if isinstance(item, Move):
            self.contour = self._point(item.end)
            self.height = item.end[3 - sum(self.plane.axes)]
        return self._taken()

    def finish(self) -> list[Move | Dwell]:
        """What is left at G40 or at the end of the program. Raises CompensationError."""
        self._cut(self.centre)
        return self._taken()

    def _taken(self) -> list[Move | Dwell]:
        out, self.out = self.out, []
        return out

    # Plane

    def _point(self, pose: Pose) -> complex:
        first, second = self.plane.axes
        return complex(pose[first], pose[second])

    def _pose(self, point: complex, pose: Pose) -> Pose:
        """The pose with its place in the plane replaced."""
        place = list(pose)
        place[self.plane.axes[0]], place[self.plane.axes[1]] = point.real, point.imag
        return pose_of(place)

    def _inside(self, turn: int) -> bool:
        """Whether the tool is inside an arc of that turn."""
        return self.side * turn > 0

    # Moves that are held

    def _hold(self, move: Move, end: complex, way: complex = 0j, sweep: float = 0.0) -> None:
        self.held.append(_Held(move, end, way, sweep))
        self.centre = end

    def _release(self, anchor: complex | None) -> None:
        """Gives out all moves held; the next one begins at the anchor."""
        for item in self.held:
            if isinstance(item, _Held):
                end = self._pose(item.end, item.move.end)
                self.out.append(replace(item.move, start=self.at, end=end))
                self.at = end
            else:
                self.out.append(item)
        self.held.clear()
        self.anchor = anchor

    def _cut(self, end: complex) -> None:
        """Gives out all moves held, ended at a point of the offset curve."""
        if not self.held:
            return
        for item in self.held:
            if isinstance(item, _Held):
                self._check(item, end)
                item.end = end
        self._release(end)

    def _check(self, item: _Held, end: complex) -> None:
        """Refuses a move that would have to be longer or backwards."""
        if item.move.motion.is_arc:
            if abs(abs(item.end - item.centre) - abs(end - item.centre)) > 0.01:
                raise _gouging(f"the arc of line {item.move.line}")
            if item.sweep and self.anchor is not None:
                sweep = _sweep(self.anchor, item.centre, item.turn, end)
                if sweep > item.sweep + 0.001:
                    raise _gouging(f"the arc of line {item.move.line}")
        elif self.anchor is not None and _dot(item.way, end - self.anchor) < 0.0:
            raise _gouging(f"the line of line {item.move.line}")

    # Entry

    def _entry_line(self, move: Move) -> None:
        goal = self._point(move.end)
        way = goal - self.contour
        if abs(way) < self.radius - NOWHERE:
            raise CompensationError(
                f"the entry move of the compensation, {abs(way):.4f} mm in the plane, is "
                f"shorter than the radius of the tool, {self.radius:.4f} mm",
                "a longer entry move",
                "begin farther from the contour, and move in the plane first",
            )
        normal = self.side * 1j * way / abs(way)
        self.anchor = self.contour
        self._hold(move, goal + self.radius * normal, normal)

    def _entry_arc(self, move: Move) -> None:
        goal, centre, turn = self._point(move.end), complex(*move.circle[1]), _turn(move)
        if abs(goal - self.contour) < self.radius - NOWHERE:
            raise CompensationError(
                f"the ends of the entry arc are {abs(goal - self.contour):.4f} mm apart, less "
                f"than the radius of the tool, {self.radius:.4f} mm",
                "a longer entry arc",
                "begin farther from the contour",
            )
        self._check_radius(abs(self.contour - centre), turn)
        outwards = (goal - centre) / abs(goal - centre)
        end = goal + self.radius * outwards * (-1 if self._inside(turn) else 1)
        inwards = (centre - end) / abs(centre - end)
        # The new centre is on the normal at the end, and equally far from both ends.
        cosine = _dot(inwards, (self.contour - end) / abs(self.contour - end))
        if abs(cosine) < _PERPENDICULAR:
            raise _too_small(abs(goal - centre), self.radius)
        middle = end + inwards * abs(self.contour - end) / 2 / cosine
        moved = replace(move, centre=(middle.real, middle.imag))
        self._hold(moved, end, sweep=_sweep(self.contour, middle, turn, end))

    # Lines

    def _line(self, move: Move) -> None:
        goal = self._point(move.end)
        way = goal - self.contour
        if abs(way) < NOWHERE:
            self._hold(move, self.centre)
            return
        normal = self.side * 1j * way / abs(way)
        outer = self._previous_arc(outside=True)
        beta = self._corner(cmath.phase(way))
        if beta < -CORNER or beta > math.pi + CORNER or (outer and beta > math.pi - CORNER):
            self._cut(self._line_corner(way, beta))
        elif beta > CORNER:
            move = self._go_round(move, self.contour + self.radius * normal)
        else:
            self._release(self.centre)
        self._hold(move, goal + self.radius * normal, way)

    def _line_corner(self, way: complex, beta: float) -> complex:
        """Where the offset curves of the last move and a line meet inside a corner."""
        arc = self._previous_arc()
        if arc is None:
            half = (beta + math.pi) / 2
            if half == 0.0:
                raise _gouging("a line that goes straight back")
            backwards = self.side * 1j * (self.centre - self.contour) / self.radius
            return self.centre + self.radius / math.tan(half) * backwards
        inside = self._inside(arc.turn)
        radius = abs(arc.end - arc.centre)
        if radius < NOWHERE:
            raise _no_room("from an arc to a line")
        on_contour = radius + self.radius * (1 if inside else -1)
        theta = cmath.phase(way) + arc.turn * math.pi / 2
        across = on_contour * math.cos(theta - cmath.phase(arc.centre - self.contour))
        ratio = (across + self.radius * (-1 if inside else 1)) / radius
        if not abs(ratio) <= 1.0:
            raise _no_room("from an arc to a line")
        angle = theta + math.pi - (1 if inside else -1) * arc.turn * math.acos(ratio)
        return arc.centre + cmath.rect(radius, angle)

    def _go_round(self, move: Move, end: complex) -> Move:
        """Around a convex corner to `end`; returns the move, which is now a further part."""
        (self._cut if not move.motion.is_arc else lambda _: self._release(None))(self.centre)
        pose = list(self._pose(end, move.end))
        pose[3 - sum(self.plane.axes)] = self.height
        corner = replace(move, end=pose_of(pose))
        if move.motion is not Motion.RAPID:
            turn = Motion.ARC_CW if self.side > 0 else Motion.ARC_CCW
            centre = self.contour.real, self.contour.imag
            corner = replace(corner, motion=turn, plane=self.plane, centre=centre, turns=1)
        self._hold(corner, end)
        self._release(end)
        return replace(move, inner=True)

    # Arcs

    def _arc(self, move: Move) -> None:
        goal, centre, turn = self._point(move.end), complex(*move.circle[1]), _turn(move)
        radius, inside = abs(centre - goal), self._inside(turn)
        self._check_radius(radius, turn)
        to_side = -1 if inside else 1
        outwards = (goal - centre) / radius
        start = (self.contour - centre) / abs(self.contour - centre)
        beta = self._corner(cmath.phase(1j * turn * start))
        cusp = abs(beta - math.pi) < CORNER and not inside
        if beta < -CORNER or beta > math.pi + CORNER or cusp:
            self._cut(self._arc_corner(centre, radius, turn, beta))
        elif beta > CORNER:
            move = self._go_round(move, self.contour + to_side * self.radius * start)
        else:
            self._release(None)
        sweep = _sweep(self.contour, centre, turn, goal)
        self._hold(move, goal + to_side * self.radius * outwards, sweep=sweep)

    def _arc_corner(self, centre: complex, radius: float, turn: int, beta: float) -> complex:
        """Where the offset curves of the last move and an arc meet inside a corner."""
        inside, before = self._inside(turn), self._previous_arc()
        offset = radius - self.radius if inside else radius + self.radius
        if offset < NOWHERE:
            raise _no_room("to an arc")
        if before is None:
            heading = self._heading()
            across = radius * math.sin(beta - math.pi / 2)
            ratio = (across + self.radius * (1 if inside else -1)) / offset
            if not abs(ratio) <= 1.0:
                raise _gouging("the arc")
            angle = heading + turn * math.asin(ratio)
            if not inside:
                angle = heading + math.pi - turn * math.asin(ratio)
            return centre + cmath.rect(offset, angle)
        first, apart = abs(before.end - before.centre), abs(before.centre - centre)
        if first < NOWHERE or apart < NOWHERE:
            raise _no_room("between arcs of one centre")
        ratio = (first**2 + apart**2 - offset**2) / (2 * first * apart)
        if not abs(ratio) <= 1.0:
            raise _no_room("from an arc to an arc")
        back = turn * math.acos(ratio) * (1 if self._inside(before.turn) else -1)
        return before.centre + cmath.rect(first, cmath.phase(centre - before.centre) + back)

    def _check_radius(self, radius: float, turn: int) -> None:
        if self._inside(turn) and radius < self.radius - NOWHERE:
            raise _too_small(radius, self.radius)

    # Corners

    def _heading(self) -> float:
        """Direction at the end of the last move: the tool is square to it."""
        return cmath.phase(self.centre - self.contour) - self.side * math.pi / 2

    def _corner(self, direction: float) -> float:
        """Turn towards the contour at a corner, -pi/2 to 3 pi/2; negative ones are concave."""
        turn = self.side * (self._heading() - direction)
        return (turn + math.pi / 2) % (2 * math.pi) - math.pi / 2

    def _previous_arc(self, outside: bool = False) -> _Held | None:
        """The first move held, if it is an arc; outside: if the tool is outside of it."""
        first = self.held[0] if self.held else None
        if not isinstance(first, _Held) or not first.move.motion.is_arc:
            return None
        return None if outside and self._inside(first.turn) else first


def _turn(move: Move) -> int:
    return 1 if move.motion is Motion.ARC_CCW else -1


def _dot(a: complex, b: complex) -> float:
    return (a * b.conjugate()).real


def _sweep(start: complex, centre: complex, turn: int, end: complex) -> float:
    """Angle of an arc [rad], a full turn where both ends are one point."""
    angle = turn * (cmath.phase(end - centre) - cmath.phase(start - centre)) % (2 * math.pi)
    return angle + 2 * math.pi if angle < FULL_TURN_BELOW else angle


def _gouging(what: str) -> CompensationError:
    return CompensationError(
        f"{what} ends in a concave corner that the tool cannot reach without gouging",
        "moves longer than the tool needs at the corner",
        "take a smaller tool, or leave the corner out of the contour",
    )


def _no_room(where: str) -> CompensationError:
    return CompensationError(
        f"the tool does not fit into the corner {where} without gouging",
        "a corner with room for the radius of the tool",
        "take a smaller tool, or leave the corner out of the contour",
    )


def _too_small(radius: float, tool: float) -> CompensationError:
    return CompensationError(
        f"the arc of radius {radius:.4f} mm has no room for the tool of radius {tool:.4f} mm",
        "a radius greater than that of the tool",
        "take a smaller tool or a greater arc",
    )
