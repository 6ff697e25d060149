# SPDX-License-Identifier: Apache-2.0
"""The closed current loops of all axes, brakes closed: steps, frequency response, dead time.

`steps`, `responses` and `distortion` simulate every clock of the RTL chain with its exact
inverters, noise and dead time; `averaged_responses` and `averaged_turn` do with averaged
inverters what takes a minute there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.bench.drive import start_up
from sim.bench.drive.averaged import AveragedPlant, at_joints, true_angles
from sim.bench.drive.chain import ChainRtl
from sim.bench.drive.hardware import check
from sim.bench.drive.plant import AXES, Plant
from sim.bench.drive.status import told
from sim.laws.drive.clocks import CLOCK, HALF_PERIOD
from sim.laws.drive.current_law import Setting
from sim.robot.drives import Drives
from sim.robot.parameters import Robot

NOISE = 3e-3  # of a sensed current on averaged inverters [A]; `steps` measures the modulators'
BASE = 200.0  # spacing of the multisine's lines [Hz]
LINES = np.unique(np.round(np.geomspace(2, 100, 40)).astype(int))  # multiples of BASE
AMPLITUDE = 0.001  # of a line, as a share of i_max: no voltage saturates
BIAS = 0.05  # of i_max, so that dead time acts with one sign
PERIODS = 8  # of the multisine after the first, which settles
TURN = 25.0  # electrical frequency at which the distortion is looked for [Hz]
SIXTHS = 3  # of a turn that are looked at, after as many half periods that settle as `WAIT`
WHOLE = 6  # the same with errors of the sensing: what is left of an offset turns once a turn
WAIT = 1000
RAMP = 50  # half periods until the motors turn so fast
MOST_HARMONIC = 10e3  # Hz: beyond it is the carrier's ripple
LARGE = 0.05  # of i_max: current there
RECORD_PLACE = 200  # clock of a half in which a record begins: rows come at 100, means end at 751
LAG = 100 * CLOCK  # s from a sample's middle to that of a mean of `HALF`


def locked(robot: Robot, drives: Drives, setting: Setting, plant: Plant) -> tuple[ChainRtl, float]:
    """RTL with brakes closed, gates on, no current; largest noise [A] of a sensed current without
    gates. Raises ParameterError for what the hardware does not follow, StartUpError."""
    check(robot, drives)
    system = ChainRtl()
    counts = system.place(plant, robot.start)
    start_up.configure(system, drives, setting, counts)
    start_up.measure_offsets(system)
    noise = start_up.sense(system, 32).std(axis=0).max() * setting.ampere_per_count
    start_up.write_angles(system, true_angles(plant, at_joints(plant, robot.start)))
    start_up.order(system, [0.0] * AXES)
    system.front("LINK", enable=1)
    system.clock(3 * HALF_PERIOD)
    system.front("MODE", **start_up.RUN)
    system.clock(20 * HALF_PERIOD)
    return system, float(noise * drives.current_scale)


def ahead(system: ChainRtl) -> None:
    """To the next clock in which a record may begin."""
    place = (system.look().clock - 64) % HALF_PERIOD
    system.clock((RECORD_PLACE - place) % HALF_PERIOD)


def record(system: ChainRtl, addresses: list[int], rows: ArrayLike) -> NDArray[np.void]:
    """Half periods, a row (5,) of words written in each, the run of row k taking the sample around
    which the k-th means are, `LAG` earlier. Raises StartUpError for a trip or a shoot-through."""
    ahead(system)
    system.trace()
    system.order(addresses, rows)
    count = len(np.asarray(rows))
    system.clock((count + 1) * HALF_PERIOD)
    status = system.status()
    if status["trip"]:
        raise start_up.StartUpError(f"while the current loops were measured, {told(status)}")
    if system.look().shoot_through:
        raise start_up.StartUpError(
            "both gates of a phase were on: the RTL of the PWM is broken, not a parameter wrong; "
            "`microtick formal --only no_shoot_through` shows where"
        )
    return system.halves()[1 : count + 1]


def steps(robot: Robot, drives: Drives, share: float) -> tuple[NDArray[np.float64], float]:
    """i_q (130, 5) [A] of a step of all orders to `share` of i_max in half period 10; the noise of
    `locked`. Raises StartUpError."""
    system, noise = locked(robot, drives, Setting(robot.resolution), Plant(robot, drives))
    rows = np.zeros((130, AXES))
    rows[10:] = [share * m.i_max * m.force_per_ampere for m in drives.motors]
    found = record(system, system.current.input_addresses(start_up.FORCES), rows)
    return found["i_q"], noise


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


def excitation(drives: Drives, setting: Setting) -> tuple[NDArray[np.float64], int]:
    """Ordered i_q (n, 5) [A], its period and `PERIODS` more; half periods of a period."""
    wave = multisine(setting)
    share = BIAS + np.tile(AMPLITUDE * wave, PERIODS + 1)
    return share[:, None] * [m.i_max for m in drives.motors], len(wave)


def responses(robot: Robot, drives: Drives, setting: Setting) -> list[Response]:
    """Of all axes, every clock, with dead time, noise and errors of the sensing. Raises
    StartUpError."""
    wanted, period = excitation(drives, setting)
    system, _ = locked(robot, drives, setting, Plant(robot, drives))
    orders = wanted * [m.force_per_ampere for m in drives.motors]
    i_q = record(system, system.current.input_addresses(start_up.FORCES), orders)["i_q"]
    return _analysed(wanted[period:], i_q[period:], LAG)


def averaged_responses(robot: Robot, drives: Drives, setting: Setting) -> list[Response]:
    """The same on averaged inverters."""
    wanted, period = excitation(drives, setting)
    machine = AveragedPlant(Plant(robot, drives), setting, robot.start, noise=NOISE)
    machine.brakes(0)
    i_q = machine.halves(wanted * [m.force_per_ampere for m in drives.motors])[:, 5:10]
    # The run that takes row k sees the current at the end of half k - 1.
    return _analysed(wanted[period:], i_q[period:], setting.period)


def _analysed(wanted: NDArray, i_q: NDArray, late: float) -> list[Response]:
    """late: seconds from the sample that a row's run takes to the row's i_q."""
    seen = np.exp(-2j * np.pi * LINES * BASE * late)
    lines, found = LINES * PERIODS, []
    for n in range(AXES):
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


def distortion(
    robot: Robot, drives: Drives, setting: Setting, sensing: bool = False
) -> NDArray[np.float64]:
    """Error of the current (5,) [A], rms, that the dead time makes at `LARGE` of i_max.

    Every clock, the motors turned by a test bench: `harmonics` of half a turn, or, with offsets and
    gain errors of the currents (sensing), of a whole one. Raises StartUpError.
    """
    plant = Plant(robot, drives, friction=False, sensing=sensing)
    system, _ = locked(robot, drives, setting, plant)
    turn(system, drives)
    sixths = WHOLE if sensing else SIXTHS
    samples = round(sixths / 6 / TURN / setting.period)
    orders = [LARGE * m.i_max * m.force_per_ampere for m in drives.motors]
    rows = np.tile(orders, (WAIT + samples, 1))
    found = record(system, system.current.input_addresses(start_up.FORCES), rows)[WAIT:]
    return harmonics(found["i_d"] + 1j * found["i_q"], setting.period, sixths)


def turn(system: ChainRtl, drives: Drives) -> None:
    """Let a test bench turn the motors at `TURN`, from rest and slowly: a change of speed acts on
    the microsecond before it too, and two counts at once would trip the axis."""
    speeds = np.array([2 * np.pi * TURN / m.wave for m in drives.motors])
    for share in np.arange(1, RAMP + 1) / RAMP:
        system.spin(share * speeds)
        system.clock(HALF_PERIOD)


def harmonics(
    current: NDArray[np.complex128], period: float, sixths: int = WHOLE
) -> NDArray[np.float64]:
    """Rms (5,) of the lines of i_d + j i_q (n, 5) at multiples of six times the electrical
    frequency, below `MOST_HARMONIC`: harmonics 5, 7, 11, 13 ... of the phase currents.

    The rows, `period` [s] apart, are so many sixths of a turn. Noise on these lines counts, the
    less the more turns there are. A gain error makes a line that turns back twice a turn, whatever
    the dead time; it does not count.
    """
    lines = np.fft.fft(current, axis=0)[::sixths] / len(current)
    frequency = np.abs(np.fft.fftfreq(len(current), period)[::sixths])
    of_dead_time = (frequency > 0) & (frequency < MOST_HARMONIC)
    return np.sqrt((np.abs(lines[of_dead_time]) ** 2).sum(axis=0))


def averaged_turn(robot: Robot, drives: Drives, setting: Setting) -> NDArray[np.complex128]:
    """i_d + j i_q (n, 5) [A] over a turn at `LARGE` of i_max, a row a half period, on averaged
    inverters that a test bench turns: noise, offsets and gain errors of the sensing."""
    plant = Plant(robot, drives, friction=False)
    machine = AveragedPlant(plant, setting, robot.start, noise=NOISE)
    rows = WAIT + round(1 / TURN / setting.period)
    travel = np.outer(np.arange(rows + 1) * setting.period * TURN, [m.pole for m in drives.motors])
    orders = np.tile([LARGE * m.i_max * m.force_per_ampere for m in drives.motors], (rows, 1))
    found = machine.halves(orders, at_joints(plant, robot.start) + travel)[WAIT:]
    return found[:, :5] + 1j * found[:, 5:10]
