# SPDX-License-Identifier: Apache-2.0
"""Velocity loop of one motor, with a position loop around it, ten times slower than its currents.

The speed is the difference of two counts, filtered. A PI controller makes a force of its error; the
gains are inertia times crossover, and a fifth of the crossover for the integral, which takes up
what the limit has cut off. Ordered acceleration and friction are fed forward; the friction has the
direction of the speed that both loops ask for, so that it does not end a move short of its end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca

from asip_asm.model.law import Law, Port
from sim.laws.drive.current_law import LARGEST

ORDERS = ("wanted", "speed", "acceleration", "hold")
"""Words of a row: position [count], speed and acceleration [unit/s, unit/s2], 1 to hold it."""
TITLE = "velocity loop"
INTEGRAL, FILTER, POSITION = 0.2, 6.0, 0.25  # of the crossover: integral, filter, position loop
SLOW = 0.5  # electrical speed at which the friction is fed forward as a whole [rad/s]


@dataclass(frozen=True)
class VelocitySetting:
    """crossover [rad/s], period [s]; resolution: travel of a count; wave: electrical angle of
    travel; inertia, coulomb, viscous as identified; most: limit of the force."""

    crossover: float
    period: float
    resolution: float
    wave: float
    inertia: float
    coulomb: float
    viscous: float
    most: float

    @property
    def share(self) -> float:
        """Of a new speed, by the filter."""
        return -math.expm1(-FILTER * self.crossover * self.period)


def velocity_law(setting: VelocitySetting) -> Law:
    """Inputs: count, then `ORDERS`; output: the force that the current loop takes."""
    fastest = 2e3 / setting.wave
    strongest = fastest * max(1.0, setting.crossover)
    limits = {
        "q": LARGEST,
        "wanted": LARGEST,
        "speed": fastest,
        "acceleration": strongest,
        "hold": 1.0,
    }
    ports = [
        Port("input", name, "1", "count, or ordered", limits=(-most, most))
        for name, most in limits.items()
    ]
    kept = {"before": LARGEST, "ready": 1.0, "rate": fastest, "integral": setting.most}
    ports += [
        Port("state", name, "1", "of the velocity loop", limits=(-most, most))
        for name, most in kept.items()
    ]
    at = {port.name: ca.SX.sym(port.name) for port in ports}
    moved = at["ready"] * (at["q"] - at["before"])
    rate = at["rate"] + setting.share * (moved * (setting.resolution / setting.period) - at["rate"])
    gain = setting.inertia * setting.crossover
    away = (at["wanted"] - at["q"]) * setting.resolution
    wanted = at["speed"] + at["hold"] * (POSITION * setting.crossover) * away
    error = wanted - rate
    direction = ca.fmax(ca.fmin(wanted * (setting.wave / SLOW), 1.0), -1.0)
    fed = setting.inertia * at["acceleration"] + setting.viscous * at["speed"]
    asked = gain * error + at["integral"] + fed + setting.coulomb * direction
    force = ca.fmax(ca.fmin(asked, setting.most), -setting.most)
    integral = INTEGRAL * setting.crossover * setting.period
    results = {
        "force": force,
        "before_next": at["q"],
        "ready_next": ca.SX(1.0),
        "rate_next": rate,
        "integral_next": at["integral"] + integral * (gain * error + force - asked),
    }
    meaning = "ordered force or torque"
    ports.append(
        Port("output", "force", "N", meaning, limits=(-setting.most, setting.most), safe=0.0)
    )
    function = ca.Function(
        "velocity_loop", list(at.values()), list(results.values()), list(at), list(results)
    )
    return Law(
        TITLE, function, ports, "velocity and position loop of one motor", 1 / setting.period
    )
