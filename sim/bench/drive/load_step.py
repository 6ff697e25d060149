# SPDX-License-Identifier: Apache-2.0
"""Loads on axes: how far they push position loops with and without a disturbance observer.

The program of the current loops runs on the core, around exact motors that each move a mass. A
proportional and derivative law in double precision orders their forces, so a load displaces an axis
for good unless the program itself compensates it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.bench.drive.current_loop import loop_program
from sim.bench.drive.motor import Windings, phase_currents, space_vector
from sim.core.api import Core
from sim.laws.closed_loop import Values
from sim.laws.drive.current_law import MAGIC, Setting
from sim.robot.drives import Drives

BANDWIDTH = 2 * np.pi * 50.0  # rad/s of the position loop
LOAD = 0.08  # of the strongest force
BEFORE, PERIODS = 200, 3500  # periods before the load, and in all
LEGS = range(3)  # axes that move along a line; the others turn
MEAN = 500  # last periods, of which the displacement is the mean


@dataclass(frozen=True)
class Displaced:
    """Displacement [m or rad] that the load leaves, and its peak; cycles that ticks took."""

    lasting: float
    peak: float
    cycles: frozenset[int]


class Loaded:
    """Motors that each move a mass or inertia [kg or kg m^2] by axis, and meet a load after
    `BEFORE` periods: the machine of a closed loop. Its errors are the displacements [m or rad].
    """

    def __init__(
        self, drives: Drives, setting: Setting, masses: Mapping[int, float], ticks: int = PERIODS
    ) -> None:
        self.drives, self.setting, self.masses, self.ticks = drives, setting, masses, ticks
        self.start()

    @property
    def axes(self) -> Mapping[str, str]:
        """Unit of each displacement by the name of its axis."""
        return {f"axis {n}": "m" if n in LEGS else "rad" for n in self.masses}

    def start(self) -> None:
        """All motors at rest at their zero, without a load."""
        self.at = 0
        self.windings = {n: Windings(self.drives.motors[n]) for n in self.masses}
        self.place = dict.fromkeys(self.masses, 0.0)
        self.speed = dict.fromkeys(self.masses, 0.0)
        self.waiting = dict.fromkeys(self.masses, (0.0, 0.0))

    def _angle(self, n: int) -> float:
        return self.drives.motors[n].wave * self.place[n] + self.setting.offset[n]

    def inputs(self, tick: int) -> dict[str, float]:
        """Samples of the servo link, and the ordered forces [N or N m]."""
        scale = self.drives.current_scale * self.setting.ampere_per_count
        words = {"bus": round(self.drives.U_dc / self.setting.bus_scale)}
        orders = {}
        for n, mass in self.masses.items():
            a, b, _ = phase_currents(self.windings[n].i_d, self.windings[n].i_q, self._angle(n))
            words[f"q{n}"] = round(self.place[n] / self.setting.resolution[n])
            words |= {f"ia{n}": round(a / scale), f"ib{n}": round(b / scale), f"age{n}": 0}
            wanted = BANDWIDTH * (BANDWIDTH * self.place[n] + 2 * self.speed[n])
            orders[f"force{n}"] = -mass * wanted
        return {name: MAGIC + word for name, word in words.items()} | orders

    def step(self, outputs: Values) -> None:
        """A period: the voltages ordered one period before, then the masses move."""
        period = self.setting.period
        for n, mass in self.masses.items():
            motor, windings = self.drives.motors[n], self.windings[n]
            duties = [(outputs[f"pwm{n}{k}"] - MAGIC) / self.setting.half for k in "abc"]
            windings.advance(*self.waiting[n], self._angle(n), motor.wave * self.speed[n], period)
            self.waiting[n] = space_vector(*(self.drives.U_dc * duty for duty in duties))
            against = LOAD * motor.force_per_ampere * motor.i_max if self.at >= BEFORE else 0.0
            self.speed[n] += period * (motor.force(windings.i_d, windings.i_q) - against) / mass
            self.place[n] += period * self.speed[n]
        self.at += 1

    def error(self, tick: int) -> NDArray[np.float64]:
        """Displacements in the order of `axes`."""
        return np.array(list(self.place.values()))


def load_step(
    drives: Drives, setting: Setting, axis: int, mass: float, backend: str = "rtl"
) -> Displaced:
    """The displacement of an axis with a mass or inertia [kg or kg m^2]. Raises CoreFault."""
    machine, places, cycles = Loaded(drives, setting, {axis: mass}), [], set()
    image = loop_program(drives, setting, axes=(axis,)).image
    with Core(image, backend=backend) as core:
        for number in range(PERIODS):
            machine.step(core.tick(machine.inputs(number)))
            if core.cycles is not None:
                cycles.add(core.cycles)
            places.append(machine.place[axis])
    found = np.array(places)
    return Displaced(
        float(abs(found[-MEAN:].mean())), float(np.abs(found).max()), frozenset(cycles)
    )
