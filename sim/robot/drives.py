# SPDX-License-Identifier: Apache-2.0
"""Parameters of motors, inverters, current sensing and friction, from `sim/robot.toml`.

`Drives.load()` reads them next to `sim.robot.parameters.Robot`, from the same file. Axes are legs
1-3, tilt, rotation; `motors` has one `Motor` for each.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from sim.robot.parameter_record import ParameterError, Record, parameter

_SIZE = "the current loop's program and the inverter are made for drives of this size"
_BRISTLE = "the plant integrates the bristles exactly within these"


@dataclass(frozen=True)
class Motor:
    """A permanent-magnet synchronous motor in rotor coordinates (amplitude-invariant Park).

    pole: travel of one electrical turn [m or rad]; R [ohm], L_d, L_q [H], psi [V s]; i_max: peak of
    a phase [A]; cogging: amplitude [N or N m].
    """

    pole: float
    R: float
    L_d: float
    L_q: float
    psi: float
    i_max: float
    cogging: float

    @property
    def wave(self) -> float:
        """Electrical angle per travel [rad/m or rad/rad]."""
        return 2 * math.pi / self.pole

    def force(self, i_d: float, i_q: float) -> float:
        """3/2 wave (psi i_q + (L_d - L_q) i_d i_q) [N or N m], cogging apart."""
        return 1.5 * self.wave * (self.psi * i_q + (self.L_d - self.L_q) * i_d * i_q)

    @property
    def force_per_ampere(self) -> float:
        """Of i_q with i_d = 0 [N/A or N m/A]."""
        return self.force(0.0, 1.0)


@dataclass(frozen=True)
class Friction:
    """LuGre friction [C. Canudas de Wit et al., A New Model for Control of Systems with Friction,
    IEEE Transactions on Automatic Control 40(3), 1995]: F = s0 z + s1 dz/dt + s2 v, dz/dt =
    v - s0 |v| z / g(v), g = F_c + (F_s - F_c) exp(-(v/v_s)^2).
    """

    coulomb: float
    static: float
    speed: float
    stiffness: float
    damping: float
    viscous: float


class Inverter(Protocol):
    """What the current law takes of a machine's drives, or of one motor alone; SI units."""

    @property
    def motors(self) -> Sequence[Motor]: ...
    @property
    def current_scale(self) -> float: ...
    @property
    def U_dc(self) -> float: ...
    @property
    def dead_time(self) -> float: ...
    @property
    def delay_on(self) -> float: ...
    @property
    def delay_off(self) -> float: ...
    @property
    def drop(self) -> float: ...
    @property
    def f_pwm(self) -> float: ...


@dataclass(frozen=True)
class Drives(Record):
    """Parameters in SI units; the meaning of each is in `sim/robot.toml`.

    Coulomb friction is also a parameter of `sim.robot.parameters.Robot`: one value in both.
    """

    pole_legs: float = parameter("m", 0.001, 1.0, _SIZE)
    poles_tilt: float = parameter("1", 1, 100, _SIZE)
    poles_rotation: float = parameter("1", 1, 100, _SIZE)
    R_legs: float = parameter("ohm", 0.001, 100.0, _SIZE)
    L_d_legs: float = parameter("H", 1e-05, 1.0, _SIZE)
    L_q_legs: float = parameter("H", 1e-05, 1.0, _SIZE)
    psi_legs: float = parameter("V s", 0.0001, 10.0, _SIZE)
    i_max_legs: float = parameter("A", 0.1, 1000.0, _SIZE)
    cogging_legs: float = parameter("N", 0.0, 10000.0, _SIZE)
    R_tilt: float = parameter("ohm", 0.001, 100.0, _SIZE)
    L_d_tilt: float = parameter("H", 1e-05, 1.0, _SIZE)
    L_q_tilt: float = parameter("H", 1e-05, 1.0, _SIZE)
    psi_tilt: float = parameter("V s", 0.0001, 10.0, _SIZE)
    i_max_tilt: float = parameter("A", 0.1, 1000.0, _SIZE)
    cogging_tilt: float = parameter("N m", 0.0, 10000.0, _SIZE)
    R_rotation: float = parameter("ohm", 0.001, 100.0, _SIZE)
    L_d_rotation: float = parameter("H", 1e-05, 1.0, _SIZE)
    L_q_rotation: float = parameter("H", 1e-05, 1.0, _SIZE)
    psi_rotation: float = parameter("V s", 0.0001, 10.0, _SIZE)
    i_max_rotation: float = parameter("A", 0.1, 1000.0, _SIZE)
    cogging_rotation: float = parameter("N m", 0.0, 10000.0, _SIZE)
    U_dc: float = parameter("V", 10.0, 1000.0, _SIZE)
    dead_time: float = parameter("s", 0.0, 5e-06, _SIZE)
    delay_on: float = parameter("s", 0.0, 5e-06, _SIZE)
    delay_off: float = parameter("s", 0.0, 5e-06, _SIZE)
    drop: float = parameter("V", 0.0, 10.0, _SIZE)
    drop_resistance: float = parameter("ohm", 0.0, 1.0, _SIZE)
    f_pwm: float = parameter("Hz", 1000.0, 200000.0, _SIZE)
    f_modulator: float = parameter("Hz", 1000000.0, 50000000.0, _SIZE)
    current_scale: float = parameter("A", 0.1, 1000.0, _SIZE)
    current_offset: float = parameter("A", 0.0, 10.0, _SIZE)
    current_gain_error: float = parameter("1", 0.0, 0.5, _SIZE)
    friction_legs: float = parameter("N", 0.0, 1000000.0, _BRISTLE)
    lugre_static_legs: float = parameter("N", 0.0, 1000000.0, _BRISTLE)
    lugre_speed_legs: float = parameter("m/s", 1e-06, 10.0, _BRISTLE)
    lugre_stiffness_legs: float = parameter("N/m", 1.0, 1000000000000.0, _BRISTLE)
    lugre_damping_legs: float = parameter("N s/m", 0.0, 1000000000.0, _BRISTLE)
    lugre_viscous_legs: float = parameter("N s/m", 0.0, 1000000.0, _BRISTLE)
    friction_table: float = parameter("N m", 0.0, 1000000.0, _BRISTLE)
    lugre_static_table: float = parameter("N m", 0.0, 1000000.0, _BRISTLE)
    lugre_speed_table: float = parameter("rad/s", 1e-06, 10.0, _BRISTLE)
    lugre_stiffness_table: float = parameter("N m/rad", 1.0, 1000000000000.0, _BRISTLE)
    lugre_damping_table: float = parameter("N m s/rad", 0.0, 1000000000.0, _BRISTLE)
    lugre_viscous_table: float = parameter("N m s/rad", 0.0, 1000000.0, _BRISTLE)

    def __post_init__(self) -> None:
        super().__post_init__()
        for axis, unit in (("legs", "N"), ("table", "N m")):
            static, sliding = (getattr(self, f"{n}_{axis}") for n in ("lugre_static", "friction"))
            if static < sliding:
                raise ParameterError(
                    f"lugre_static_{axis} = {static} {unit}: must be >= friction_{axis} = {sliding}"
                    f" {unit}; no axis breaks away at less force than it slides with"
                )

    @cached_property
    def motors(self) -> tuple[Motor, ...]:
        """Of the five axes."""
        poles = {
            "legs": self.pole_legs,
            "tilt": 2 * math.pi / self.poles_tilt,
            "rotation": 2 * math.pi / self.poles_rotation,
        }
        names = ("R", "L_d", "L_q", "psi", "i_max", "cogging")
        found = {
            axis: Motor(pole, *(getattr(self, f"{name}_{axis}") for name in names))
            for axis, pole in poles.items()
        }
        return (found["legs"],) * 3 + (found["tilt"], found["rotation"])

    @cached_property
    def friction(self) -> tuple[Friction, ...]:
        """Of the five axes."""
        names = ("static", "speed", "stiffness", "damping", "viscous")
        legs, table = (
            Friction(
                getattr(self, f"friction_{axis}"),
                *(getattr(self, f"lugre_{name}_{axis}") for name in names),
            )
            for axis in ("legs", "table")
        )
        return (legs,) * 3 + (table,) * 2
