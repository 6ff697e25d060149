# SPDX-License-Identifier: Apache-2.0
"""What a user states of a robot besides its URDF: held joints, the tip, limits, encoders."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from asip_asm.diagnostics import closest
from sim.laws.elements import LARGEST, NUMBER, SHOWN, RobotError

ALL = ""
"""In place of a joint's name: every joint for which neither the file nor another option states the
value.
"""
Range = tuple[float, float]
Words = Mapping[str, float]


@dataclass(frozen=True)
class Stated:
    """Options by joint name, or `ALL`. SI units.

    locked: position at which a joint is held. tip: link for the kinematics. range: of positions.
    counts: encoder counts per turn (prismatic: per 0.1 m). sign: -1 where counts rise against the
    joint. zero: position at count 0. motor_encoders: counts are those of the motors, by the
    reductions and offsets of the file's transmissions.
    """

    locked: Words = field(default_factory=dict)
    tip: str | None = None
    effort: Words = field(default_factory=dict)
    velocity: Words = field(default_factory=dict)
    range: Mapping[str, Range] = field(default_factory=dict)
    counts: Words = field(default_factory=dict)
    sign: Words = field(default_factory=dict)
    zero: Words = field(default_factory=dict)
    motor_encoders: bool = False

    def check_names(self, file: str, joints: Iterable[str], followers: Mapping[str, str]) -> None:
        """Raises RobotError for an option of a joint that is not there or follows another one."""
        known = list(joints)
        options = ("locked", "effort", "velocity", "range", "counts", "sign", "zero")
        for option in options:
            for name in getattr(self, option):
                where = f"{file}: --{'lock' if option == 'locked' else option}"
                if name != ALL and name not in known:
                    near = closest(name, known) or f"it has {', '.join(known)}"
                    raise RobotError(f"{where}: no joint {name:.{SHOWN}}; {near}")
                if name in followers:
                    raise RobotError(
                        f"{where}: joint {name} mimics {followers[name]}; state it of "
                        f"{followers[name]}"
                    )


T = TypeVar("T")


def chosen(words: Mapping[str, T], name: str, default: T | None) -> T | None:
    """Value for a joint: its own, the file's, that for all."""
    if name in words:
        return words[name]
    return words.get(ALL) if default is None else default


def number(text: str) -> float:
    """A number. Raises ValueError."""
    if not NUMBER.fullmatch(text) or not abs(float(text)) <= LARGEST:
        raise ValueError(f"'{text:.{SHOWN}}' is no number")
    return float(text)


def positive(text: str) -> float:
    """A number above 0. Raises ValueError."""
    value = number(text)
    if not value > 0:
        raise ValueError(f"'{text:.{SHOWN}}' is not above 0")
    return value


def direction(text: str) -> float:
    """1 or -1. Raises ValueError."""
    if number(text) not in (1, -1):
        raise ValueError(f"'{text:.{SHOWN}}' is neither 1 nor -1")
    return float(text)


def span(text: str) -> Range:
    """LOW:HIGH. Raises ValueError."""
    low, colon, high = text.partition(":")
    if not colon:
        raise ValueError(f"'{text:.{SHOWN}}' is no range LOW:HIGH")
    found = number(low), number(high)
    if not found[0] < found[1] or math.isclose(*found, rel_tol=1e-9):
        raise ValueError(f"'{text:.{SHOWN}}': the low end is not below the high one")
    return found
