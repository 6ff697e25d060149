# SPDX-License-Identifier: Apache-2.0
"""LuGre friction: the bristle's deflection exactly over a step of constant speed.

dz/dt = v - s0 |v| z / g(v) is linear in z for constant v: z goes to g(v) sign(v) / s0 with the rate
s0 |v| / g(v). The force is the mean over the step, s1 included as s1 (z_end - z_begin) / T, so
that work and deflection agree however long the step is.
"""

from __future__ import annotations

import math

from sim.robot.drives import Friction


def stribeck(friction: Friction, speed: float) -> float:
    """g(v) [N or N m]."""
    fall = math.exp(-((speed / friction.speed) ** 2))
    return friction.coulomb + (friction.static - friction.coulomb) * fall


def step(friction: Friction, deflection: float, speed: float, time: float) -> tuple[float, float]:
    """(deflection at the end, mean force) of `time` [s] at a constant speed."""
    if speed == 0.0:
        return deflection, friction.stiffness * deflection
    level = stribeck(friction, speed)
    rate = friction.stiffness * abs(speed) / level
    end = math.copysign(level / friction.stiffness, speed)
    share = -math.expm1(-rate * time)
    after = deflection + (end - deflection) * share
    mean = end - (end - deflection) * share / (rate * time) if rate * time > 1e-9 else deflection
    force = friction.stiffness * mean + friction.damping * (after - deflection) / time
    return after, force + friction.viscous * speed


def steady(friction: Friction, speed: float) -> float:
    """Force of a constant speed that has lasted [N or N m]."""
    sign = math.copysign(1.0, speed) if speed else 0.0
    return stribeck(friction, speed) * sign + friction.viscous * speed
