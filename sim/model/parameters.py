# SPDX-License-Identifier: Apache-2.0
"""Parameters of the robot and its controller, read from `sim/robot.toml` and checked.

Every field of `Robot` is one table of the file, with the same name. A value that is missing,
unknown, not finite, in another unit or outside its limit raises `ParameterError` with name, value
and limit.
"""

from __future__ import annotations

import difflib
import math
import tomllib
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Any

ROBOT_TOML = Path(__file__).resolve().parent.parent / "robot.toml"

_LIMITS = {
    "> 0": lambda value: value > 0,
    ">= 0": lambda value: value >= 0,
    ">= 1": lambda value: value >= 1,
}


class ParameterError(ValueError):
    """A parameter of the robot is missing, unknown or outside its limit."""


def _parameter(unit: str, limit: str = "> 0") -> Any:
    return field(metadata={"unit": unit, "limit": limit})


@dataclass(frozen=True)
class Robot:
    """Parameters in SI units; the meaning of each stands in `sim/robot.toml`.

    The properties are derived: leg start points, gains and other vectors over the five axes (legs
    1-3, tilt, rotation). Raises ParameterError also from `dataclasses.replace`.
    """

    R: float = _parameter("m")
    h: float = _parameter("m", ">= 0")
    x_max: float = _parameter("m")
    y_max: float = _parameter("m")
    z_min: float = _parameter("m")
    z_max: float = _parameter("m")
    m_s: float = _parameter("kg", ">= 0")
    m_p: float = _parameter("kg")
    J_a: float = _parameter("kg m^2", ">= 0")
    l_c: float = _parameter("m", ">= 0")
    mr_c: float = _parameter("kg m", ">= 0")
    J_44: float = _parameter("kg m^2")
    J_55: float = _parameter("kg m^2")
    m_4: float = _parameter("kg", ">= 0")
    r_4: float = _parameter("m", ">= 0")
    g: float = _parameter("m/s^2", ">= 0")
    T_s: float = _parameter("s")
    f_legs: float = _parameter("Hz")
    f_table: float = _parameter("Hz")
    s_max_legs: float = _parameter("m s", ">= 0")
    s_max_table: float = _parameter("rad s", ">= 0")
    xi_c: float = _parameter("1", ">= 1")
    T_c: float = _parameter("s")
    e_c_legs: float = _parameter("m", ">= 0")
    e_c_table: float = _parameter("rad", ">= 0")
    F_max: float = _parameter("N")
    tau_max_4: float = _parameter("N m")
    tau_max_5: float = _parameter("N m")
    friction_legs: float = _parameter("N", ">= 0")
    friction_table: float = _parameter("N m", ">= 0")
    friction_speed_legs: float = _parameter("m/s")
    friction_speed_table: float = _parameter("rad/s")
    encoder_legs: float = _parameter("m/count")
    turn_table: float = _parameter("count")

    @classmethod
    def load(cls, path: Path | None = None) -> Robot:
        """Read the parameters from `path`, by default `sim/robot.toml`."""
        tables = tomllib.loads((path or ROBOT_TOML).read_text(encoding="utf-8"))
        known = {entry.name: entry for entry in fields(cls)}
        for name in tables:
            if name not in known:
                close = difflib.get_close_matches(name, known, n=1)
                hint = f"; did you mean {close[0]}?" if close else ""
                raise ParameterError(f"{name}: unknown parameter{hint}")
        values = {}
        for name, entry in known.items():
            if name not in tables:
                raise ParameterError(f"{name}: missing parameter, unit {entry.metadata['unit']}")
            table = tables[name]
            if set(table) != {"value", "unit", "meaning"}:
                raise ParameterError(
                    f"{name}: has keys {sorted(table)}, must be meaning, unit, value"
                )
            if table["unit"] != entry.metadata["unit"]:
                raise ParameterError(
                    f"{name}: unit is {table['unit']!r}, must be {entry.metadata['unit']!r}"
                )
            values[name] = table["value"]
        return cls(**values)

    def __post_init__(self) -> None:
        for entry in fields(self):
            value, unit = getattr(self, entry.name), entry.metadata["unit"]
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise ParameterError(f"{entry.name} = {value!r}: must be a number")
            if not math.isfinite(value):
                raise ParameterError(f"{entry.name} = {value} {unit}: must be finite")
            limit = entry.metadata["limit"]
            if not _LIMITS[limit](value):
                raise ParameterError(f"{entry.name} = {value} {unit}: must be {limit} {unit}")
            object.__setattr__(self, entry.name, float(value))
        if self.z_max <= self.z_min:
            raise ParameterError(f"z_max = {self.z_max} m: must be > z_min = {self.z_min} m")
        if abs(self.T_c / self.T_s - self.boost_ticks) > 1e-9 or self.boost_ticks < 2:
            raise ParameterError(
                f"T_c = {self.T_c} s: must be a whole number >= 2 of periods T_s = {self.T_s} s"
            )

    @cached_property
    def legs(self) -> tuple[tuple[float, float], ...]:
        """Start points (x_pi, y_pi) of the legs in m, (4)-(6)."""
        half, across = 0.5 * self.R, 0.5 * math.sqrt(3.0) * self.R
        return ((0.0, self.R), (across, -half), (-across, -half))

    @cached_property
    def boost_ticks(self) -> int:
        """T_c in control periods: the tick count from which the integration boost is over."""
        return round(self.T_c / self.T_s)

    @cached_property
    def encoder_table(self) -> float:
        """Resolution of the table encoders in rad per count."""
        return 2.0 * math.pi / self.turn_table

    @cached_property
    def resolution(self) -> tuple[float, ...]:
        """Encoder resolution of the five axes in m or rad per count."""
        return (self.encoder_legs,) * 3 + (self.encoder_table,) * 2

    @cached_property
    def _omega(self) -> tuple[float, ...]:
        return (2.0 * math.pi * self.f_legs,) * 3 + (2.0 * math.pi * self.f_table,) * 2

    @cached_property
    def K_P(self) -> tuple[float, ...]:
        """Position gains 3 omega^2 of the five axes in 1/s^2."""
        return tuple(3.0 * omega**2 for omega in self._omega)

    @cached_property
    def K_V(self) -> tuple[float, ...]:
        """Velocity gains 3 omega of the five axes in 1/s."""
        return tuple(3.0 * omega for omega in self._omega)

    @cached_property
    def K_I(self) -> tuple[float, ...]:
        """Integral gains omega^3 of the five axes in 1/s^3."""
        return tuple(omega**3 for omega in self._omega)

    @cached_property
    def s_max(self) -> tuple[float, ...]:
        """Integrator bounds of the five axes in m s or rad s; s_min = -s_max."""
        return (self.s_max_legs,) * 3 + (self.s_max_table,) * 2

    @cached_property
    def e_c(self) -> tuple[float, ...]:
        """Small-error thresholds of the five axes in m or rad."""
        return (self.e_c_legs,) * 3 + (self.e_c_table,) * 2

    @cached_property
    def output_max(self) -> tuple[float, ...]:
        """Output limits of the five axes in N or N m."""
        return (self.F_max,) * 3 + (self.tau_max_4, self.tau_max_5)
