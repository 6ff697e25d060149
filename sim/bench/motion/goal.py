# SPDX-License-Identifier: Apache-2.0
"""Goals of the motion front-end: what each is to reach, by whom it is measured, what was found.

A check stands below `FEATURES.feature`, which says what it measures; goals_*.py hold them. A check
gets how much to run and the figures of `microtick motion` by name, and returns its text and whether
the goal is met, None where it ran a sample only. It raises KeyError where a figure is not there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

SEED = 1  # of every random choice of the checks


@dataclass(frozen=True)
class Goal:
    """A feature. ours: as measured, "" where it is not; met: None where it is not measured.

    command: what measures it, or goes deeper.
    """

    feature: str
    published: str
    goal: str
    ours: str
    met: bool | None
    command: str


Measured = tuple[str, bool | None]
Rows = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True)
class Counts:
    """How much is run: moves against Ruckig, random programs, odd blocks, lines, circles, lines of
    all axes, drive timings, moves of a long part."""

    moves: int = 400
    classes: int = 20
    core: int = 300
    overrides: int = 60
    programs: int = 60
    odd: int = 1
    reach: int = 12
    radius: int = 60
    axes_lines: int = 20
    timings: int = 10
    part: int = 20_000


FULL = Counts(100_000, 1000, 20_000, 2000, 10_000, 1000, 64, 200, 300, 300, 1_000_000)
Check = Callable[[Counts, Rows], Measured]


@dataclass(frozen=True)
class Feature:
    """A row of the table before it is measured. check: None where only its command measures it;
    simulated: it runs on simulated RTL."""

    name: str
    published: str
    goal: str
    command: str
    check: Check | None
    simulated: bool = False


class Features(list[Feature]):
    """Rows of the table, in its order."""

    def feature(
        self, name: str, published: str, goal: str, command: str, simulated: bool = False
    ) -> Callable[[Check], Check]:
        """The check below measures this feature."""

        def register(check: Check) -> Check:
            self.append(Feature(name, published, goal, command, check, simulated))
            return check

        return register


def figures(*names: str) -> Check:
    """A check: figures that `microtick motion` has measured already."""

    def check(counts: Counts, rows: Rows) -> Measured:
        found = [rows[name] for name in names]
        text = "; ".join(
            f"{row['ours']:.4g}{' ' if row['unit'] else ''}{row['unit']}" for row in found
        )
        return text, all(row["agrees"] for row in found)

    return check
