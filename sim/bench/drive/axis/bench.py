# SPDX-License-Identifier: Apache-2.0
"""The bench of one motor: programs on its samples, and a record of what the hardware sees.

Estimators take `Record`s alone: counts, sensed currents, commanded voltages. `truth` is for tests
and for the comparison that the command prints.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asip_asm.model.compiler import Compiled, compile_law
from sim.bench.drive.averaged import END, MIDDLE
from sim.bench.drive.axis.motor_file import GAIN_ERROR, HALL, LINEAR, OFFSET, SINCOS, OneMotor
from sim.bench.drive.axis.programs import Program, bench_library, program
from sim.bench.drive.chain import OPTIONS
from sim.bench.drive.plant import FRICTION, INVERTER, MOTOR, PARAMETERS
from sim.bench.drive.start_up import OVERCURRENT, WINDOW, least_clocks
from sim.laws.drive.clocks import CLOCK, LOOP_PERIOD
from sim.laws.drive.current_law import MAGIC, current_law
from sim.laws.drive.start_up_law import ORDERS, start_up_law
from sim.robot.drives import Motor
from sim.rtl.verilated import Signatures, Verilated

WORDS = 5  # of the link in front of the orders
COLUMNS = 7
POINTER, U32 = ctypes.c_void_p, ctypes.c_uint32
SIGNATURES: Signatures = {
    "new": (None, POINTER, POINTER),
    "load": (None, POINTER, POINTER, U32, U32),
    "outer": (None, POINTER, POINTER, U32, U32, U32),
    "gates": (None, ctypes.c_int),
    "halves": (ctypes.c_int, POINTER, U32, POINTER, U32),
    "truth": (None, POINTER),
    "off": (None, POINTER),
    "lose": (None, U32),
    "bad": (U32,),
    "lines": (U32, POINTER, U32),
}
LINK_HALVES = 3  # the first run of a program only sets its states
VOLTAGE_LATE = 1.5 * LOOP_PERIOD - MIDDLE * CLOCK  # s from a current to the middle of its voltage
COUNT_LATE = (END - MIDDLE) * CLOCK  # s from a current to the counts of the same sample
MILLISECOND = round(1e-3 / LOOP_PERIOD)  # half periods


class BringUpError(RuntimeError):
    """A step of the bring-up did not find what it needs: what was seen, the cause, the cure."""


@dataclass(frozen=True)
class Record:
    """A row each half period (n,): counts since the start, currents of the stator [A], voltages of
    the stator that the run commanded [V], the order of the loop."""

    counts: NDArray[np.float64]
    alpha: NDArray[np.float64]
    beta: NDArray[np.float64]
    u_alpha: NDArray[np.float64]
    u_beta: NDArray[np.float64]
    order: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.counts)

    def __add__(self, other: Record) -> Record:
        both = zip(vars(self).values(), vars(other).values(), strict=True)
        return Record(*(np.concatenate(pair) for pair in both))

    def part(self, begin: int, end: int | None = None) -> Record:
        """Rows of it."""
        return Record(*(rows[begin:end] for rows in vars(self).values()))

    @property
    def current(self) -> NDArray[np.float64]:
        """Size of the current's vector [A]."""
        return np.hypot(self.alpha, self.beta)


class Bench(Verilated):
    """A motor at rest with its inverter; angle: electrical, at position 0 [rad]; at: where it
    rests [rad or m]; wired: what the plant is if the file is wrong (for tests); hall: which sensor
    is at each Hall line, 3 more if it is inverted; 6 for a line that is low, 7 for a high one."""

    prefix = "bench"

    def __init__(
        self,
        one: OneMotor,
        angle: float = 0.7,
        at: float = 0.0,
        wired: OneMotor | None = None,
        hall: tuple[int, int, int] = (0, 1, 2),
    ) -> None:
        self.one, plant = one, wired or one
        record = _record(plant, angle)
        serial = (one.counter.get("Period", 0), one.frame_clocks)
        rest = np.array(
            [
                *(plant.inertia, 0.0, at, WINDOW, END, least_clocks(one), *serial),
                *(one.port["Bits"] if one.encoder == SINCOS else 0, *one.sine_errors),
                *(1 << one.port["Bits"] if one.encoder == HALL else 0, one.port.get("Filter", 0)),
                *(one.port.get("Limit", 0), plant.hall_error, *hall),
            ],
            dtype=float,
        )
        library = ctypes.CDLL(str(bench_library()))
        super().__init__(library, SIGNATURES, record.ctypes.data, rest.ctypes.data)
        self.scale = one.current_scale * one.setting().ampere_per_count
        self.zeros = np.zeros(2)  # samples without current [counts]
        self.uneven = np.zeros(6)  # by which each edge of Hall lines is late [counts]
        self.halves_run = 0
        self.counts = 0.0  # of the last sample
        self._kept: list[Program] = []
        self._width = 1

    @property
    def truth(self) -> dict[str, float]:
        """Position, speed, i_d, i_q, electrical angle at count 0: no estimator takes it."""
        out = np.zeros(5)
        self._call("truth", out.ctypes.data)
        return dict(zip(("x", "v", "i_d", "i_q", "angle"), out.tolist(), strict=True))

    def off(self) -> tuple[float, float]:
        """Distance of the sampled counts from the position since the last call: rms and largest,
        electrical [degrees]. No estimator takes it."""
        out = np.zeros(2)
        self._call("off", out.ctypes.data)
        rms, largest = np.degrees(out * self.one.resolution * self.one.motor.wave).tolist()
        return rms, largest

    def lose(self, frames: int) -> None:
        """So many next frames or samples of an encoder without lines A and B are bad."""
        self._call("lose", frames)

    def bad(self) -> int:
        """Illegal states and skipped sectors of Hall lines since the last call, as `ILLEGAL`."""
        return int(self._call("bad"))

    def lines(self) -> NDArray[np.int64]:
        """Clock and state, 4 u + 2 v + w, of each change of the Hall lines. No estimator takes
        it."""
        out = np.zeros((100_000, 2))
        n = self._call("lines", out.ctypes.data, len(out))
        return out[:n].astype(np.int64)

    def absolute(self) -> int:
        """The position that a host reads over the serial line with the motor at rest: single-turn
        of a rotary encoder."""
        position = math.floor(self.truth["x"] / self.one.absolute + 0.5)
        if self.one.kind == LINEAR:
            return position
        return position % round(2 * math.pi / self.one.absolute)

    def start_up(self) -> None:
        """Load the program of the start-up; rows are `ORDERS`."""
        self.load(compile_law(start_up_law(self.one, self.one.setting()), OPTIONS))

    def current_loop(self, motor: Motor, angle: float, crossover: float) -> Compiled:
        """Load the current loop with gains for these values of the motor; rows are the force."""
        compiled = current_program(self.one, motor, crossover)
        values = {"angle0": (angle + np.pi) % (2 * np.pi) - np.pi}
        values |= {f"zero_{k}0": MAGIC + zero for k, zero in zip("ab", self.zeros, strict=True)}
        # A jump of the counts would be a speed, and its filter takes a millisecond to forget it.
        self.load(compiled, values, {"before0": self.counts})
        return compiled

    def load(
        self,
        compiled: Compiled,
        values: Mapping[str, float] | None = None,
        states: Mapping[str, float] | None = None,
    ) -> None:
        """A program with these parameters and states, gates off for its first runs."""
        made = program(compiled, WORDS, values)
        self._kept.append(made)
        first = made.states(states or {})
        self._call("load", made.tick, first.ctypes.data, len(first), made.orders)
        self._width = made.orders
        self.gates(False)
        self.run(np.zeros((LINK_HALVES, self._width)))
        self.gates(True)

    def outer(self, compiled: Compiled, every: int) -> None:
        """A program that orders for the loaded one, every so many half periods; a row has its
        orders and one that is added to what it orders."""
        made = program(compiled, 1)
        self._kept.append(made)
        self._call(
            *("outer", made.tick, made.first.ctypes.data, len(made.first), made.orders, every)
        )
        self._width = made.orders + 1

    def gates(self, on: bool) -> None:
        """All gates off, or as the PWM orders."""
        self._call("gates", on)

    def run(self, rows: ArrayLike) -> Record:
        """A half period for each row of orders. Raises BringUpError where the hardware trips."""
        words = np.ascontiguousarray(rows, dtype=np.float32).reshape(-1, self._width)
        out = np.zeros((len(words), COLUMNS), dtype=np.float32)
        faulted = self._call(
            *("halves", words.ctypes.data, self._width, out.ctypes.data, len(words))
        )
        self.halves_run += len(words)
        if faulted:
            raise BringUpError("the program of the loop stopped with a fault; report this motor")
        found = out.astype(float)
        self.counts = float(found[-1, 0]) if len(found) else self.counts
        a, b = ((found[:, 1 + k] - self.zeros[k]) * self.scale for k in range(2))
        beta = (a + 2 * b) / np.sqrt(3)
        most, limit = float(np.hypot(a, beta).max(initial=0.0)), OVERCURRENT * self.one.motor.i_max
        if most > limit:
            raise BringUpError(
                f"the current reached {most:.3g} A, the axis trips at {limit:.3g} A; check "
                "rated_current, a short in the windings, or a smaller current_bandwidth"
            )
        volts = found[:, 3:6] * (self.one.U_dc / self.one.setting().half)
        return Record(
            found[:, 0],
            a,
            beta,
            (2 * volts[:, 0] - volts[:, 1] - volts[:, 2]) / 3,
            (volts[:, 1] - volts[:, 2]) / np.sqrt(3),
            found[:, 6],
        )

    def orders(self, n: int, **columns: ArrayLike) -> NDArray[np.float64]:
        """Rows of the start-up's program: the offsets, and these columns of `ORDERS`."""
        rows = np.zeros((n, len(ORDERS)))
        rows[:, -2:] = self.zeros
        for name, values in columns.items():
            rows[:, ORDERS.index(name)] = values
        return rows

    def measure_offsets(self, halves: int = 64) -> None:
        """Mean of the samples without gates."""
        self.gates(False)
        self.zeros = np.zeros(2)
        found = self.run(self.orders(halves))
        a, b = found.alpha, (np.sqrt(3) * found.beta - found.alpha) / 2
        self.zeros = np.array([a[2:].mean(), b[2:].mean()]) / self.scale
        self.gates(True)


def current_program(one: OneMotor, motor: Motor, crossover: float) -> Compiled:
    """The existing current law for one axis, its gains from these values of the motor."""
    return compile_law(
        current_law(Believed(one, motor), one.setting(0.0, crossover), (0,)), OPTIONS
    )


class Believed:
    """The inverter of a file with another motor: what an identification has found."""

    def __init__(self, one: OneMotor, motor: Motor) -> None:
        self.motors = (motor,)
        for name in (
            "current_scale",
            "U_dc",
            "dead_time",
            "delay_on",
            "delay_off",
            "drop",
            "f_pwm",
        ):
            setattr(self, name, getattr(one, name))

    current_scale: float
    U_dc: float
    dead_time: float
    delay_on: float
    delay_off: float
    drop: float
    f_pwm: float


def _record(one: OneMotor, angle: float) -> NDArray[np.void]:
    """The plant's parameters, `struct Parameters` of plant.h, with one axis."""
    found = np.zeros((), dtype=PARAMETERS)
    for name in INVERTER:
        found[name] = getattr(one, name)
    axis = found["axis"][0]
    for name in MOTOR:
        axis[f"motor_{name}"] = getattr(one.motor, name)
    for name in FRICTION:
        axis[name] = getattr(one.friction, name)
    axis["resolution"], axis["angle_offset"] = one.resolution, angle
    axis["gain_a"], axis["gain_b"] = GAIN_ERROR, -GAIN_ERROR
    axis["offset_a"] = OFFSET * one.current_scale
    axis["offset_b"] = -OFFSET * one.current_scale
    return found
