# SPDX-License-Identifier: Apache-2.0
"""Parameters of the robot and its controller, read from `sim/robot.toml` and checked.

Every field of `Robot` is one table of the file, with the same name. A value that is missing,
unknown, not finite, in another unit or outside its limits raises `ParameterError` with name, value,
limits and the reason for them. Within the limits every controller program keeps the error bounds
of `sim.bench.run.bounds`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from functools import cached_property

from sim.robot.drives import Drives
from sim.robot.parameter_record import ROBOT_TOML, ParameterError, Record, parameter

__all__ = ["ROBOT_TOML", "ParameterError", "Robot"]

# Legs are shorter [m]: squares of multiples of 2^-11 and their sums are exact in binary32 below 4.
LONGEST_LEG = 2.0 - 2.0**-8
LARGEST_COUNT = 2**24  # encoder counts are exact as binary32 up to here
LARGEST_BOOST = 2**20  # ticks; the tick count of the boost is a binary32
LARGEST_TILT = 256.0  # rad, of the hardware sine
LEAST_HEIGHT = 0.25  # of z_min, in R
SAMPLES_PER_BANDWIDTH = 50  # control periods per period of a loop's bandwidth, at least

_SIZE = "the error bounds hold for machines of this size"
_PLANNED = "the look-ahead planner computes with such limits"
_SINE = f"the hardware sine takes {LARGEST_TILT:g} rad, and a program starts at angle 0"
_TURNS = "encoder counts of the angle are exact as binary32, and a program starts at angle 0"
_SELECTS = "the optimised program selects by a quarter tick"


@dataclass(frozen=True)
class Robot(Record):
    """Parameters in SI units; the meaning of each is in `sim/robot.toml`.

    The properties are derived: leg start points, gains and other vectors over the five axes (legs
    1-3, tilt, rotation). Raises ParameterError also from `dataclasses.replace`.
    """

    others = tuple(entry.name for entry in fields(Drives))

    R: float = parameter("m", 0.05, 1.9, _SIZE)
    h: float = parameter("m", 0.0, 10.0)
    x_max: float = parameter("m", 1e-3, 1.9, _SIZE)
    y_max: float = parameter("m", 1e-3, 1.9, _SIZE)
    z_min: float = parameter("m", 0.05, 1.9, _SIZE)
    z_max: float = parameter("m", 0.05, 1.9, _SIZE)
    z_start: float = parameter("m", 0.05, 1.9, _SIZE)
    tilt_min: float = parameter("rad", -LARGEST_TILT, 0.0, _SINE)
    tilt_max: float = parameter("rad", 0.0, LARGEST_TILT, _SINE)
    rotation_min: float = parameter("rad", -1e6, 0.0, _TURNS)
    rotation_max: float = parameter("rad", 0.0, 1e6, _TURNS)
    v_max_tool: float = parameter("m/s", 1e-6, 1e12, _PLANNED)
    a_max_tool: float = parameter("m/s^2", 1e-6, 1e12, _PLANNED)
    j_max_tool: float = parameter("m/s^3", 1e-6, 1e12, _PLANNED)
    v_max_leg: float = parameter("m/s", 1e-6, 1e12, _PLANNED)
    a_max_leg: float = parameter("m/s^2", 1e-6, 1e12, _PLANNED)
    j_max_leg: float = parameter("m/s^3", 1e-6, 1e12, _PLANNED)
    v_max_table: float = parameter("rad/s", 1e-6, 1e12, _PLANNED)
    a_max_table: float = parameter("rad/s^2", 1e-6, 1e12, _PLANNED)
    j_max_table: float = parameter("rad/s^3", 1e-6, 1e12, _PLANNED)
    m_s: float = parameter("kg", 0.0, 1e4)
    m_p: float = parameter("kg", 1e-3, 1e4)
    J_a: float = parameter("kg m^2", 0.0, 1e4)
    l_c: float = parameter("m", 0.0, 2.0, _SIZE)
    mr_c: float = parameter("kg m", 0.0, 1e4)
    J_44: float = parameter("kg m^2", 1e-6, 1e4)
    J_55: float = parameter("kg m^2", 1e-6, 1e4)
    m_4: float = parameter("kg", 0.0, 1e4)
    r_4: float = parameter("m", 0.0, 10.0)
    g: float = parameter("m/s^2", 0.0, 100.0)
    T_s: float = parameter("s", 2e-5, 1e-3, "the programs and the period timer are made for it")
    f_legs: float = parameter("Hz", 0.1, 1e3)
    f_table: float = parameter("Hz", 0.1, 1e3)
    s_max_legs: float = parameter("m s", 0.0, 1.0)
    s_max_table: float = parameter("rad s", 0.0, 1.0)
    xi_c: float = parameter("1", 1.0, 8.0, "a boosted loop s^3 + 3ws^2 + 3w^2s + xi w^3 needs < 9")
    T_c: float = parameter("s", 4e-5, 100.0, "the boost is counted in control periods")
    e_c_legs: float = parameter("m", 0.0, 0.25, _SELECTS)
    e_c_table: float = parameter("rad", 0.0, 0.25, _SELECTS)
    F_max: float = parameter("N", 1e-3, 1e7)
    tau_max_4: float = parameter("N m", 1e-3, 1e7)
    tau_max_5: float = parameter("N m", 1e-3, 1e7)
    friction_legs: float = parameter("N", 0.0, 1e6)
    friction_table: float = parameter("N m", 0.0, 1e6)
    friction_speed_legs: float = parameter("m/s", 1e-6, 1e3)
    friction_speed_table: float = parameter("rad/s", 1e-6, 1e3)
    encoder_legs: float = parameter("m/count", 1e-9, 1e-4)
    turn_table: float = parameter("count", 100.0, 2.0**22, "at least four turns are counted")

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, kept, limit in self._relations():
            if not kept:
                raise ParameterError(f"{name} = {getattr(self, name)}: {limit}")

    def _relations(self) -> Iterator[tuple[str, bool, str]]:
        """Limits that depend on several parameters: name of one, whether met, the text."""
        yield "z_max", self.z_max > self.z_min, f"must be > z_min = {self.z_min} m"
        least = LEAST_HEIGHT * self.R
        yield (
            "z_min",
            self.z_min >= least,
            f"must be >= {LEAST_HEIGHT:g} R = {least:g} m; lower, the height is the root of a "
            "difference of nearly equal squares",
        )
        yield (
            "z_start",
            self.z_min <= self.z_start <= self.z_max,
            f"must be within the workspace, z_min = {self.z_min} .. z_max = {self.z_max} m",
        )
        counted = LARGEST_COUNT * self.encoder_table
        for name in ("tilt_min", "tilt_max", "rotation_min", "rotation_max"):
            yield (
                name,
                abs(getattr(self, name)) <= counted * (1 + 1e-9),
                f"must be within +-{counted:.6g} rad; binary32 holds 2^24 counts of "
                f"{self.turn_table:g} per turn",
            )
        corners = list(
            itertools.product(
                (-self.x_max, self.x_max), (-self.y_max, self.y_max), (self.z_min, self.z_max)
            )
        )
        longest = max(math.dist((*leg, 0.0), corner) for leg in self.legs for corner in corners)
        yield (
            "R",
            longest < LONGEST_LEG,
            f"the longest leg of the workspace has {longest:.4g} m, must be < {LONGEST_LEG:.4g} m "
            "with x_max, y_max, z_max; sums of squares are exact below 4 m^2 only",
        )
        counts = longest / self.encoder_legs
        yield (
            "encoder_legs",
            counts < LARGEST_COUNT,
            f"the longest leg has {counts:.4g} counts, must be < 2^24, the integers that binary32 "
            "holds",
        )
        ticks = self.T_c / self.T_s
        whole = abs(ticks - self.boost_ticks) <= 1e-9 * ticks
        yield (
            "T_c",
            whole and 2 <= self.boost_ticks <= LARGEST_BOOST,
            f"must be a whole number of periods T_s = {self.T_s} s, 2 .. {LARGEST_BOOST}",
        )
        for name in ("f_legs", "f_table"):
            most = 1.0 / (SAMPLES_PER_BANDWIDTH * self.T_s)
            yield (
                name,
                getattr(self, name) <= most * (1 + 1e-9),
                f"must be <= {most:g} Hz, {SAMPLES_PER_BANDWIDTH} periods T_s = {self.T_s} s per "
                "oscillation; faster loops of this law are not stable",
            )
        for name, mass, unit in (
            ("friction_legs", self.m_p, "m_p"),
            ("friction_table", min(self.J_44, self.J_55), "min(J_44, J_55)"),
        ):
            speed = name.replace("friction", "friction_speed")
            most = mass * getattr(self, speed) / self.T_s
            yield (
                name,
                getattr(self, name) <= most,
                f"must be <= {unit} {speed} / T_s = {most:.4g}; the plant's friction would be "
                "stiffer than a control period resolves",
            )
        hold = max(abs(force) for corner in corners for force in self._holding(corner))
        yield (
            "F_max",
            self.F_max > hold,
            f"must be > {hold:.4g} N, which holds the weight at a corner of the workspace",
        )
        tilt = self.r_4 * self.m_4 * self.g
        yield "tau_max_4", self.tau_max_4 > tilt, f"must be > r_4 m_4 g = {tilt:.4g} N m"

    def _holding(self, place: tuple[float, float, float]) -> tuple[float, ...]:
        """Static leg forces [N] at a tool position [m], (24), (25) in closed form."""
        x, y, z = place
        lengths = [math.dist((*leg, 0.0), place) for leg in self.legs]
        mass = self.m_p + sum((self.m_s * (l_i - self.l_c) - self.mr_c) / l_i for l_i in lengths)
        across = math.sqrt(3.0) * x
        shares = (1 + 2 * y / self.R, 1 + (across - y) / self.R, 1 - (across + y) / self.R)
        weight = mass * self.g / (3 * z)
        return tuple(l_i * weight * share for l_i, share in zip(lengths, shares, strict=True))

    def values(self) -> dict[str, float]:
        """Name -> value of every parameter, as `.param` of the programs (SI units)."""
        return asdict(self)

    @cached_property
    def legs(self) -> tuple[tuple[float, float], ...]:
        """Start points (x_pi, y_pi) of the legs in m, (4)-(6)."""
        half, across = 0.5 * self.R, 0.5 * math.sqrt(3.0) * self.R
        return ((0.0, self.R), (across, -half), (-across, -half))

    @property
    def start(self) -> tuple[float, float, float, float, float]:
        """The pose in which a program starts: x, y, z in m, angles of the table in rad."""
        return (0.0, 0.0, self.z_start, 0.0, 0.0)

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
