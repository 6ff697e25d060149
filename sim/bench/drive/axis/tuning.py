# SPDX-License-Identifier: Apache-2.0
"""Gains of one axis from its bandwidths, and both loops as they are: responses by injection."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from asip_asm.model.compiler import Compiled, Options, compile_law
from sim.bench.drive.axis import hall
from sim.bench.drive.axis.bench import MILLISECOND, Bench, Record
from sim.bench.drive.axis.identify import INNER, Found, rotor_frame, travel
from sim.bench.drive.axis.motor_file import (
    HALL,
    HALL_SPEED,
    LINEAR,
    OPTIMUM,
    OneMotor,
    fastest_move,
)
from sim.bench.drive.response import BASE, LINES, PERIODS, Response, analyse, multisine
from sim.laws.drive.clocks import LOOP_PERIOD
from sim.laws.drive.current_law import DELAY, gains
from sim.laws.drive.velocity_law import FILTER, INTEGRAL, VelocitySetting, velocity_law

EVERY = 10  # half periods of a run of the velocity loop
PERIOD = EVERY * LOOP_PERIOD
VELOCITY_OPTIONS = Options(configuration="fast", reassociate=True, reciprocal=True)
# Of a line at most, as a share of the rated current; edges of Hall lines disturb the loop.
AMPLITUDE, HALL_AMPLITUDE = 0.005, 0.02
BIAS = 0.1  # of the rated current, so that dead time acts with one sign
MOST_LINES = 0.12  # of the bus voltage, rms of all lines
MOST_FORCE = 0.9  # of the rated one, that the velocity loop may order
HALL_RUN_UP = 16  # sectors, until the acceleration changes their time by little
HALL_BASE = 0.5  # of the fastest moves: from where the speed steps
HALF_POWER = math.sqrt(0.5)


@dataclass(frozen=True)
class Gains:
    """crossover of the current loop [rad/s]; K_p of d and q [V/A], K_i of both [V/(A s)]."""

    crossover: float
    k_d: float
    k_q: float
    k_i: float
    velocity: VelocitySetting

    @property
    def velocity_gains(self) -> tuple[float, float]:
        """K_p [force s/travel] and K_i [force/travel]."""
        k_p = self.velocity.inertia * self.velocity.crossover
        return k_p, k_p * INTEGRAL * self.velocity.crossover


def gains_of(one: OneMotor, found: Found) -> Gains:
    """From the bandwidths of the file and what was identified."""
    crossover = current_crossover(one.current_bandwidth)
    motor = found.motor(one.motor)
    k_d, k_q, k_i = gains(motor, LOOP_PERIOD, crossover)
    velocity = VelocitySetting(
        velocity_crossover(one.velocity_bandwidth, crossover),
        PERIOD,
        one.resolution,
        motor.wave,
        found.inertia,
        found.coulomb,
        found.viscous,
        MOST_FORCE * motor.force_per_ampere * motor.i_max,
    )
    return Gains(crossover, k_d, k_q, k_i / LOOP_PERIOD, velocity)


def current_crossover(bandwidth: float) -> float:
    """Crossover [rad/s] of an integrator with 1.5 periods of delay whose closed loop has this
    bandwidth [Hz]."""
    s = 2j * np.pi * bandwidth

    def size(crossover: float) -> float:
        loop = crossover / s * np.exp(-s * DELAY * LOOP_PERIOD)
        return float(abs(loop / (1 + loop)))

    return _solved(size, 1.0, OPTIMUM)


def velocity_crossover(bandwidth: float, current: float) -> float:
    """The same of the velocity loop, with filter, integral and all its delays."""
    s = 2j * np.pi * bandwidth
    late = PERIOD / 2 + DELAY * LOOP_PERIOD + 1 / current

    def size(crossover: float) -> float:
        forward = crossover * (1 + INTEGRAL * crossover / s) / s * np.exp(-s * late)
        back = np.exp(-s * PERIOD / 2) / (1 + s / (FILTER * crossover))
        return float(abs(forward / (1 + forward * back)))

    return _solved(size, 0.1, 2 * np.pi * bandwidth)


def _solved(size: Callable[[float], float], low: float, high: float) -> float:
    """Where a size that rises with the crossover is -3 dB."""
    for _ in range(60):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if size(middle) > HALF_POWER else (middle, high)
    return low


def current_response(bench: Bench, found: Found, tuned: Gains) -> Response:
    """Ordered to sensed i_q, by a multisine that is added to a small current of a free motor."""
    motor = found.motor(bench.one.motor)
    bench.current_loop(motor, found.angle, tuned.crossover)
    wave = multisine(bench.one.setting())
    volts = motor.L_q * tuned.crossover * motor.i_max * float(wave.std())  # of lines of 1
    most = HALL_AMPLITUDE if bench.one.encoder == HALL else AMPLITUDE
    size = min(most, MOST_LINES * bench.one.U_dc / volts)
    wanted = (BIAS + np.tile(size * wave, PERIODS + 1)) * motor.i_max
    if bench.one.encoder == HALL:
        spin_up(bench, found, BIAS * motor.i_max * motor.force_per_ampere)
    seen = bench.run((wanted * motor.force_per_ampere)[:, None])
    stop = np.full((len(wave), 1), -BIAS * motor.i_max * motor.force_per_ampere)
    bench.run(np.tile(stop, (PERIODS + 1, 1)))
    _, at, _ = travel(bench, seen, found.angle)
    i_q = rotor_frame(seen.alpha, seen.beta, at)[1]
    lines = LINES * PERIODS
    spectra = [np.fft.fft(rows[len(wave) :])[lines] for rows in (i_q, wanted)]
    return interpolated(analyse(LINES * BASE, spectra[0] / spectra[1]))


def spin_up(bench: Bench, found: Found, force: float) -> None:
    """Turn a motor until its Hall lines give a good angle, for a second at most."""
    fast = HALL_BASE * limits(bench.one, found)[0] / bench.one.resolution
    seen, rows = [bench.counts], np.full((MILLISECOND, 1), force)
    for _ in range(1000):
        seen += bench.run(rows).counts.tolist()
        far = abs(seen[-1] - seen[0]) > HALL_RUN_UP * hall.SECTOR
        if far or abs(hall.speed(np.array(seen))) > fast:
            return


def interpolated(response: Response) -> Response:
    """With the bandwidth between two lines, straight in their logarithms."""
    size = np.log(np.abs(response.closed) / HALF_POWER)
    (below,) = np.nonzero((size[:-1] >= 0) & (size[1:] < 0))
    if not below.size:
        return response
    k, f = int(below[0]), np.log(response.frequency)
    at = f[k] + (f[k + 1] - f[k]) * size[k] / (size[k] - size[k + 1])
    return replace(response, bandwidth=float(np.exp(at)))


def velocity_program(tuned: Gains) -> Compiled:
    """The velocity loop, compiled for the core `fast`."""
    return compile_law(velocity_law(tuned.velocity), VELOCITY_OPTIONS)


def close(bench: Bench, found: Found, tuned: Gains) -> None:
    """Load both loops; rows are `velocity_law.ORDERS` and a force to add."""
    bench.current_loop(found.motor(bench.one.motor), found.angle, tuned.crossover)
    bench.outer(velocity_program(tuned), EVERY)


def limits(one: OneMotor, found: Found) -> tuple[float, float]:
    """Speed and acceleration of moves [SI units of travel]."""
    motor = found.motor(one.motor)
    speed = fastest_move(one, motor.psi) / motor.wave
    force = motor.force_per_ampere * motor.i_max
    return speed, 0.4 * (force - found.coulomb) / found.inertia


def go(bench: Bench, found: Found, begin: float, end: float) -> tuple[Record, NDArray[np.float64]]:
    """Move from a count to another with both loops closed: the record, wanted counts."""
    one = bench.one
    speed, acceleration = limits(one, found)
    way = (end - begin) * one.resolution
    time = max(2 * abs(way) / speed, math.sqrt(2 * math.pi * abs(way) / acceleration), 0.02)
    n = round(time / LOOP_PERIOD)
    s = np.arange(n) / n
    # Static friction holds the rest of the way until the integral has grown.
    wait = round(min(10 / (INTEGRAL * 2 * np.pi * one.velocity_bandwidth), 0.5) / LOOP_PERIOD)
    rows = np.zeros((n + wait, 5))
    rows[:n, 0] = begin + (end - begin) * (s - np.sin(2 * np.pi * s) / (2 * np.pi))
    rows[n:, 0] = end
    rows[:n, 1] = way / time * (1 - np.cos(2 * np.pi * s))
    rows[:n, 2] = 2 * np.pi * way / time**2 * np.sin(2 * np.pi * s)
    rows[:, 3] = 1
    return bench.run(rows), rows[:, 0]


def room(one: OneMotor) -> float:
    """Counts to each side of count 0 that a linear motor may move; infinite of a rotary one."""
    return INNER * one.travel / one.resolution if one.kind == LINEAR else math.inf


def velocity_response(bench: Bench, found: Found, tuned: Gains, now: float) -> Response:
    """Ordered to actual speed, by a multisine added to a constant speed; both loops closed.

    now: counts where the motor rests.
    """
    one, f = bench.one, bench.one.velocity_bandwidth
    base, periods = f / 5, 3
    lines = np.unique(np.round(np.geomspace(1, 25, 14)).astype(int))
    samples = EVERY * round(1 / (base * PERIOD))
    base = 1 / (samples * LOOP_PERIOD)
    length = periods * samples * LOOP_PERIOD
    speed, acceleration = limits(one, found)
    run_up = 0.5 / f + 0.05
    share = HALL_SPEED if one.encoder == HALL else 0.4
    bias = min(share * speed, 1.2 * room(one) * one.resolution / (length + 3 * run_up))
    if one.kind == LINEAR:
        go(bench, found, now, -0.6 * room(one))
    t = np.arange(samples) // EVERY * EVERY / samples
    w = 2 * np.pi * base * lines
    sizes = np.minimum(1.0, (2 * np.pi * f) / w)
    wave = (sizes * np.cos(2 * np.pi * np.outer(t, lines) - np.pi * np.arange(len(lines)) ** 2
                           / len(lines))).sum(axis=1)  # fmt: skip
    jerk = np.abs(np.gradient(wave, LOOP_PERIOD * EVERY)).max() + 2 * np.pi * f * np.abs(wave).max()
    scale = min(0.5 * bias / np.abs(wave).max(), 0.5 * acceleration / jerk)
    begin = round(run_up / LOOP_PERIOD / EVERY) * EVERY
    ramp = np.minimum(1.0, 2 * np.arange(begin) / begin)
    wanted = np.concatenate([bias * ramp, bias + scale * np.tile(wave, periods)])
    rows = np.zeros((len(wanted), 5))
    rows[:, 1] = wanted
    record = bench.run(rows)
    stop = np.zeros((2 * begin, 5))
    stop[:, 1] = bias * np.linspace(1, 0, 2 * begin) ** 2
    after = bench.run(stop)
    n = len(wanted) - begin - samples
    order = np.fft.fft(wanted[-n:])[lines * (periods - 1)]

    def closed_by(counts: NDArray[np.float64]) -> NDArray[np.complex128]:
        trend = (counts[n // 2 :].mean() - counts[: n // 2].mean()) / (n // 2)
        moved = (counts - trend * np.arange(n)) * one.resolution
        return 1j * w * np.fft.fft(moved)[lines * (periods - 1)] / order

    sensed = closed = closed_by(record.counts[-n:])
    if one.encoder == HALL:
        closed = closed_by(travel(bench, record + after, 0.0)[0][len(record) - n : len(record)])
    z = np.exp(-1j * w * PERIOD)
    share = tuned.velocity.share
    back = (1 - z) / (1j * w * PERIOD) * share / (1 - (1 - share) * z)
    whole = interpolated(analyse(w / (2 * np.pi), closed))
    return replace(whole, margin=analyse(w / (2 * np.pi), sensed * back).margin)


def frames_lost(bench: Bench, found: Found, tuned: Gains, frames: int) -> tuple[float, float]:
    """Error of the angle in a step of the ordered speed, in whose begin so many frames are lost:
    rms and largest, electrical [degrees]; both loops closed."""
    one = bench.one
    speed, acceleration = limits(one, found)
    step = min(0.3 * speed, 0.5 * acceleration / tuned.velocity.crossover)
    rest, n = 20 * MILLISECOND, round(0.5 / one.velocity_bandwidth / LOOP_PERIOD)
    step = min(step, 0.3 * room(one) * one.resolution / (2 * n * LOOP_PERIOD))
    rows = np.zeros((rest, 5))
    bench.run(rows)
    rows = np.zeros((n, 5))
    rows[:, 1] = step
    # The force comes with the first run of the velocity loop.
    bench.run(rows[: 2 * EVERY])
    bench.lose(frames)
    bench.off()
    bench.run(rows)
    found_off = bench.off()
    rows[:, 1] *= np.linspace(1, 0, n)
    bench.run(rows)
    return found_off


def speed_step(
    bench: Bench, found: Found, tuned: Gains
) -> tuple[NDArray[np.float64], NDArray[np.float64], float, float]:
    """A step of the ordered speed with both loops closed: actual and ordered speed, a row a half
    period, the rise from 10 % to 90 % [s], the overshoot as a share."""
    from scipy.signal import savgol_filter  # here: more than a second of every command

    one = bench.one
    speed, acceleration = limits(one, found)
    time = 2.5 / one.velocity_bandwidth
    ways = (0.3 * speed, 0.5 * acceleration / tuned.velocity.crossover)
    step = min(*ways, 0.3 * room(one) * one.resolution / time)
    rest, n = 20 * MILLISECOND, round(time / LOOP_PERIOD)
    base = HALL_BASE * speed if one.encoder == HALL else 0.0
    if base:
        turn(bench, one, base)
    rows = np.zeros((rest + n, 5))
    rows[:, 1] = base
    rows[rest:, 1] += step
    record = bench.run(rows)
    wanted = rows[:, 1].copy()
    rows[:, 1] = (base + step) * np.linspace(1, 0, len(rows)) ** 2
    end = bench.run(rows)
    if base:
        actual = travel(bench, record + end, 0.0)[2][: len(record)] / one.motor.wave
    else:
        width = 2 * round(0.02 / one.velocity_bandwidth / LOOP_PERIOD) + 41
        scaled = record.counts * one.resolution
        actual = savgol_filter(scaled, width, 2, deriv=1, delta=LOOP_PERIOD)
    after = actual[rest:] - base
    rise = int(np.argmax(after > 0.9 * step) - np.argmax(after > 0.1 * step)) * LOOP_PERIOD
    return actual, wanted, rise, after.max() / step - 1


def turn(bench: Bench, one: OneMotor, speed: float) -> None:
    """Bring a motor to a constant speed; both loops closed."""
    rows = np.zeros((round(8 / one.velocity_bandwidth / LOOP_PERIOD), 5))
    rows[:, 1] = speed * np.minimum(1.0, 2 * np.linspace(0, 1, len(rows)))
    bench.run(rows)


def turning_errors(
    bench: Bench, found: Found, speeds: tuple[float, ...]
) -> dict[str, tuple[float, float]]:
    """Errors of the angle by Hall lines at these shares of the fastest moves: rms and largest,
    electrical [degrees]; both loops closed."""
    one, errors = bench.one, {}
    for share in speeds:
        speed = share * limits(one, found)[0]
        turn(bench, one, speed)
        bench.off()
        rows = np.zeros((200 * MILLISECOND, 5))
        rows[:, 1] = speed
        bench.run(rows)
        errors[f"at {speed * one.motor.wave:.0f} rad/s electrical"] = bench.off()
    rows = np.zeros((200 * MILLISECOND, 5))
    rows[:, 1] = speed * np.linspace(1, 0, len(rows)) ** 2
    bench.run(rows)
    return errors
