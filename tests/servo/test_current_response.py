# SPDX-License-Identifier: Apache-2.0
"""Frequency response of the closed current loops against a transfer function of its own.

The function knows resistance, inductance, the PI's design and the instants: run k takes the current
`LATE` into half period k of the carrier, its voltage is there in half k + 1, all of it.
Between those instants winding and voltage are those of scipy.signal's zero-order hold. Decoupling,
Park, space vectors, dead time and its compensation should not be seen: the rotor is at rest, and no
current is near its zero.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from sim.bench.drive.response import (
    AMPLITUDE,
    NOISE,
    PERIODS,
    analyse,
    averaged_responses,
    multisine,
)
from sim.laws.drive.current_law import Setting
from sim.robot.drives import Drives, Motor
from sim.robot.parameters import Robot

ROBOT, DRIVES = Robot.load(), Drives.load()
SETTING = Setting(ROBOT.resolution)
T = 1e-5
LATE = (700 + 3 * 64 * 6 // 2 - 1250) * 8e-9  # the middle of 192 bits of 6 clocks from WINDOW on
DELAY = 1.5 * T  # from a sample to the middle of its voltage, that the design is for
DEVIATIONS = 4  # of a complex line: 1 in 10^7 is beyond


def held(motor: Motor, time: float) -> tuple[float, float]:
    """(share of a current that is left, amperes a volt makes) [1, A/V] after a time."""
    from scipy import signal

    r, inductance = motor.R + DRIVES.drop_resistance, motor.L_q
    system = [np.array([[v]]) for v in (-r / inductance, 1 / inductance, 1.0, 0.0)]
    a, b, *_ = signal.cont2discrete(system, time, "zoh")
    return a.item(), b.item()


def transfer(motor: Motor, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Ordered current to that at the begin of the half period whose run takes the order.

    The PI of the magnitude optimum: a zero on the winding's pole, K_p = L / (2 DELAY).
    """
    z = np.exp(2j * np.pi * frequency * T)
    k_p = motor.L_q / (2 * DELAY)
    control = k_p + k_p * motor.R / motor.L_q * T / (z - 1)
    (left, made), (left_late, made_late) = held(motor, T - LATE), held(motor, LATE)
    # i[k + 1] of the samples: after the rest of the old voltage and the first of the new one.
    plant = (left_late * made / z + made_late) / (z - left * left_late)
    closed = plant * control / (1 + plant * control)
    voltage = control * (1 - closed)
    return (closed - made_late * voltage / z) / left_late  # from a sample back to its half's begin


def most(axis: int) -> float:
    """Largest error of a closed loop's line that noise makes: that of i_a and i_b in i_q (5/3 of
    the variance at most), over all samples, against half the amplitude of an order's line."""
    samples = PERIODS * len(multisine(SETTING))
    line = AMPLITUDE * DRIVES.motors[axis].i_max / 2
    return DEVIATIONS * float(np.sqrt(5 / 3 / samples)) * NOISE / line


@pytest.fixture(scope="module")
def found():
    return averaged_responses(ROBOT, DRIVES, SETTING)


@pytest.mark.parametrize("axis", range(5))
def test_closed_loop__is_the_transfer_function_in_size_and_phase(found, axis):
    """The loop follows noise as it follows an order."""
    loop = found[axis]
    want = transfer(DRIVES.motors[axis], loop.frequency)
    off = np.abs(loop.closed - want) / np.maximum(np.abs(want), 1)
    assert off.max() < most(axis)


@pytest.mark.parametrize("axis", range(5))
def test_bandwidth_and_margin__are_those_of_the_transfer_function(found, axis):
    """A line apart at most, which is 11 %; the margin as noise of closed / (1 - closed) moves it:
    where the loop's gain is 1, by |1 + loop|^2 = 2 - 2 cos(margin)."""
    loop = found[axis]
    want = analyse(loop.frequency, transfer(DRIVES.motors[axis], loop.frequency))
    assert loop.bandwidth == pytest.approx(want.bandwidth, rel=0.11)
    far = 2 - 2 * np.cos(np.radians(want.margin))
    assert loop.margin == pytest.approx(want.margin, abs=np.degrees(far * most(axis)))
