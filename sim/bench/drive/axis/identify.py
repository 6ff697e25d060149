# SPDX-License-Identifier: Apache-2.0
"""R, L_d, L_q, flux, inertia and friction of a motor from records of its start-up.

Only `Record`s are used: counts, sensed currents, commanded voltages. What is taken from the file
are the rated current, the bus voltage, poles, counts and travel, which say how far the start-up may
go, and the slope of the inverter's forward drop, which is in series with R.

Electrical: at rest on d, R is the slope of voltage by current at four levels, which has no dead
time in it; L_d and L_q follow from lines of a multisine, R + j w L, with the swing of the rotor as
a spring in q. In motion, u_q - L_q di_q/dt - w L_d i_d = R' i_q + w psi over swings to both sides;
R' takes what is left of the dead time. Mechanical: J x'' = k i_q - F_c sign(x') - B x' - F_0,
multiplied by bumps that end smoothly and integrated by parts, so that counts are never
differentiated [M. Shinbrot, On the analysis of linear and nonlinear systems, Trans. ASME 79, 1957].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.bench.drive.axis import hall
from sim.bench.drive.axis.alignment import (
    SafeLoop,
    at_absolute_zero,
    by_the_encoder,
    settle,
    with_motion,
    without_motion,
)
from sim.bench.drive.axis.bench import (
    COUNT_LATE,
    MILLISECOND,
    VOLTAGE_LATE,
    Bench,
    BringUpError,
    Record,
)
from sim.bench.drive.axis.motor_file import ABSOLUTE, HALL, LINEAR, OPTIMUM
from sim.laws.drive.clocks import LOOP_PERIOD
from sim.laws.drive.start_up_law import MOST
from sim.robot.drives import Motor

LEVELS = (0.35, 0.5, 0.65, 0.8)  # of the rated current, for R
BASE = 200.0  # Hz, spacing of the multisine's lines for L
LINES_D, LINES_Q = np.arange(4, 21, 2), np.arange(5, 22, 2)  # multiples of BASE
RIPPLE = 0.02  # of the rated current, each line
PERIODS = 20
SLOW_LOOP = 1500.0  # crossover [rad/s] that leaves the lines alone
SWING, HALL_SWING = 0.6, 0.3  # of the rated current; an acceleration is an error of Hall lines
MOST_SPEED = 600.0  # electrical, at the end of a swing [rad/s]
MOST_VOLTAGE = 0.6  # of the voltage circle
LONGEST_SWING, LEAST_TIME, HALL_TIME = 0.5, 0.16, 0.5  # s of a swing; of all swings
LEAST_SWINGS, MOST_SWINGS = 4, 14
INNER = 0.35  # of the travel, to each side
POLL = 20  # half periods between two looks at the counts
SMOOTH = 61  # rows of the polynomial through the counts
STEADY = 0.93  # of the current of a swing: less is a reversal
UNKNOWN_FLUX = 1e-3  # V s: of a program that orders amperes


@dataclass(frozen=True)
class Found:
    """SI units; angles: electrical at count 0 [rad], `still` without motion, whose way is `moved`
    [rad], none with Hall lines; swings: the recorded start-up; offset: electrical angle at position
    0 of an absolute encoder or of Hall lines."""

    R: float
    L_d: float
    L_q: float
    psi: float
    inertia: float
    coulomb: float
    viscous: float
    angle: float
    still: float | None
    moved: float
    swings: Record
    offset: float | None

    def motor(self, file: Motor) -> Motor:
        """With what the file alone knows: poles and rated current."""
        return Motor(file.pole, self.R, self.L_d, self.L_q, self.psi, file.i_max, 0.0)


def identify(bench: Bench) -> Found:
    """The whole start-up of a motor at rest. Raises BringUpError."""
    bench.start_up()
    bench.measure_offsets()
    loop = SafeLoop(rough_inductance(bench))
    still = None if bench.one.encoder == HALL else without_motion(bench, loop)
    if still is None and bench.one.encoder_offset is None:
        angle, bench.uneven, held = hall.align(bench, loop)
    elif still is None:
        angle, held = hall.by_offset(bench, loop)
    elif bench.one.encoder_offset is not None:
        angle = by_the_encoder(bench, still.angle)
        held = settle(bench, loop, angle)
    else:
        held = settle(bench, loop, still.angle)
        angle = with_motion(bench, loop, held)
    offset = at_absolute_zero(bench, angle) if bench.one.encoder in ABSOLUTE else None
    offset = angle if still is None else offset
    resistance = measure_resistance(bench, loop, held)
    l_d, l_q = measure_inductances(bench, loop, held)
    swings = swing(bench, Motor(bench.one.motor.pole, resistance, l_d, l_q, UNKNOWN_FLUX,
                                bench.one.motor.i_max, 0.0), angle)  # fmt: skip
    psi = flux(bench, swings, angle, resistance, l_d, l_q)
    inertia, coulomb, viscous = mechanics(bench, swings, angle, psi)
    return Found(
        *(resistance, l_d, l_q, psi, inertia, coulomb, viscous, angle),
        *(still.angle if still else None, still.moved if still else 0.0, swings, offset),
    )


def rough_inductance(bench: Bench) -> float:
    """Of the axis alpha, by pulses that grow until a current flows [H]; within a third."""
    one = bench.one
    most, wanted = 0.9 * MOST * one.U_dc, 0.3 * one.motor.i_max
    volts, rows = 0.01 * one.U_dc, 4
    before: tuple[float, float] | None = None
    while True:
        pulse = np.concatenate(
            [np.full(rows, volts), np.full(rows, -volts), np.zeros(4 * rows + 20)]
        )
        seen = bench.run(bench.orders(len(pulse), u_alpha=pulse)).alpha
        peak = float(seen.max())
        if peak > wanted and before is not None:
            slope = (peak - before[1]) / (volts - before[0])
            if slope > 0:
                return rows * LOOP_PERIOD / slope
        before = volts, peak
        volts *= 1.25
        if volts > most:
            volts, rows, before = 0.1 * one.U_dc, 2 * rows, None
        if rows > 4096:
            raise BringUpError(
                f"{most:.3g} V for {rows * LOOP_PERIOD:.2g} s made a current of {peak:.3g} A, "
                f"{wanted:.3g} A are needed; check that the motor's phases are connected"
            )


def _hold(bench: Bench, loop: SafeLoop, held: float, sizes: NDArray[np.float64], **more) -> Record:
    orders = {"i_alpha": sizes * np.cos(held), "i_beta": sizes * np.sin(held)}
    return bench.run(bench.orders(len(sizes), **orders, **loop.gains, **more))


def rotor_frame(
    alpha: NDArray[np.float64], beta: NDArray[np.float64], angle: NDArray[np.float64] | float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(d, q) of a vector in the stator's frame."""
    c, s = np.cos(angle), np.sin(angle)
    return alpha * c + beta * s, beta * c - alpha * s


def measure_resistance(bench: Bench, loop: SafeLoop, held: float) -> float:
    """Slope of voltage by current on d [ohm], without that of the inverter's forward drop."""
    rated, volts, amperes = bench.one.motor.i_max, [], []
    for level in LEVELS:
        ramp = np.full(40 * MILLISECOND, level * rated)
        _hold(bench, loop, held, ramp)
        seen = _hold(bench, loop, held, ramp)
        volts.append(rotor_frame(seen.u_alpha, seen.u_beta, held)[0].mean())
        amperes.append(rotor_frame(seen.alpha, seen.beta, held)[0].mean())
    return float(np.polyfit(amperes, volts, 1)[0] - bench.one.drop_resistance)


def measure_inductances(bench: Bench, loop: SafeLoop, held: float) -> tuple[float, float]:
    """L_d, L_q [H] from lines of a multisine in both at once, the rotor held by current in d."""
    one, samples = bench.one, round(1 / (BASE * LOOP_PERIOD))
    slow = SafeLoop(loop.inductance, SLOW_LOOP)
    t = np.arange(samples) / samples
    waves = []
    for lines in (LINES_D, LINES_Q):
        size = 2 * np.pi * BASE * lines * loop.inductance * RIPPLE * one.motor.i_max
        phases = -np.pi * np.arange(len(lines)) ** 2 / len(lines)
        waves.append((size * np.cos(2 * np.pi * np.outer(t, lines) + phases)).sum(axis=1))
    largest = max(np.abs(wave).max() for wave in waves)
    scale = min(1.0, 0.2 * one.U_dc / largest)
    u_d, u_q = (np.tile(scale * wave, PERIODS + 2) for wave in waves)
    c, s = np.cos(held), np.sin(held)
    volts = {"u_alpha": u_d * c - u_q * s, "u_beta": u_d * s + u_q * c}
    level = np.full(len(u_d), 0.6 * one.motor.i_max)
    _hold(bench, slow, held, level)
    seen = _hold(bench, slow, held, level, **volts).part(2 * samples)
    u = rotor_frame(seen.u_alpha, seen.u_beta, held)
    i = rotor_frame(seen.alpha, seen.beta, held)
    found = []
    for axis, lines in enumerate((LINES_D, LINES_Q)):
        w = 2 * np.pi * BASE * lines
        late = np.exp(-1j * w * VOLTAGE_LATE) * np.sinc(w * LOOP_PERIOD / (2 * np.pi))
        volt, ampere = (np.fft.fft(rows[axis])[lines * PERIODS] for rows in (u, i))
        impedance = volt * late / ampere
        # R + j w L, and the rotor's swing: 1 / (j w C), which falls with frequency.
        rows = np.stack([w, -1 / w], axis=1) if axis else w[:, None]
        fit, *_ = np.linalg.lstsq(rows / w[:, None], impedance.imag / w, rcond=None)
        found.append(float(fit[0]))
    return found[0], found[1]


def swing(bench: Bench, motor: Motor, angle: float) -> Record:
    """Recorded start-up: a current in q to one side and the other, as fast and far as is allowed.

    Raises BringUpError if nothing moves.
    """
    one = bench.one
    bench.current_loop(motor, angle, 0.4 * OPTIMUM)
    per_count, circle = motor.wave * one.resolution, one.U_dc / np.sqrt(3)
    lines = one.encoder == HALL
    share = HALL_SWING if lines else SWING
    order = share * motor.i_max * motor.force_per_ampere
    room = INNER * one.travel / one.resolution  # counts
    found = bench.run(np.zeros((MILLISECOND, 1)))
    middle = found.counts[0] if one.kind == LINEAR else 0.0
    sign, chunks, slope = 1.0, [found], 0.0
    swings, begun, total = 0, 0, 0
    recent = [found.counts[-1]] * 6
    while True:
        part = bench.run(np.full((POLL, 1), sign * order))
        chunks.append(part)
        total += POLL
        recent = [*recent[1:], part.counts[-1]]
        speed = (recent[-1] - recent[0]) / (5 * POLL * LOOP_PERIOD)  # counts/s
        if lines:
            speed = hall.speed(np.concatenate([chunk.counts for chunk in chunks]))
        volts = float(np.hypot(part.u_alpha, part.u_beta).mean())
        if swings == 0 and total > 5 * POLL:
            slope = max(slope, abs(speed) / (total * LOOP_PERIOD))
        stop = part.counts[-1] - middle + speed * abs(speed) / (2 * slope) if slope else 0.0
        fast = sign * speed * per_count > MOST_SPEED or (
            volts > MOST_VOLTAGE * circle and total - begun > 5 * POLL and sign * speed > 0
        )
        far = sign * stop > room and sign * speed > 0
        long = (total - begun) * LOOP_PERIOD > LONGEST_SWING
        if fast or far or long:
            swings, begun, sign = swings + 1, total, -sign
            least = HALL_TIME if lines else LEAST_TIME
            enough = swings >= LEAST_SWINGS and total * LOOP_PERIOD > least
            if enough and swings % 2 == 0 or swings >= MOST_SWINGS:
                break
    # Back to rest: a current against the motion until it ends.
    for _ in range(round(LONGEST_SWING / LOOP_PERIOD / POLL)):
        part = bench.run(np.full((POLL, 1), sign * order))
        chunks.append(part)
        recent = [*recent[1:], part.counts[-1]]
        begun -= POLL
        if lines and abs(speed) < slope * (total - begun) * LOOP_PERIOD:
            break
        if not lines and sign * (recent[-1] - recent[0]) >= 0:
            break
    chunks.append(bench.run(np.zeros((5 * MILLISECOND, 1))))
    whole = chunks[0]
    joined = {name: np.concatenate([getattr(c, name) for c in chunks]) for name in vars(whole)}
    record = Record(**joined)
    if np.ptp(record.counts) * per_count < 0.5:
        raise BringUpError(
            f"a current of {share * motor.i_max:.3g} A moved the motor by "
            f"{np.ptp(record.counts):.0f} counts; check that it is free, and rated_current"
        )
    if lines:
        if bad := bench.bad():
            raise BringUpError(
                f"the Hall lines had {bad} wrong changes in the start-up; check the lines, or "
                "remove encoder_offset to let the start-up name the line"
            )
        rows, _ = hall.edges(record.counts)
        record = record.part(rows[0], rows[-1])
    return record


def travel(bench: Bench, record: Record, angle: float) -> tuple[NDArray, NDArray, NDArray]:
    """Smoothed counts at the instants of the currents; electrical angle there [rad] and speed
    [rad/s]. With Hall lines, from the edges."""
    from scipy.signal import savgol_filter  # here: more than a second of every command

    per_count = bench.one.motor.wave * bench.one.resolution
    if bench.one.encoder == HALL:
        smooth, rate = hall.between(record.counts, bench.uneven)
    else:
        smooth = savgol_filter(record.counts, SMOOTH, 2)
        rate = savgol_filter(record.counts, SMOOTH, 2, deriv=1, delta=LOOP_PERIOD)
    counts = smooth - rate * COUNT_LATE
    return counts, per_count * counts + angle, per_count * rate


def flux(
    bench: Bench, record: Record, angle: float, resistance: float, l_d: float, l_q: float
) -> float:
    """psi [V s] from the voltages of both directions. Raises BringUpError where the speed is too
    small for it."""
    _, at, speed = travel(bench, record, angle)
    i_d, i_q = rotor_frame(record.alpha, record.beta, at)
    late = VOLTAGE_LATE
    u_d, u_q = rotor_frame(record.u_alpha, record.u_beta, at + speed * late)
    # The voltage of row k is between the currents of rows k + 1 and k + 2.
    u_q = u_q[:-2]
    w = (speed[1:-1] + speed[2:]) / 2
    middle_d, middle_q = (i_d[1:-1] + i_d[2:]) / 2, (i_q[1:-1] + i_q[2:]) / 2
    rise = (i_q[2:] - i_q[1:-1]) / LOOP_PERIOD
    left = u_q - l_q * rise - w * l_d * middle_d
    block = 50
    n = len(left) // block * block
    y, x, v = (rows[:n].reshape(-1, block).mean(axis=1) for rows in (left, middle_q, w))
    # Not around a reversal: voltages saturate, and the dead time has another sign on its way.
    level = np.abs(middle_q[:n]) > STEADY * np.median(np.abs(middle_q))
    steady = level.reshape(-1, block).all(axis=1)
    basis = np.stack([x, v], axis=1)[steady]
    fit, *_ = np.linalg.lstsq(basis, y[steady], rcond=None)
    if fit[1] <= 0 or np.abs(v).max() < 20.0:
        raise BringUpError(
            f"the start-up reached {np.abs(v).max():.3g} rad/s electrical and its voltages say a "
            f"flux of {fit[1]:.3g} V s; a longer travel, or free the motor"
        )
    return float(fit[1])


def mechanics(bench: Bench, record: Record, angle: float, psi: float) -> tuple[float, float, float]:
    """Inertia, Coulomb and viscous friction, SI units."""
    one = bench.one
    counts, at, speed = travel(bench, record, angle)
    _, i_q = rotor_frame(record.alpha, record.beta, at)
    force = 1.5 * one.motor.wave * psi * i_q
    x = counts * one.resolution
    slow = 0.02 * np.abs(speed).max()
    sign = np.clip(speed / max(slow, 1.0), -1, 1)
    turning = np.flatnonzero(np.diff(np.sign(force[np.abs(force) > 0.3 * np.abs(force).max()])))
    length = max(len(record) // max(2 * (len(turning) + 1), 4), 40)
    length = min(length, 4000)
    step = max(length // 8, 1)
    s = np.linspace(-1, 1, length)
    h = 2 / (length - 1) / LOOP_PERIOD  # ds/dt
    bump = (1 - s**2) ** 3
    first = -6 * s * (1 - s**2) ** 2 * h
    second = (-6 * (1 - s**2) ** 2 + 24 * s**2 * (1 - s**2)) * h**2
    rows, values = [], []
    for begin in range(0, len(record) - length, step):
        part = slice(begin, begin + length)
        away = x[part] - x[begin]
        rows.append([second @ away, bump @ sign[part], -first @ away, bump.sum()])
        values.append(bump @ force[part])
    basis = np.array(rows)
    size = np.abs(basis).max(axis=0)
    fit, *_ = np.linalg.lstsq(basis / size, np.array(values), rcond=None)
    inertia, coulomb, viscous, _ = fit / size
    if inertia <= 0:
        raise BringUpError(
            "the start-up moved against its current; check pole_pairs and encoder_counts, and that "
            "nothing else moves the motor"
        )
    return float(inertia), max(0.0, float(coulomb)), max(0.0, float(viscous))
