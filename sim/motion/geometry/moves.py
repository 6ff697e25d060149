# SPDX-License-Identifier: Apache-2.0
"""Moves of a program: what the G-code reader makes and the planners take; mm, degree, mm/min."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import Enum

AXES = "XYZAC"
MM_PER_INCH = 25.4

Pose = tuple[float, float, float, float, float]
"""x, y, z [mm], tilt A, rotation C [degree]."""


def pose_of(values: Iterable[float]) -> Pose:
    """A pose of five values."""
    x, y, z, tilt, rotation = values
    return x, y, z, tilt, rotation


class Motion(Enum):
    RAPID = "G0"
    LINEAR = "G1"
    ARC_CW = "G2"
    ARC_CCW = "G3"

    @property
    def is_arc(self) -> bool:
        return self is Motion.ARC_CW or self is Motion.ARC_CCW


class Plane(Enum):
    XY = "G17"
    ZX = "G18"
    YZ = "G19"

    @property
    def axes(self) -> tuple[int, int]:
        """Indices (first, second) of the plane's axes; counter-clockwise turns first to second."""
        return {Plane.XY: (0, 1), Plane.ZX: (2, 0), Plane.YZ: (1, 2)}[self]


@dataclass(frozen=True)
class Move:
    """One motion block. Poses and centre in mm and degrees, in absolute coordinates.

    feed is the F number in force as mm/min, for blocks that turn only the table as degree/min;
    it is None for rapids. centre holds the two coordinates in the order of plane.axes; turns (P of
    G2 and G3): an arc makes so many turns less one, and then the rest to its end.
    tolerance [mm]: greatest distance from the joints at the move's ends to the path run, 0 for
    G61, infinite for G64 without P; merge [mm]: Q of G64, within which lines are joined into one.
    inner: the move is a further part of its block, not a new one; exact_stop: G61.1, a move of its
    own from rest to rest; override: the feed override acts on it (M48), not so after M49.
    plane_turn [degree]: of an arc's plane about Z, of G18 or G19 in a rotated coordinate system;
    centre counts in the axes before that turn.
    """

    line: int
    source: str
    motion: Motion
    start: Pose
    end: Pose
    feed: float | None = None
    plane: Plane | None = None
    centre: tuple[float, float] | None = None
    tolerance: float = 0.0
    merge: float = 0.0
    inner: bool = False
    exact_stop: bool = False
    override: bool = True
    turns: int = 1
    plane_turn: float = 0.0

    @property
    def rate(self) -> float:
        """The feed of a move that is no rapid."""
        assert self.feed is not None, f"line {self.line}: a rapid has no feed"
        return self.feed

    @property
    def circle(self) -> tuple[tuple[int, int], tuple[float, float]]:
        """Axes of an arc's plane and its centre in them."""
        assert self.plane is not None and self.centre is not None, f"line {self.line}: no arc"
        return self.plane.axes, self.centre

    @property
    def turns_only_the_table(self) -> bool:
        """Whether it has no tool path, so that its feed counts the angles of the table."""
        return not self.motion.is_arc and self.start[:3] == self.end[:3]


@dataclass(frozen=True)
class Dwell:
    """A rest of `seconds` at the end of the moves before it (G4, G82)."""

    line: int
    source: str
    seconds: float


Item = Move | Dwell


@dataclass(frozen=True)
class GcodeProgram:
    """All moves of a text. dwells: (number of moves before it, rest)."""

    file: str
    start: Pose
    moves: tuple[Move, ...]
    dwells: tuple[tuple[int, Dwell], ...] = ()


def from_line(items: Iterable[Item], line: int, file: str) -> Iterator[Item]:
    """The items from the first one on whose block is in this line, or in a later one.

    Raises ValueError if there is none.
    """
    last, begun = 0, False
    for item in items:
        begun = begun or item.line >= line
        if begun:
            yield item
        last = max(last, item.line)
    if not begun:
        raise ValueError(
            f"{file}: error: no move is in line {line} or after it; the last is in line {last}; "
            "expected a smaller line (--from)"
        )
