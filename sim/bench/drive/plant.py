# SPDX-License-Identifier: Apache-2.0
"""Parameters of the plant of robot and motors, `struct Parameters` of sim/bench/drive/plant.h."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.robot.drives import Drives
from sim.robot.parameters import Robot

AXES = 5
NAMES = (*(f"leg {n}" for n in (1, 2, 3)), "tilt", "rotation")
ROBOT = ("R", "m_s", "m_p", "J_a", "l_c", "mr_c", "J_44", "J_55", "m_4", "r_4", "g")
INVERTER = (
    *("U_dc", "dead_time", "delay_on", "delay_off", "drop", "drop_resistance", "current_scale"),
)
MOTOR = ("wave", "R", "L_d", "L_q", "psi", "cogging")
FRICTION = ("coulomb", "static", "speed", "stiffness", "damping", "viscous")
REST = (
    *("resolution", "angle_offset", "brake_stiffness", "brake_damping"),
    *("gain_a", "gain_b", "offset_a", "offset_b"),
)
PARAMETERS = np.dtype(
    [
        *((f"robot_{name}", float) for name in ROBOT),
        *((name, float) for name in INVERTER),
        (
            "axis",
            [*((f"motor_{name}", float) for name in MOTOR), *((n, float) for n in FRICTION + REST)],
            AXES,
        ),
    ]
)
BRAKES = ((4e7, 6e4),) * 3 + ((4e5, 1e3),) * 2  # stiffness and damping of a closed holding brake


@dataclass(frozen=True)
class Plant:
    """What the plant is besides its parameter file.

    angle: electrical angle at position 0 [rad]; friction: False takes friction and cogging away;
    sensing: False takes offsets and gain errors of the currents away.
    """

    robot: Robot
    drives: Drives
    angle: tuple[float, ...] = (0.7, -1.1, 2.3, 0.4, -2.6)
    friction: bool = True
    sensing: bool = True

    def record(self) -> NDArray[np.void]:
        """One record of `PARAMETERS`."""
        found = np.zeros((), dtype=PARAMETERS)
        for name in ROBOT:
            found[f"robot_{name}"] = getattr(self.robot, name)
        for name in INVERTER:
            found[name] = getattr(self.drives, name)
        for n, (motor, friction) in enumerate(
            zip(self.drives.motors, self.drives.friction, strict=True)
        ):
            axis = found["axis"][n]
            for name in MOTOR:
                axis[f"motor_{name}"] = getattr(motor, name)
            for name in FRICTION:
                axis[name] = getattr(friction, name)
            if not self.friction:
                for name in ("stiffness", "damping", "viscous", "motor_cogging"):
                    axis[name] = 0.0
            axis["resolution"] = self.robot.resolution[n]
            axis["angle_offset"] = self.angle[n]
            axis["brake_stiffness"], axis["brake_damping"] = BRAKES[n]
            if self.sensing:  # signs differ between phases and axes
                sign = 1 - 2 * (n % 2)
                axis["gain_a"] = sign * self.drives.current_gain_error
                axis["gain_b"] = -sign * self.drives.current_gain_error
                axis["offset_a"] = sign * self.drives.current_offset
                axis["offset_b"] = self.drives.current_offset
        return found
