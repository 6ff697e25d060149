# SPDX-License-Identifier: Apache-2.0
"""The closed current loops of all axes, brakes closed: steps, frequency response, dead time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.model.drives import Drives
from sim.model.parameters import Robot
from sim.servo import start_up
from sim.servo.averaged import AveragedPlant, at_joints, true_angles
from sim.servo.chain import ChainRtl
from sim.servo.current_law import Setting
from sim.servo.plant import AXES, Plant

HOME = (0.0, 0.0, 0.6, 0.0, 0.0)
NOISE = 3e-3  # of a sensed current on averaged inverters [A]; `steps` measures the modulators'
BASE = 200.0  # spacing of the multisine's lines [Hz]
LINES = np.unique(np.round(np.geomspace(2, 100, 40)).astype(int))  # multiples of BASE
AMPLITUDE = 0.001  # of a line, as a share of i_max: no voltage saturates
PERIODS = 8  # of the multisine behind the first, which settles


def steps(
    robot: Robot, drives: Drives, share: float, halves: int = 130
) -> tuple[NDArray[np.float64], float]:
    """RTL, every clock: i_q (halves, 5) [A] of a step of all orders to `share` of i_max in half
    period 10; largest noise [A] of a sensed current without gates. Raises StartUpError."""
    system, plant = ChainRtl(), Plant(robot, drives)
    setting = Setting(robot.resolution)
    counts = system.place(plant, HOME)
    start_up.configure(system, drives, setting, counts, 1.3 * max(m.i_max for m in drives.motors))
    start_up.measure_offsets(system)
    noise = start_up.sense(system, 32).std(axis=0).max() * setting.ampere_per_count
    start_up.write_angles(system, true_angles(plant, at_joints(plant, HOME)))
    start_up.order(system, [0.0] * AXES)
    system.front("LINK", enable=1)
    system.clock(3 * 1250)
    system.front("MODE", axes=start_up.RUN)
    system.clock(20 * 1250)
    system.trace()
    rows = np.zeros((halves, AXES))
    rows[10:] = [share * m.i_max * m.force_per_ampere for m in drives.motors]
    core = system.current
    system.order(core.input_addresses(start_up.FORCES), rows)
    system.clock((halves + 2) * 1250)
    if system.status()["trip"] or system.look().shoot_through:
        raise start_up.StartUpError(f"the step tripped an axis: {system.status()}")
    return system.halves()["i_q"][1 : halves + 1], float(noise * drives.current_scale)


@dataclass(frozen=True)
class Response:
    """Closed loop, ordered to actual i_q, at frequencies [Hz]; -3 dB [Hz], margin [degrees]."""

    frequency: NDArray[np.float64]
    closed: NDArray[np.complex128]
    bandwidth: float
    margin: float


def multisine(setting: Setting) -> NDArray[np.float64]:
    """One period of it, phases by Schroeder for a small crest; a sample a half period."""
    samples = round(1 / (BASE * setting.period))
    t = np.arange(samples) / samples
    phases = -np.pi * np.arange(len(LINES)) ** 2 / len(LINES)
    return np.cos(2 * np.pi * np.outer(t, LINES) + phases).sum(axis=1)


def responses(robot: Robot, drives: Drives, setting: Setting) -> list[Response]:
    """Of all axes, averaged inverters with dead time, noise and errors of the sensing."""
    wave = multisine(setting)
    share = AMPLITUDE * wave
    bias = 0.05  # dead time acts with one sign
    orders = np.array([m.i_max * m.force_per_ampere for m in drives.motors])
    rows = (bias + np.tile(share, PERIODS + 1))[:, None] * orders
    machine = AveragedPlant(Plant(robot, drives), setting, HOME, noise=NOISE)
    machine.brakes(0)
    i_q = machine.halves(rows)[len(wave) :, 5:10]
    wanted = rows[len(wave) :] / [m.force_per_ampere for m in drives.motors]
    found = []
    for n in range(AXES):
        lines = LINES * PERIODS
        # The run that takes row k sees the current at the end of half k - 1.
        seen = np.exp(-2j * np.pi * LINES * BASE * setting.period)
        closed = seen * np.fft.fft(i_q[:, n])[lines] / np.fft.fft(wanted[:, n])[lines]
        found.append(analyse(LINES * BASE, closed))
    return found


def analyse(frequency: NDArray[np.float64], closed: NDArray[np.complex128]) -> Response:
    """-3 dB, and the phase margin of closed / (1 - closed)."""
    size = np.abs(closed)
    below = np.flatnonzero(size < np.sqrt(0.5))
    bandwidth = float(frequency[below[0]]) if below.size else float(frequency[-1])
    loop = closed / (1 - closed)
    gain = np.log(np.abs(loop))
    (crossings,) = np.nonzero((gain[:-1] >= 0) & (gain[1:] < 0))
    if not crossings.size:
        return Response(frequency, closed, bandwidth, 0.0)
    k = int(crossings[-1])
    share = gain[k] / (gain[k] - gain[k + 1])
    phase = np.unwrap(np.angle(loop))
    phase += 2 * np.pi * np.round((-np.pi / 2 - phase[k]) / (2 * np.pi))
    at = phase[k] + share * (phase[k + 1] - phase[k])
    return Response(frequency, closed, bandwidth, float(180 + np.degrees(at)))


def distortion(robot: Robot, drives: Drives, setting: Setting) -> NDArray[np.float64]:
    """Error of the current (5,) [A], rms, that the dead time makes at 5 % of i_max while the
    machine turns: rotor currents without their mean, no other cause of error."""
    plant = Plant(robot, drives, friction=False, sensing=False)
    machine = AveragedPlant(plant, setting, HOME)
    orders = [0.05 * m.i_max * m.force_per_ampere for m in drives.motors]
    found = machine.halves(np.tile(orders, (35_000, 1)))[5000:, :10]
    off = found - found.mean(axis=0)
    return np.sqrt((off[:, :5] ** 2 + off[:, 5:] ** 2).mean(axis=0))
