# SPDX-License-Identifier: Apache-2.0
"""Speed of each axis from an observer of the law's own loop, in double precision.

It predicts the count of an axis from the acceleration a that the law asks for, and corrects by what
is left, with three equal poles theta [G. F. Franklin, J. D. Powell, M. Workman, Digital Control of
Dynamic Systems, 1998, section 8.2; the gains: P. R. Kalata, IEEE TAES 20(2), 1984]:

    r = offset - q (n(t) - n(t - 1))               predicted position less the count's
    v = speed - 1.5 (1 - theta)^2 (1 + theta) r/T   the speed that the law takes
    p = pull - (1 - theta)^3 r/T^2                  acceleration that the law did not ask for
    offset' = theta^3 r + T v + T^2/2 (a + p),  speed' = v + T (a + p),  pull' = p

theta = (1 - x/2)/(1 + x/2), about exp(-x), with x = observer_ratio 2 pi f T_s. The law takes
observer_share p off what it asks for: friction above all. Ratio and share are parameters of
asip_asm/programs/tracking_observer.interface.toml. Where an output is at its limit the
law asks for more than the machine does; `pull` takes the difference as it takes a load.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asip_asm.interface import program_interface
from sim.robot.parameters import Robot

SPEEDS = ("difference", "observer", "stamps")
"""Where the law takes the speed of an axis from; the first one is the paper's."""
AXES = 5


@dataclass(frozen=True)
class Gains:
    """Of an axis: theta^3 [1], of the speed [1/s], of the pull [1/s^2]; share that the law takes
    off [1]."""

    kept: float
    speed: float
    pull: float
    share: float


def checked_speed(name: str) -> str:
    """The name, if it is one of `SPEEDS`. Raises ValueError."""
    if name not in SPEEDS:
        raise ValueError(f"speed {name!r}: must be one of {', '.join(SPEEDS)}")
    return name


def gains(robot: Robot) -> tuple[Gains, ...]:
    """Of the five axes."""
    record = program_interface("tracking_observer")
    names = record.names(robot.values())
    ratio, share = names["observer_ratio"], names["observer_share"]
    found = []
    for f in (robot.f_legs,) * 3 + (robot.f_table,) * 2:
        half = ratio * math.pi * f * robot.T_s
        theta = (1.0 - half) / (1.0 + half)
        rest = 1.0 - theta
        found.append(
            Gains(
                theta**3,
                1.5 * rest * rest * (1.0 + theta) / robot.T_s,
                rest**3 / (robot.T_s * robot.T_s),
                share,
            )
        )
    return tuple(found)


class Observer:
    """Observers of the five axes with their state between ticks: `offset`, `speed`, `pull`."""

    def __init__(self, robot: Robot) -> None:
        self._gains, self._period, self._scale = gains(robot), robot.T_s, robot.resolution
        self.offset, self.rest, self.speed, self.pull = ([0.0] * AXES for _ in range(4))

    @property
    def taken_off(self) -> tuple[float, ...]:
        """Share of the pulls [m/s^2, rad/s^2]."""
        return tuple(gain.share * p for gain, p in zip(self._gains, self.pull, strict=True))

    def correct(self, moved: Sequence[int]) -> tuple[float, ...]:
        """Speeds of the five axes [m/s, rad/s]; moved: counts since the last tick."""
        for n, gain in enumerate(self._gains):
            rest = self.rest[n] = self.offset[n] - self._scale[n] * moved[n]
            self.offset[n] = gain.kept * rest
            self.speed[n] -= gain.speed * rest
            self.pull[n] -= gain.pull * rest
        return tuple(self.speed)

    def predict(self, asked: Sequence[float]) -> None:
        """The next tick; asked: accelerations that the law asks for [m/s^2, rad/s^2]."""
        period = self._period
        for n in range(AXES):
            a = asked[n] + self.pull[n]
            self.offset[n] += period * self.speed[n] + 0.5 * period * period * a
            self.speed[n] += period * a


@dataclass(frozen=True)
class Observed:
    """The observers over N ticks, each (N, 5): r, corrected speed and pull, and what the law takes
    off."""

    rest: NDArray[np.float64]
    speed: NDArray[np.float64]
    pull: NDArray[np.float64]
    taken_off: NDArray[np.float64]


def observed(
    robot: Robot, counts: NDArray[np.integer], asked_at_rest: NDArray[np.float64]
) -> Observed:
    """The observers over recorded counts (N, 5) from the start state.

    asked_at_rest: what the law asks for with speed and pull 0, (N, 5).
    """
    observer = Observer(robot)
    moved = np.diff(counts, axis=0, prepend=counts[:1]).tolist()
    rows = []
    for steps, at_rest in zip(moved, asked_at_rest.tolist(), strict=True):
        speeds = observer.correct(steps)
        off = observer.taken_off
        rows.append((*observer.rest, *speeds, *observer.pull, *off))
        observer.predict(
            [a - k * v - p for a, k, v, p in zip(at_rest, robot.K_V, speeds, off, strict=True)]
        )
    return Observed(*np.array(rows).reshape(len(counts), 4, AXES).transpose(1, 0, 2))
