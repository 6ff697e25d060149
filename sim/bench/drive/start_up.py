# SPDX-License-Identifier: Apache-2.0
"""The start-up of the drives, and what a supervisor does with faults, through registers alone.

Order: `configure` with the machine at rest, all gates off and brakes closed; `measure_offsets`
without current; `align` against the closed brakes; `enable`, the current loops hold no force;
`release` once the tracking law runs. `stop` is the state in which every fault ends: all gates off,
all brakes closed, the link at rest; `recover` clears the faults, and a new start-up may begin.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sim.bench.drive.chain import INDEX, ChainRtl, current_program, write_constants
from sim.bench.drive.plant import AXES
from sim.bench.drive.status import told
from sim.laws.drive.clocks import CLOCK, HALF_PERIOD
from sim.laws.drive.current_law import MAGIC, SLOW_RATE, Setting
from sim.robot.drives import Drives, Inverter
from sim.robot.parameters import Robot
from sim.robot.records import Counts, Floats

WINDOW = 700  # the currents' windows begin in this clock of a half period
ALL = (1 << AXES) - 1
RUN = {f"axis{n}": 2 for n in range(AXES)}  # value of each field of MODE
DIRECTIONS = (0.0, np.pi, 0.5 * np.pi, 1.5 * np.pi)  # angles of the alignment's currents [rad]
FAST_FULL_SCALE = 8**3 // 2  # full scale of the fast currents: windows of 2^CONFIG.fast_log2 bits
FULL_SCALE = SLOW_RATE**3 // 2  # of the sensed currents
OVERCURRENT = 1.3  # trip level as a share of the greatest i_max
UNDERVOLTAGE, OVERVOLTAGE = 0.8, 1.15  # trip levels of the bus as shares of U_dc
CHOPPER_ON, CHOPPER_OFF = 1.1, 1.05  # the brake resistor's levels as shares of U_dc
MOST_OFFSET = 1 / 128  # largest offset of a current sensor as a share of current_scale
FOLLOWS = 1 / 64  # size of a current that is enough after a large voltage, share of current_scale
MOST_SUM = 3 / 128  # largest sum of three sensed currents as a share of current_scale
REACHED = 0.9  # of the largest voltage: a limit above it would never be reached
SPARE = 1.4  # of the time for which a current may be small
MOST_PERSIST = 255  # half periods, of PLAUSIBLE.persist
MOST_INDEX = 1 << 22  # counts, of INDEX_DISTANCE
INDEX_TOLERANCE = 2  # counts by which an index may be off
SETTLE = 1e-3  # time for the currents to settle after the gates are on [s]
LINK_BITS = 23  # of a position on the link
LEAST_MOVE = 4  # least move of an axis during alignment [counts]
MOST_OFF = 0.15  # largest residual of the sine fit as a share of the axis' move
FORCES = [f"force{n}" for n in range(AXES)]


class StartUpError(RuntimeError):
    """A step of the start-up did not do what it should; names the axis and what was found."""


def dead_clocks(drives: Inverter) -> int:
    """DEAD_TIME.clocks."""
    return round(drives.dead_time / CLOCK)


def least_clocks(drives: Inverter) -> int:
    """PWM.minimum: a state that is ordered lasts for the dead time and until its switch
    conducts."""
    return dead_clocks(drives) + round(drives.delay_on / CLOCK)


def trip_current(drives: Drives) -> float:
    """Size of a phase current that trips any axis [A]: there is one register for all."""
    return OVERCURRENT * max(motor.i_max for motor in drives.motors)


def trip_size(drives: Drives) -> int:
    """CURRENT_LIMIT.size."""
    return round(FAST_FULL_SCALE * trip_current(drives) / drives.current_scale)


def configure(system: ChainRtl, drives: Drives, setting: Setting, counts: Counts) -> None:
    """Program and registers; counts: the machine's position [counts].

    The bus voltage trips below `UNDERVOLTAGE` and above `OVERVOLTAGE`, a current at
    `trip_current`. Parameters must have passed `hardware.check`.
    """
    core = system.current
    core.load(current_program(drives, setting).image)
    system.front("PWM", half_period=setting.half, minimum=least_clocks(drives))
    system.front("DEAD_TIME", clocks=dead_clocks(drives))
    system.front("WINDOW", start=WINDOW)
    system.front("CURRENT_LIMIT", size=trip_size(drives))
    bus = drives.U_dc / setting.bus_scale
    system.front("GUARD", bus=round(UNDERVOLTAGE * bus), encoder=1)
    system.front("BUS_LIMIT", most=round(OVERVOLTAGE * bus))
    system.front("CHOPPER", on=round(CHOPPER_ON * bus), off=round(CHOPPER_OFF * bus))
    for n in range(AXES):
        system.front("ORIGIN", n, value=int(counts[n]) & 0xFFFFFFFF)
    recover(system)


def guard(
    system: ChainRtl,
    robot: Robot,
    drives: Drives,
    setting: Setting,
    index: Sequence[int] = (INDEX,) * AXES,
) -> None:
    """Guards of current sensors and encoders. Call it after `measure_offsets`, before the gates are
    on. index: counts of each axis from one index to the next, 0: no index.

    A phase with a large voltage must have a current (`plausible_limits`), and with a third sensor
    the sum of the currents must be below `MOST_SUM`. Raises StartUpError for an index that the
    hardware cannot check.
    """
    for n, counts in enumerate(index):
        if not 0 <= counts <= MOST_INDEX:
            raise StartUpError(
                f"axis {n + 1}: {counts} counts from index to index; expected 1 to {MOST_INDEX}, "
                "or 0 for an encoder without an index"
            )
    volts, persist = plausible_limits(robot, drives)
    system.front("PLAUSIBLE", current=round(FOLLOWS * FULL_SCALE), persist=persist)
    for n, limit in enumerate(volts):
        system.front("PLAUSIBLE_VOLTAGE", n, size=round(3 * setting.half * limit / drives.U_dc))
    for n, counts in enumerate(index):
        system.front("INDEX_DISTANCE", n, counts=counts, tolerance=INDEX_TOLERANCE)
    system.front("CURRENT_SUM", size=round(MOST_SUM * FULL_SCALE))


def plausible_limits(robot: Robot, drives: Drives) -> tuple[list[float], int]:
    """Voltages of a phase [V] from which on its current must follow, 0: never; half periods.

    Without current a phase has the voltage of its motion, at most that of the greatest speed. The
    limit is in the middle between that and what twice the greatest current takes at rest. While a
    current changes its sign it is small for 2 `FOLLOWS` L / (limit - motion) at most; the half
    periods are `SPARE` times as many. Axes whose voltages leave no such limit have none.
    """
    speeds = [robot.v_max_leg] * 3 + [robot.v_max_table] * 2
    small = 2 * FOLLOWS * drives.current_scale
    limits, periods = [], [1]
    for motor, speed in zip(drives.motors, speeds, strict=True):
        motion, most = speed * motor.wave * motor.psi, 2 * motor.R * motor.i_max
        limit = (motion + most) / 2
        late = math.inf
        if motion < most and limit < REACHED * drives.U_dc / math.sqrt(3):
            late = SPARE * small * motor.L_q / (limit - motion) / (HALF_PERIOD * CLOCK)
        fits = late <= MOST_PERSIST
        limits.append(limit if fits else 0.0)
        periods += [math.ceil(late)] if fits else []
    return limits, max(periods)


def recover(system: ChainRtl) -> None:
    """Clear what has tripped. Raises StartUpError if a cause is still there."""
    system.current.clear()
    system.front("CONTROL", clear=ALL, link=1)
    system.clock(4)  # a cause acts on the trip for two clocks more
    system.front("CONTROL", clear=ALL)
    system.clock(4)
    left = told(system.status())
    if left:
        raise StartUpError(f"a fault is still there, {left}")


def stop(system: ChainRtl) -> None:
    """All gates off, brakes closed, link at rest."""
    system.front("MODE")
    system.front("BRAKE")
    system.front("LINK")


def signed(system: ChainRtl, name: str, n: int) -> np.int32:
    """A register of an axis that holds a signed number."""
    return np.int32(np.uint32(system.read_front(name, n)))


def sense(system: ChainRtl, windows: int) -> NDArray[np.float64]:
    """Samples (windows, 5, 2) of the phase currents a and b [counts], a half period apart."""
    found = np.zeros((windows, AXES, 2))
    for row in found:
        system.clock(HALF_PERIOD)
        for n in range(AXES):
            for k, name in enumerate(("CURRENT_A", "CURRENT_B")):
                row[n, k] = signed(system, name, n)
    return found


def measure_offsets(system: ChainRtl, windows: int = 32) -> NDArray[np.float64]:
    """Mean samples (5, 2) of the currents with all gates off [counts], written to the program.

    Raises StartUpError for a sensor whose offset is above `MOST_OFFSET`.
    """
    zeros = sense(system, windows).mean(axis=0)
    for n, k in zip(*np.nonzero(np.abs(zeros) > MOST_OFFSET * FULL_SCALE), strict=True):
        raise StartUpError(
            f"axis {n + 1}, current {'ab'[k]} without gates: {zeros[n, k] / FULL_SCALE:.2%} of "
            f"the sensor's full scale, at most {MOST_OFFSET:.2%}; check the sensor, and that no "
            "current flows"
        )
    write_zeros(system, zeros)
    return zeros


def write_zeros(system: ChainRtl, zeros: NDArray[np.float64]) -> None:
    """Samples (5, 2) without current [counts], as `measure_offsets` finds them."""
    values = {f"zero_{k}{n}": MAGIC + zeros[n, i] for n in range(AXES) for i, k in enumerate("ab")}
    write_constants(system.current, system.current.image, values)


def order(system: ChainRtl, forces: Sequence[float]) -> None:
    """Orders of the host [N, N m], while LINK.orders is 0."""
    core = system.current
    for address, force in zip(core.input_addresses(FORCES), forces, strict=True):
        core.write(address, int(np.float32(force).view(np.uint32)))


def positions(system: ChainRtl) -> NDArray[np.int64]:
    """POSITION of the axes."""
    return np.array([signed(system, "POSITION", n) for n in range(AXES)], dtype=np.int64)


def align(
    system: ChainRtl,
    drives: Drives,
    setting: Setting,
    share: float = 0.9,
    dwell: float = 0.012,
) -> NDArray[np.float64]:
    """Electrical angles (5,) where the counters are 0 [rad], written to the program.

    A current vector bends the closed brake of its axis by its force, which goes with the cosine of
    the angle between vector and force. Sine and cosine of the angle are fitted to what the counts
    say, with an offset for what else bends the brake. The vectors' `DIRECTIONS`, in a
    square, leave out what the reluctance adds, and one after its opposite is late in its size, not
    in its angle. share: of i_max; dwell: for each [s], and without current at the end,
    until the joint is at rest. Raises StartUpError if an axis does not answer, or not as a motor
    does.
    """
    order(system, [0.0] * AXES)
    begin_at_rest(system)
    system.front("LINK", enable=1)
    system.clock(3 * HALF_PERIOD)  # the first run only sets sines and cosines
    system.front("MODE", **RUN)
    system.clock(round(SETTLE / CLOCK))
    rest = positions(system)
    moved = np.zeros((len(DIRECTIONS), AXES))
    forces = [share * m.i_max * m.force_per_ampere for m in drives.motors]
    at = [
        m.wave * q * int(n) for m, q, n in zip(drives.motors, setting.resolution, rest, strict=True)
    ]
    for row, direction in zip(moved, DIRECTIONS, strict=True):
        write_angles(system, [direction - angle for angle in at])
        order(system, forces)
        system.clock(round(dwell / CLOCK))
        row[:] = positions(system) - rest
    order(system, [0.0] * AXES)
    system.clock(round(max(4 * SETTLE, dwell) / CLOCK))
    status = system.status()
    if status["trip"]:
        raise StartUpError(f"while the axes were aligned, {told(status)}")
    angles, size, off = fitted_angles(DIRECTIONS, moved)
    for n in range(AXES):
        asked = f"axis {n + 1}, under {forces[n]:.0f} N or N m: moved by {size[n]:.1f} counts"
        if size[n] < LEAST_MOVE:
            raise StartUpError(f"{asked}; check motor, encoder and brake, or raise the share")
        if off[n] > MOST_OFF * size[n]:
            raise StartUpError(
                f"{asked}, {off[n]:.1f} off a sine; it was not at rest (dwell), or is blocked"
            )
    found = (angles - at + np.pi) % (2 * np.pi) - np.pi
    write_angles(system, found)
    return found


def fitted_angles(
    directions: Sequence[float], moved: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Of moves (n, axes): electrical angle [rad], amplitude, largest distance from the fit."""
    basis = np.stack([np.cos(directions), np.sin(directions), np.ones(len(directions))], axis=1)
    fit, *_ = np.linalg.lstsq(basis, moved, rcond=None)
    off = np.abs(moved - basis @ fit).max(axis=0)
    return np.arctan2(fit[1], fit[0]), np.hypot(fit[0], fit[1]), off


def write_angles(system: ChainRtl, angles: Floats) -> None:
    """Electrical angles where the counters are 0, known from a table instead of `align`."""
    values = {f"angle{n}": float(angle) for n, angle in enumerate(angles)}
    write_constants(system.current, system.current.image, values)


def begin_at_rest(system: ChainRtl) -> None:
    """Gates off, link at rest, and the states of the current loops' program as for its first run at
    the present counts: a loop takes the difference to the counts before as a speed."""
    system.front("MODE")
    system.front("LINK")
    system.clock(HALF_PERIOD)
    first = {state.name: int(state.bits, 16) for state in system.current.image.states}
    for n, count in enumerate(linked(positions(system))):
        first[f"before{n}"] = int(np.float32(count).view(np.uint32))
    system.current.preset(first)


def linked(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Counts as the link's words have them: the low `LINK_BITS` bits, signed."""
    half = 1 << (LINK_BITS - 1)
    return (counts + half) % (2 * half) - half


def enable(system: ChainRtl) -> None:
    """Currents follow the tracking processor's commands, 0 until its first run; brakes closed."""
    begin_at_rest(system)
    system.front("LINK", enable=1, orders=1)
    system.clock(3 * HALF_PERIOD)  # the first run only sets sines and cosines
    system.front("MODE", **RUN)


def release(system: ChainRtl) -> None:
    """Open the brakes. Raises StartUpError for an axis that has tripped."""
    status = system.status()
    if status["trip"]:
        raise StartUpError(f"before the brakes opened, {told(status)}")
    system.front("BRAKE", release=ALL)


def supervise(
    system: ChainRtl, desired: Sequence[float], resolution: Sequence[float], most: Sequence[float]
) -> str:
    """What a supervisor does now and then: '' while all is well, else what is wrong, and `stop`.

    desired: joints of the tracking law [m, rad]; most: following error of each axis that is too
    much. An axis that has tripped stops the others too.
    """
    wrong = told(system.status())
    if wrong:
        stop(system)
        return wrong
    origin = [signed(system, "ORIGIN", n) for n in range(AXES)]
    for n, count in enumerate(positions(system) + origin):
        error = desired[n] - count * resolution[n]
        if abs(error) > most[n]:
            stop(system)
            return f"following error of axis {n + 1}: {error:.3g}"
    return ""
