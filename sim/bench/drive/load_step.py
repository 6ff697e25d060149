# SPDX-License-Identifier: Apache-2.0
"""A load on one axis: how far it pushes a position loop with and without a disturbance observer.

The program of one axis runs on the core, around an exact motor that moves a mass. A proportional
and derivative law in double precision orders its force, so a load displaces the axis for good
unless the program itself compensates it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim.bench.drive.current_loop import loop_program
from sim.bench.drive.motor import Windings, phase_currents, space_vector
from sim.core.api import Core
from sim.laws.drive.current_law import MAGIC, Setting
from sim.robot.drives import Drives

BANDWIDTH = 2 * np.pi * 50.0  # rad/s of the position loop
LOAD = 0.08  # of the strongest force
BEFORE, PERIODS = 200, 3500  # periods before the load, and in all
MEAN = 500  # last periods, of which the displacement is the mean


@dataclass(frozen=True)
class Displaced:
    """Displacement [m or rad] that the load leaves, and its peak; cycles that ticks took."""

    lasting: float
    peak: float
    cycles: frozenset[int]


def load_step(
    drives: Drives, setting: Setting, axis: int, mass: float, backend: str = "rtl"
) -> Displaced:
    """The displacement of an axis with a mass or inertia [kg or kg m^2]. Raises CoreFault."""
    motor, period = drives.motors[axis], setting.period
    scale = drives.current_scale * setting.ampere_per_count
    load = LOAD * motor.force_per_ampere * motor.i_max
    windings, place, speed = Windings(motor), 0.0, 0.0
    waiting, places, cycles = (0.0, 0.0), [], set()
    image = loop_program(drives, setting, axes=(axis,)).image
    with Core(image, backend=backend) as core:
        for number in range(PERIODS):
            angle = motor.wave * place + setting.offset[axis]
            a, b, _ = phase_currents(windings.i_d, windings.i_q, angle)
            words = {
                f"q{axis}": round(place / setting.resolution[axis]),
                f"ia{axis}": round(a / scale),
                f"ib{axis}": round(b / scale),
                f"age{axis}": 0,
                "bus": round(drives.U_dc / setting.bus_scale),
            }
            order = -mass * BANDWIDTH * (BANDWIDTH * place + 2 * speed)
            out = core.tick(
                **{name: MAGIC + word for name, word in words.items()}, **{f"force{axis}": order}
            )
            if core.cycles is not None:
                cycles.add(core.cycles)
            duties = [(out[f"pwm{axis}{phase}"] - MAGIC) / setting.half for phase in "abc"]
            windings.advance(*waiting, angle, motor.wave * speed, period)
            waiting = space_vector(*(drives.U_dc * duty for duty in duties))
            against = load if number >= BEFORE else 0.0
            speed += period * (motor.force(windings.i_d, windings.i_q) - against) / mass
            place += period * speed
            places.append(place)
    found = np.array(places)
    return Displaced(
        float(abs(found[-MEAN:].mean())), float(np.abs(found).max()), frozenset(cycles)
    )
