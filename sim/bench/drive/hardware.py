# SPDX-License-Identifier: Apache-2.0
"""What the hardware of the drives is built for, and the parameters that it cannot follow.

`sim/robot.toml` states dead time, currents and frequencies; registers and build parameters of
`rtl/drive` hold some of them, others only at one value. `load` refuses what would have no effect,
or another one on the RTL than in the laws.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from sim.bench.drive.chain import CONTROL_PERIOD
from sim.bench.drive.start_up import (
    FAST_FULL_SCALE,
    OVERCURRENT,
    dead_clocks,
    least_clocks,
    trip_current,
    trip_size,
)
from sim.laws.drive.clocks import CLOCK, HALF_PERIOD
from sim.laws.drive.current_law import FASTEST
from sim.robot.drives import Drives
from sim.robot.parameter_record import placed
from sim.robot.parameters import ParameterError, Robot
from sim.rtl.gen.drive_regmap import REGMAP

BIT_CLOCKS = 6  # of a modulator's bit; CONFIG.bit_clocks
LEAST_DEAD_TIME = 12  # clocks; CONFIG.least_dead_time
SAME = 1e-6  # relative: a frequency or period written with fewer digits


def load(path: Path) -> tuple[Robot, Drives]:
    """Both records of a parameter file, checked. Raises ParameterError, with file and line, and
    OSError."""
    robot, drives = Robot.load(path), Drives.load(path)
    try:
        check(robot, drives)
    except ParameterError as error:
        raise placed(error, path) from None
    return robot, drives


def check(robot: Robot, drives: Drives) -> None:
    """Raises ParameterError for a value that the hardware does not follow: name, value, what the
    hardware has, cure."""
    for record in (robot, drives):
        for name, unit, kept, text in _limits(robot, drives):
            if hasattr(record, name) and not kept:
                raise ParameterError(f"{name} = {getattr(record, name):.10g} {unit}: {text}")


def _limits(robot: Robot, drives: Drives) -> Iterator[tuple[str, str, bool, str]]:
    """Name, unit, whether met, what the hardware has and the cure."""
    fixed = (
        ("T_s", robot.T_s, "s", "a control period", CONTROL_PERIOD),
        ("f_pwm", drives.f_pwm, "Hz", "a period of the carrier", 2 * HALF_PERIOD),
        ("f_modulator", drives.f_modulator, "Hz", "a bit of the modulators", BIT_CLOCKS),
    )
    for name, value, unit, what, clocks in fixed:
        built = clocks * CLOCK if unit == "s" else 1 / (clocks * CLOCK)
        text = (
            f"{what} of the drives is {clocks} clocks of {1e9 * CLOCK:g} ns, whatever the file "
            f"says; enter {built:.10g} {unit}"
        )
        yield name, unit, math.isclose(value, built, rel_tol=SAME), text
    yield from _speeds(robot, drives)
    yield from _dead_time(drives)
    yield from _currents(drives)


def _speeds(robot: Robot, drives: Drives) -> Iterator[tuple[str, str, bool, str]]:
    legs, tilt, rotation = drives.motors[2:]
    table = max((tilt, "poles_tilt"), (rotation, "poles_rotation"), key=lambda axis: axis[0].wave)
    axes = (
        ("v_max_leg", robot.v_max_leg, "m/s", legs, "a longer pole_legs"),
        ("v_max_table", robot.v_max_table, "rad/s", table[0], f"a smaller {table[1]}"),
    )
    for name, value, unit, motor, cure in axes:
        yield (
            *(name, unit, value * motor.wave <= FASTEST * (1 + SAME)),
            f"the fastest motor turns with {value * motor.wave:.4g} rad/s electrical; the current "
            f"loops are proved and scaled to {FASTEST:g} rad/s; must be <= "
            f"{_below(FASTEST / motor.wave)} {unit}, or {cure}",
        )


def _dead_time(drives: Drives) -> Iterator[tuple[str, str, bool, str]]:
    dead = dead_clocks(drives)
    most = (1 << REGMAP.registers["DEAD_TIME"].fields["clocks"].width) - 1
    yield (
        *("dead_time", "s", LEAST_DEAD_TIME <= dead <= most),
        f"the inverter's hardware holds {LEAST_DEAD_TIME} .. {most} clocks of {1e9 * CLOCK:g} ns; "
        f"must be within {LEAST_DEAD_TIME * CLOCK:.4g} .. {most * CLOCK:.4g} s",
    )
    late = drives.delay_off - drives.delay_on
    yield (
        *("dead_time", "s", late <= dead * CLOCK),
        f"a switch stops {late:.4g} s later than its opposite's gate lets that conduct (delay_off "
        "- delay_on): both of a phase would short the bus; must be that long at least, in whole "
        f"clocks of {1e9 * CLOCK:g} ns",
    )
    rest = (HALF_PERIOD // 2 - dead) * CLOCK
    yield (
        *("delay_on", "s", least_clocks(drives) <= HALF_PERIOD // 2),
        "with dead_time more than half of a half period of the carrier, so that a phase could only "
        f"be on or off; must be <= {rest:.4g} s, or a shorter dead_time",
    )


def _currents(drives: Drives) -> Iterator[tuple[str, str, bool, str]]:
    greatest = max(("legs", "tilt", "rotation"), key=lambda axis: getattr(drives, f"i_max_{axis}"))
    trip, scale = trip_current(drives), drives.current_scale
    yield (
        *(f"i_max_{greatest}", "A", trip <= scale * (1 + SAME)),
        f"axes trip at {OVERCURRENT:g} of the greatest i_max, {trip:.4g} A; the sensing ends at "
        f"current_scale = {scale:g} A and would not show that; must be <= "
        f"{_below(scale / OVERCURRENT)} A, or sense with current_scale >= {_above(trip)} A",
    )
    yield (
        *("current_scale", "A", trip_size(drives) > 0),
        f"axes trip at {OVERCURRENT:g} of the greatest i_max, {trip:.4g} A: less than half a step "
        f"of the overcurrent comparator, which then is off; must be < "
        f"{_below(2 * FAST_FULL_SCALE * trip)} A",
    )


def _below(value: float) -> str:
    """Four digits of a positive number that is not above it."""
    step = 10.0 ** (math.floor(math.log10(value)) - 3)
    return f"{math.floor(value / step * (1 + SAME)) * step:.4g}"


def _above(value: float) -> str:
    step = 10.0 ** (math.floor(math.log10(value)) - 3)
    return f"{math.ceil(value / step * (1 - SAME)) * step:.4g}"
