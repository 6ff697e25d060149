# SPDX-License-Identifier: Apache-2.0
"""The switched inverter of the chain against the theory of dead time, which nobody here wrote.

A host orders sinusoidal compare values; PWM and its dead time are the RTL, inverter and windings
the plant of the chain, at standstill and with equal inductances: star-connected R and L, so each
line of the voltage is that of the current times R + j w L. A dead time takes from a leg a mean of
V_t = (t_d + t_on - t_off) f_pwm U_dc + V_drop against its current, a square wave in step with that:
4/pi V_t of the fundamental, and harmonics n = 5, 7, 11, 13 of 4/pi V_t / n, those below a multiple
of six turning backwards, none that three divides [S.-G. Jeong, M.-H. Park, The analysis and
compensation of dead-time effects in PWM inverters, IEEE Transactions on Industrial Electronics
38(2), 1991].
"""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from sim.bench.drive import start_up
from sim.bench.drive.chain import ChainRtl
from sim.bench.drive.plant import AXES, Plant
from sim.laws.drive.clocks import HALF_PERIOD
from sim.robot.drives import Drives
from sim.robot.parameters import Robot

ROBOT, FILE = Robot.load(), Drives.load()
R, L = 10.0, 5e-3
NAMES = ("legs", "tilt", "rotation")
SMOOTH = {f"{name}_{n}": value for n in NAMES for name, value in (("R", R), ("L_d", L), ("L_q", L))}
PERIOD = 500  # half periods of the carrier in one of the modulation
FREQUENCY = 200.0  # [Hz], of that
SETTLED = 750  # fifteen time constants L / R
DEPTH = np.array([0.5, 0.52, 0.55, 0.57, 0.6])  # of half the bus; no pulse is bound by PWM.minimum
PHASE = np.array([0.3, 1.4, -0.8, 2.9, -2.2])
DISTORTED = {-5: 1, 7: -1, -11: -1, 13: 1}  # sign of these lines in a square wave as a cosine
LINES = [n for n in range(-14, 15) if n != 1]
DEVIATIONS = 4  # of a complex line: 1 in 10^7 is beyond
LEAST = 96e-9  # s of dead time that the hardware keeps at least
WRITE = 100  # clock of a half in which the host begins to write

# Inverters, and V_t of them. The file's; one with twice the dead time and another bus voltage; and
# one whose switches are late in stopping by what they wait before they start, without drops: ideal.
INVERTERS = {
    "file": FILE,
    "longer": replace(FILE, dead_time=1.6e-6, delay_off=0.2e-6, U_dc=480.0),
    "ideal": replace(
        FILE, dead_time=LEAST, delay_on=0.0, delay_off=LEAST, drop=0.0, drop_resistance=0.0
    ),
}


def lost(drives: Drives) -> float:
    """V_t [V]."""
    time = drives.dead_time + drives.delay_on - drives.delay_off
    return time * drives.f_pwm * drives.U_dc + drives.drop


def late(drives: Drives) -> float:
    """By which both edges of a pulse, their mean, come after their order [s]."""
    return (drives.dead_time + drives.delay_on + drives.delay_off) / 2


def impedance(drives: Drives, n: int) -> complex:
    """Of a line [ohm]; the drop's resistance is in the way of the current all the time."""
    return R + drives.drop_resistance + 2j * np.pi * FREQUENCY * n * L


def spread(drives: Drives) -> float:
    """Standard deviation of a line of the voltage [V].

    A compare value is rounded, by a uniform part of a clock, and a leg sees its current turn at the
    next edge only, a uniform part of a half period late. Of the first there are 3 PERIOD in a line
    (each 2/3 / PERIOD of U_dc / HALF_PERIOD), of the second six (each 2/3 / PERIOD of 2 V_t).
    """
    rounding = np.sqrt(3 * PERIOD / 12) * 2 / 3 / PERIOD * drives.U_dc / HALF_PERIOD
    return float(np.hypot(rounding, np.sqrt(6 / 12) * 2 / 3 / PERIOD * 2 * lost(drives)))


def compare_values(number: int) -> NDArray[np.int64]:
    """(5, 3) clocks of a half in which the high gates are ordered on: sines a third apart."""
    angle = 2 * np.pi * number / PERIOD + PHASE[:, None] - 2 * np.pi / 3 * np.arange(3)
    return np.rint(HALF_PERIOD / 2 * (1 + DEPTH[:, None] * np.cos(angle))).astype(int)


@functools.cache
def lines(name: str) -> NDArray[np.complex128]:
    """Lines (PERIOD, 5) of the currents' space vector [A] over a period: line n turns n times, a
    negative one backwards."""
    drives = replace(INVERTERS[name], **SMOOTH)
    plant = Plant(ROBOT, drives)
    system = ChainRtl()
    system.place(plant, ROBOT.start)
    system.spin([0.0] * AXES)  # a test bench holds the rotors
    system.front("PWM", half_period=HALF_PERIOD, minimum=start_up.least_clocks(drives))
    system.front("DEAD_TIME", clocks=start_up.dead_clocks(drives))
    start_up.recover(system)
    system.front("MODE", **start_up.RUN)
    for number in range(SETTLED + PERIOD + 1):
        place = (system.look().clock - 64) % HALF_PERIOD
        system.clock((WRITE - place) % HALF_PERIOD)
        if number == SETTLED:
            system.trace()
        values = compare_values(number)
        for n in range(AXES):
            for phase in range(3):
                last = n == AXES - 1 and phase == 2
                fields = dict(axis=n, phase=phase, value=int(values[n, phase]), commit=int(last))
                system.front("COMPARE", **fields)
    system.clock(HALF_PERIOD)
    assert not system.status()["trip"] and system.look().shoot_through == 0
    halves = system.halves()[:PERIOD]
    angles = [m.wave * x for m, x in zip(drives.motors, system.look().joints, strict=True)]
    turned = np.exp(1j * (np.array(angles) + plant.angle))  # from the rotor's frame
    return np.fft.fft((halves["i_d"] + 1j * halves["i_q"]) * turned, axis=0) / PERIOD


def ordered(drives: Drives) -> NDArray[np.complex128]:
    """Fundamental (5,) of the ordered voltage [V]: its size by the compare values, its phase by the
    ideal inverter's currents, which see the same instants."""
    ideal = INVERTERS["ideal"]
    phase = np.angle(lines("ideal")[1] * impedance(ideal, 1))
    phase -= 2 * np.pi * FREQUENCY * (late(drives) - late(ideal))
    return DEPTH * drives.U_dc / 2 * np.exp(1j * phase)


def test_ideal_inverter__fundamental_of_the_compare_values_and_no_other_line():
    drives = INVERTERS["ideal"]
    found, most = lines("ideal"), DEVIATIONS * spread(drives)
    fundamental = np.abs(found[1] * impedance(drives, 1))
    np.testing.assert_allclose(fundamental, DEPTH * drives.U_dc / 2, rtol=0, atol=most)
    for n in LINES:
        assert np.abs(found[n] * impedance(drives, n)).max() < most, f"line {n}"


@pytest.mark.full
@pytest.mark.parametrize("name", ["file", "longer"])
def test_dead_time__fundamental_lost_and_harmonics_of_a_square_wave_with_the_current(name):
    drives = INVERTERS[name]
    found, square, most = lines(name), 4 / np.pi * lost(drives), DEVIATIONS * spread(drives)
    away = ordered(drives) - found[1] * impedance(drives, 1)
    np.testing.assert_allclose(np.abs(away), square, rtol=0, atol=most)
    # In step with the current except for what the harmonics shift its zeros.
    turning = [n for n in range(-PERIOD // 2, PERIOD // 2) if n % 6 == 1 and n != 1]
    harmonics = np.abs(found[turning]).sum(axis=0) / np.abs(found[1])
    assert (np.abs(np.angle(away / found[1])) < harmonics + most / square).all()
    for n in LINES:
        voltage = found[n] * impedance(drives, n)
        want = -DISTORTED.get(n, 0) * square / abs(n or 1) * np.exp(1j * n * np.angle(away))
        # The phase of `away` is itself known within `most`.
        assert np.abs(voltage - want).max() < (2 if n in DISTORTED else 1) * most, f"line {n}"
