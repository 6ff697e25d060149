# SPDX-License-Identifier: Apache-2.0
"""Drives of CiA 402: state machine, modes of operation, faults.

Independent of us: python-canopen's masks of the statusword and its table of transitions; scipy's
polynomials for the interpolation; Ruckig for the moves of profile position.
"""

from __future__ import annotations

import itertools
import math
import random
import struct

import numpy as np
import pytest
from canopen import objectdictionary
from canopen.profiles.p402 import BaseNode402, State402
from canopen.sdo import SdoClient
from ruckig import InputParameter, Result, Ruckig, Trajectory
from scipy.interpolate import BPoly

from tests.ethercat.host import AXES, ERROR, OP, PREOP, SAFEOP, Host

SHUTDOWN, SWITCH_ON, ENABLE, QUICK_STOP, RESET = 0x06, 0x07, 0x0F, 0x02, 0x80
PP, HOMING, CSP, CSV, CST = 1, 6, 8, 9, 10
TICK = 1e-4  # s
PLANNING = 34  # control cycles in which a move of profile position is planned


def state_of(status: int) -> str:
    """The one state whose mask python-canopen finds in the statusword."""
    found = [s for s, (mask, value) in State402.SW_MASK.items() if status & mask == value]
    assert len(found) == 1, hex(status)
    return found[0]


class Drives(Host):
    """The device in OP; `set` gives outputs of an axis, each `step` writes them."""

    def __init__(self, mode: int = CSP) -> None:
        super().__init__()
        self.to_op()
        self.values = {(0x6060 + 0x800 * n, 0): mode for n in range(AXES)}
        self.step()

    def set(self, axis: int = 0, **values: int) -> None:
        names = {
            "control": 0x6040, "mode": 0x6060, "position": 0x607A, "velocity": 0x60FF,
            "torque": 0x6071, "velocity_offset": 0x60B1, "torque_offset": 0x60B2,
        }  # fmt: skip
        for name, value in values.items():
            self.values[names[name] + 0x800 * axis, 0] = value

    def step(self, cycles: int = 1) -> None:
        """A frame of the master, then control cycles."""
        self.outputs(self.values)
        self.cycle(cycles)

    def idle(self, cycles: int) -> None:
        """Control cycles with a frame each millisecond."""
        for at in range(0, cycles, 10):
            self.step(min(10, cycles - at))

    def statusword(self, axis: int = 0) -> int:
        return self.inputs()[0x6041 + 0x800 * axis, 0]

    def state(self, axis: int = 0) -> str:
        return state_of(self.statusword(axis))

    def enable(self, axis: int = 0, **values: int) -> None:
        for control in (SHUTDOWN, SWITCH_ON, ENABLE):
            self.set(axis, control=control, **values)
            self.step()
        assert self.state(axis) == "OPERATION ENABLED"


# -------------------------------------------------------------------- state machine

NUMBERS = {
    ("READY TO SWITCH ON", "SWITCH ON DISABLED"): 7,
    ("OPERATION ENABLED", "SWITCH ON DISABLED"): 9,
    ("SWITCHED ON", "SWITCH ON DISABLED"): 10,
    ("QUICK STOP ACTIVE", "SWITCH ON DISABLED"): 12,
    ("NOT READY TO SWITCH ON", "SWITCH ON DISABLED"): 1,
    ("START", "NOT READY TO SWITCH ON"): 0,
    ("FAULT REACTION ACTIVE", "FAULT"): 14,
    ("SWITCH ON DISABLED", "READY TO SWITCH ON"): 2,
    ("SWITCHED ON", "READY TO SWITCH ON"): 6,
    ("OPERATION ENABLED", "READY TO SWITCH ON"): 8,
    ("READY TO SWITCH ON", "SWITCHED ON"): 3,
    ("OPERATION ENABLED", "SWITCHED ON"): 5,
    ("SWITCHED ON", "OPERATION ENABLED"): 4,
    ("QUICK STOP ACTIVE", "OPERATION ENABLED"): 16,
    ("OPERATION ENABLED", "QUICK STOP ACTIVE"): 11,
    ("FAULT", "SWITCH ON DISABLED"): 15,
}

# Bits that count for a command, by the controlword python-canopen sends for it (CiA 402, table of
# the controlword). Not in its table: quick stop of a drive without power, transitions 7 and 10.
CARE = {0x00: 0x82, 0x02: 0x86, 0x06: 0x87, 0x07: 0x87, 0x0F: 0x8F}
DISABLE_OPERATION = 0x8F


def asked(state: str, word: int, edge: bool) -> set[str]:
    """States that the table of python-canopen leads to with this controlword."""
    found = set()
    for (before, after), command in State402.TRANSITIONTABLE.items():
        if before != state:
            continue
        if command == State402.CW_SWITCH_ON_DISABLED:
            if edge:
                found.add(after)
            continue
        if (before, after) in (("NOT READY TO SWITCH ON", "SWITCH ON DISABLED"),):
            found.add(after)
            continue
        if before == "FAULT REACTION ACTIVE":
            continue
        care = CARE[command]
        if (before, after) == ("OPERATION ENABLED", "SWITCHED ON"):
            care = DISABLE_OPERATION
        if word & care == command & care:
            found.add(after)
    if state in ("READY TO SWITCH ON", "SWITCHED ON") and word & 0x86 == QUICK_STOP:
        found.add("SWITCH ON DISABLED")
    if state == "SWITCHED ON" and "OPERATION ENABLED" in found:
        found.discard("SWITCHED ON")
    return found


def random_controlwords(words: int, seed: int) -> set[tuple[str, str]]:
    """Compare each step of the five axes with the table; the transitions that were seen."""
    rng = random.Random(seed)
    drives = Drives()
    for n in range(AXES):
        drives.put(0x605A + 0x800 * n, 0, 6)  # stays in quick stop active
    common = [0, 2, 6, 7, 0xF, 0x80, 0x8F]
    states = [drives.state(n) for n in range(AXES)]
    before = [0] * AXES
    seen = set()
    for count in range(words // AXES):
        words_now, faults = [], []
        for n in range(AXES):
            word = rng.choice(common) if rng.random() < 0.6 else rng.randrange(0x10000)
            words_now.append(word & ~0x100)  # halt is no transition
            faults.append(rng.random() < 0.02)
            drives.set(n, control=words_now[n])
            drives.feedback.axis[n].fault = 0x5441 if faults[n] else 0
        drives.step()
        inputs = drives.inputs()
        for n in range(AXES):
            now, word = state_of(inputs[0x6041 + 0x800 * n, 0]), words_now[n]
            edge = bool(word & 0x80 and not before[n] & 0x80)
            context = f"seed {seed}, step {count}, axis {n}: {states[n]} {word:04x} -> {now}"
            if states[n] == "FAULT REACTION ACTIVE":
                assert now == "FAULT", context
            elif faults[n] and states[n] == "FAULT":
                assert now == "FAULT", context  # no reset while the cause lasts
            elif faults[n]:
                # Without power the reaction has nothing to stop: 13 and 14 in one step.
                powered = states[n] in ("OPERATION ENABLED", "QUICK STOP ACTIVE")
                powered = powered or "OPERATION ENABLED" in asked(states[n], word, edge)
                assert now == "FAULT" or powered and now == "FAULT REACTION ACTIVE", context
            else:
                wanted = asked(states[n], word, edge)
                assert len(wanted) <= 1, (context, wanted)
                assert now == (wanted.pop() if wanted else states[n]), context
            if now != states[n]:
                seen.add((states[n], now))
            states[n], before[n] = now, word
    return seen


def test_random_controlwords__agree_with_the_table_of_canopen():
    seen = random_controlwords(10_000, 17)
    assert set(NUMBERS) == set(State402.TRANSITIONTABLE)
    # 0, 1 and 13, 14 of a drive with power: the tests below.
    missing = {n for edge, n in NUMBERS.items() if edge not in seen} - {0, 1, 14}
    assert not missing


@pytest.mark.full
def test_random_controlwords__hundred_thousand():
    random_controlwords(100_000, 2)


def transitions_one_by_one() -> set[int]:
    """Walk through all transitions of CiA 402; the numbers of those that the statuswords showed."""
    host = Host()
    host.to_safeop()
    states = [state_of(host.inputs()[0x6041, 0])]  # before the first cycle
    host.cycle()
    states.append(state_of(host.inputs()[0x6041, 0]))
    drives = Drives()
    drives.put(0x605A, 0, 6)
    drives.put(0x6085, 0, 1_000_000)
    path = [
        SHUTDOWN, SWITCH_ON, ENABLE, SWITCH_ON, SHUTDOWN, 0, SHUTDOWN, SWITCH_ON, ENABLE,
        SHUTDOWN, SWITCH_ON, 0, SHUTDOWN, SWITCH_ON, ENABLE, 0, SHUTDOWN, SWITCH_ON, ENABLE,
        QUICK_STOP, ENABLE, QUICK_STOP, 0, SHUTDOWN, SWITCH_ON, ENABLE,
    ]  # fmt: skip
    for control in path:
        drives.set(control=control)
        drives.step()
        states.append(drives.state())
    drives.set(velocity=1_000_000, mode=CSV)
    drives.idle(100)
    drives.feedback.axis[0].fault = 0x5441
    drives.step()
    states.append(drives.state())  # fault while it moves
    drives.feedback.axis[0].fault = 0
    drives.idle(12_000)
    states.append(drives.state())
    drives.set(control=RESET)
    drives.step()
    states.append(drives.state())
    faulted = {(state, "FAULT REACTION ACTIVE"): 13 for state in states}  # not in canopen's table
    return {(NUMBERS | faulted)[edge] for edge in itertools.pairwise(states)}


def test_all_sixteen_transitions__one_by_one():
    assert transitions_one_by_one() == set(range(1, 17))


def test_node_of_canopen__brings_the_axis_to_every_state():
    host = Host()
    host.to_op()
    host.put(0x10F1, 2, 0)
    host.put(0x605A, 0, 6)

    class Line:
        def send_message(self, can_id, data, remote=False):
            answer = host.coe(2, bytes(data))
            host.outputs({(0x6040, 0): int(host.get(0x6040))})
            host.cycle()
            node.sdo.on_response(0x581, bytearray(answer[:8]), 0.0)

    od = objectdictionary.ObjectDictionary()
    for index, kind in ((0x6040, 6), (0x6041, 6), (0x6060, 2), (0x6061, 2)):
        variable = objectdictionary.ODVariable(str(index), index)
        variable.data_type = kind
        od.add_object(variable)
    node = BaseNode402(1, od)
    assert isinstance(node.sdo, SdoClient)
    node.sdo.network = Line()
    for state in (
        "READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED", "QUICK STOP ACTIVE",
        "OPERATION ENABLED", "SWITCHED ON", "SWITCH ON DISABLED",
    ):  # fmt: skip
        node.state = state
        assert node.state == state


def test_controlword__outside_of_op_moves_nothing():
    host = Host()
    host.to_preop()
    for control in (SHUTDOWN, SWITCH_ON, ENABLE):
        host.put(0x6040, 0, control)
        host.cycle(3)
    assert state_of(int(host.get(0x6041))) == "SWITCH ON DISABLED"
    assert not host.command.axis[0].power


# -------------------------------------------------------------------- cyclic modes


def master_path(count: int) -> np.ndarray:
    """Targets of a smooth path that starts and ends at rest, whole increments."""
    t = np.arange(count) / count
    return np.rint(2e6 * np.sin(math.pi * t) ** 4 * np.cos(7 * t)).astype(int)


def run_csp(drives: Drives, targets: np.ndarray, period: int) -> np.ndarray:
    """Position, velocity and acceleration of the set-point in each control cycle."""
    rows = []
    for target in targets:
        drives.set(position=int(target))
        drives.outputs(drives.values)
        for _ in range(period):
            drives.cycle()
            axis = drives.command.axis[0]
            rows.append((axis.position + axis.fraction, axis.velocity, axis.acceleration))
    return np.array(rows, float)


@pytest.mark.parametrize("period", [10, 20, 5, 1])
def test_csp__runs_the_quintic_of_scipy_and_its_acceleration_is_continuous(period):
    drives = Drives()
    drives.put(0x60C2, 1, period)
    drives.put(0x60C2, 2, -4)
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.enable()
    drives.idle(10)
    drives.set(control=0)
    drives.step()
    drives.enable()
    drives.cycle(period - 1)
    targets = master_path(200)
    rows = run_csp(drives, targets, period)
    h = period * TICK
    p = np.concatenate([np.zeros(4), targets])
    v = (p[2:] - p[:-2]) / (2 * h)
    a = (p[2:] - 2 * p[1:-1] + p[:-2]) / h**2
    knots = h * np.arange(1, len(p) - 1)
    curve = BPoly.from_derivatives(knots, np.column_stack([p[1:-1], v, a]))
    # A target that comes at tick k is reached 2.5 periods later; the tick is set at its end.
    ticks = np.arange(len(rows))
    half = 0.5 * h
    times = 4 * h + (ticks + 1) * TICK - 2 * h - half
    use = (times > knots[0]) & (times < knots[-1])
    for order, bound in ((0, 0.2), (1, 100.0), (2, 3e5)):
        wanted = curve.derivative(order)(times[use]) if order else curve(times[use])
        scale = np.abs(wanted).max()
        error = np.abs(rows[use, order] - wanted).max()
        assert error < max(bound * (10 / period) ** order * 0.1, 2e-6 * scale), (
            order,
            error,
            scale,
        )
    # Continuous: no step of the acceleration beyond what the jerk of the quintic gives in a tick.
    jerk = np.abs(np.diff(p, 3)).max() / h**3
    assert np.abs(np.diff(rows[:, 2])).max() <= 9.1 * jerk * TICK


def test_csp__a_late_and_a_lost_target_do_not_stop_the_motion():
    drives = Drives()
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.enable()
    speeds = []
    rng = random.Random(3)
    arrivals = {10 * k + rng.randrange(-2, 3): k for k in range(1, 400) if k % 50}
    for tick in range(4000):
        if tick in arrivals:
            drives.set(position=1000 * arrivals[tick])
            drives.outputs(drives.values)
        drives.cycle()
        speeds.append(drives.command.axis[0].velocity)
    steady = np.array(speeds[200:]) * 1e-3
    assert steady.min() > 990 and steady.max() < 1010  # increments a period
    assert drives.get(0x1C32, 11) >= 7


def test_csp__a_clock_that_runs_away_is_followed():
    """A master 1000 ppm fast: the phase does not slip over a target."""
    drives = Drives()
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.put(0x10F1, 2, 0)
    drives.enable()
    speeds, arrival = [], 0.0
    for k in range(2000):
        drives.set(position=1000 * k)
        drives.outputs(drives.values)
        arrival += 10 * (1 - 1e-3)
        while len(speeds) < arrival:
            drives.cycle()
            speeds.append(drives.command.axis[0].velocity)
    steady = np.array(speeds[200:]) * 1e-3
    assert 990 < steady.min() and steady.max() < 1010


def test_csp__offsets_are_feed_forward_and_limits_hold():
    drives = Drives()
    drives.put(0x607D, 1, -500)
    drives.put(0x607D, 2, 500)
    drives.enable()
    drives.set(position=400, velocity_offset=12345, torque_offset=-77)
    drives.idle(60)
    axis = drives.command.axis[0]
    assert (axis.position, axis.velocity, axis.torque) == (400, 12345.0, -77)
    assert not drives.statusword() & 0x0800
    drives.set(position=2000)
    drives.idle(60)
    assert drives.command.axis[0].position == 500
    assert drives.statusword() & 0x1800 == 0x1800


def test_csv__integrates_the_target_with_continuous_acceleration():
    drives = Drives(CSV)
    drives.enable(velocity=0)
    rows = []
    for k in range(300):
        target = int(1e6 * math.sin(k / 40) ** 3)
        drives.set(velocity=target, velocity_offset=1000)
        drives.outputs(drives.values)
        for _ in range(10):
            drives.cycle()
            axis = drives.command.axis[0]
            rows.append((axis.position + axis.fraction, axis.velocity, axis.acceleration))
    x, v, a = np.array(rows).T
    assert np.abs(v[25:-25:10] - np.interp(np.arange(25, 2975, 10) - 25, np.arange(0, 3000, 10),
        [1e6 * math.sin(k / 40) ** 3 + 1000 for k in range(300)])).max() < 3e4  # fmt: skip
    assert np.abs(np.diff(x)[100:] / TICK - (v[101:] + v[100:-1]) / 2).max() < 30
    assert np.abs(np.diff(v)[100:] / TICK - (a[101:] + a[100:-1]) / 2).max() < 2e4
    assert np.abs(np.diff(a)[100:]).max() < 2e6


def test_cst__gives_torque_within_the_limit_and_no_position():
    drives = Drives(CST)
    drives.put(0x6072, 0, 400)
    drives.enable(torque=250, torque_offset=-50)
    axis = drives.command.axis[0]
    assert (axis.torque, axis.torque_only, axis.power) == (200, True, True)
    for torque, wanted in ((32767, 400), (-32768, -400)):
        drives.set(torque=torque)
        drives.step()
        assert drives.command.axis[0].torque == wanted and drives.statusword() & 0x0800


def test_mode__is_shown_and_a_wrong_one_is_not_taken():
    drives = Drives()
    drives.enable()
    for mode in (CSV, CST, PP, HOMING, CSP, 0):
        drives.set(mode=mode)
        drives.step()
        assert drives.inputs()[0x6061, 0] == mode
        drives.set(mode=7)
        drives.step()
        assert drives.inputs()[0x6061, 0] == mode


def test_change_of_mode_in_motion__no_jump():
    drives = Drives(CSV)
    drives.enable(velocity=2_000_000)
    drives.idle(200)
    before = drives.command.axis[0]
    x, v = before.position + before.fraction, before.velocity
    drives.set(mode=CSP, position=round(x + 2_000_000 * 1.5e-3))  # the one before the first
    for _ in range(40):
        drives.set(position=drives.values[0x607A, 0] + 2000)
        drives.step(10)
        axis = drives.command.axis[0]
        assert abs(axis.position + axis.fraction - x - v * 10 * TICK) < 600
        x, v = axis.position + axis.fraction, axis.velocity
        assert abs(v - 2_000_000) < 500_000
    drives.set(mode=PP)
    drives.step()
    assert abs(drives.command.axis[0].velocity - v) <= 1e8 * TICK * 1.01


# -------------------------------------------------------------------- homing, profile position


@pytest.mark.parametrize("method", [35, 37])
def test_homing__the_present_position_becomes_the_home_offset(method):
    drives = Drives(HOMING)
    drives.feedback.axis[0].position = 123_456
    drives.put(0x607C, 0, -1000)
    drives.put(0x6098, 0, method)
    drives.enable()
    assert drives.statusword() & 0x1000 == 0
    drives.set(control=ENABLE | 0x10)
    drives.step(2)
    assert drives.statusword() & 0x3400 == 0x1400
    assert drives.inputs()[0x6064, 0] == -1000
    assert drives.command.axis[0].position == 123_456  # nothing moves
    drives.set(mode=CSP, position=-1000, control=ENABLE)
    drives.idle(100)
    assert drives.command.axis[0].position == 123_456
    drives.set(position=-900)
    drives.idle(100)
    assert drives.command.axis[0].position == 123_556


def follow(drives: Drives, cycles: int) -> np.ndarray:
    rows = []
    for n in range(cycles):
        if n % 10 == 0:
            drives.outputs(drives.values)
        drives.cycle()
        axis = drives.command.axis[0]
        rows.append((axis.position + axis.fraction, axis.velocity, axis.acceleration))
    return np.array(rows)


def duration_of_ruckig(x, v, a, target, limits) -> float:
    """In units that suit its tolerances; its limits a little wider than the state at its start."""
    x, v, a, target = (value * 1e-6 for value in (x, v, a, target))
    limits = [limit * 1e-6 for limit in limits]
    otg, given = Ruckig(1), InputParameter(1)
    given.current_position, given.current_velocity = [x], [v]
    given.current_acceleration, given.target_position = [a], [target]
    given.max_velocity, given.max_acceleration = [limits[0]], [limits[1] * (1 + 1e-6)]
    given.max_jerk = [limits[2]]
    found = Trajectory(1)
    assert otg.calculate(given, found) in (Result.Working, Result.Finished)
    return found.duration


def pp_drives(velocity: int, acceleration: int, jerk: int) -> Drives:
    drives = Drives(PP)
    drives.put(0x6081, 0, velocity)
    drives.put(0x6083, 0, acceleration)
    drives.put(0x60A4, 1, jerk // 1000)
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.enable()
    return drives


@pytest.mark.parametrize(
    ("length", "velocity", "acceleration", "jerk"),
    [
        (3_000_000, 5_000_000, 100_000_000, 10_000_000_000),
        (-3_000_000, 5_000_000, 100_000_000, 10_000_000_000),
        (400_000, 5_000_000, 100_000_000, 10_000_000_000),
        (20_000, 5_000_000, 100_000_000, 10_000_000_000),
        (1, 5_000_000, 100_000_000, 10_000_000_000),
        (5_000_000, 2_000_000, 400_000_000, 2_000_000_000),
        (100_000_000, 50_000_000, 400_000_000, 100_000_000_000),
    ],
)
def test_profile_position__in_the_time_of_ruckig_within_the_limits(
    length, velocity, acceleration, jerk
):
    drives = pp_drives(velocity, acceleration, jerk)
    drives.set(position=length, control=ENABLE | 0x10)
    wanted = duration_of_ruckig(0, 0, 0, length, (velocity, acceleration, jerk))
    rows = follow(drives, round(wanted / TICK) + 60)
    assert drives.statusword() & 0x1400 == 0x1400 and rows[-1, 0] == length
    moving = np.nonzero(rows[:, 0] != rows[-1, 0])[0][-1] + 2 - PLANNING
    creep = (6 / jerk) ** (1 / 3)  # the last increment, which binary32 rounds away, takes as long
    assert -creep - 3 * TICK - 1e-4 * wanted < moving * TICK - wanted < 3 * TICK + 1e-4 * wanted
    assert np.abs(rows[:, 1]).max() <= velocity * (1 + 1e-5)
    assert np.abs(rows[:, 2]).max() <= acceleration * (1 + 1e-5)
    assert np.abs(np.diff(rows[:, 2])).max() <= jerk * TICK * 1.001
    step = np.abs(np.diff(rows[:, 0]) - (rows[1:, 1] + rows[:-1, 1]) / 2 * TICK)
    assert step.max() <= jerk * TICK**3 + 2e-7 * abs(length) + 0.02


def test_profile_position__new_targets_in_motion():
    """At once (bit 5) in motion: no jump, in about the time of Ruckig from that state."""
    rng = random.Random(11)
    limits = (5_000_000, 100_000_000, 10_000_000_000)
    for _ in range(12):
        drives = pp_drives(*limits)
        first, second = rng.randrange(-(10**6), 10**6), rng.randrange(-(10**6), 10**6)
        drives.set(position=first, control=ENABLE | 0x10)
        rows = follow(drives, rng.randrange(50, 1500))
        drives.set(control=ENABLE)
        rows = np.vstack([rows, follow(drives, 10)])
        drives.set(position=second, control=ENABLE | 0x30)
        rows = np.vstack([rows, follow(drives, PLANNING)])
        wanted = duration_of_ruckig(*rows[-1], second, limits)
        rest = follow(drives, round(wanted / TICK * 1.3) + 100)
        rows = np.vstack([rows, rest])
        assert rows[-1, 0] == second
        took = (np.nonzero(rest[:, 0] != second)[0][-1] + 2) * TICK if rest[0, 0] != second else 0
        creep = (6 / limits[2]) ** (1 / 3)
        assert wanted - 3 * TICK - creep <= took <= wanted * 1.02 + 15 * TICK, (first, second)
        assert np.abs(rows[:, 1]).max() <= limits[0] * (1 + 1e-4)
        assert np.abs(rows[:, 2]).max() <= limits[1] * (1 + 1e-4)
        assert np.abs(np.diff(rows[:, 2])).max() <= limits[2] * TICK * 1.05


def test_profile_position__targets_one_after_the_other_and_relative():
    drives = pp_drives(5_000_000, 100_000_000, 10_000_000_000)
    drives.set(position=100_000, control=ENABLE | 0x10)
    follow(drives, 20)
    assert drives.statusword() & 0x1000
    drives.set(control=ENABLE)
    follow(drives, 20)
    assert not drives.statusword() & 0x1400  # free for the next, not there yet
    drives.set(position=-30_000, control=ENABLE | 0x50)  # relative to the first, which goes on
    follow(drives, 20)
    drives.set(control=ENABLE)
    rows = follow(drives, 3000)
    assert rows[:, 0].max() == 100_000 and rows[-1, 0] == 70_000
    assert drives.statusword() & 0x1400 == 0x0400


def test_profile_position__axes_plan_one_after_the_other_and_none_waits_for_a_dead_one():
    drives = Drives(PP)
    for n in range(AXES):
        drives.put(0x6065 + 0x800 * n, 0, 0xFFFFFFFF)
        drives.enable(n)
    for n in range(AXES):
        drives.set(n, position=100_000 * (n + 1), control=ENABLE | 0x10)
    drives.outputs(drives.values)
    began = {}
    for cycle in range(6 * PLANNING):
        if cycle == 10:  # the first one faults while it plans
            drives.feedback.axis[0].fault = 0x5441
        drives.cycle()
        for n in range(AXES):
            if drives.command.axis[n].velocity:
                began.setdefault(n, cycle)
    assert list(began) == [1, 2, 3, 4]
    starts = list(began.values())
    assert 10 + PLANNING <= starts[0] <= 12 + PLANNING
    assert all(PLANNING - 1 <= b - a <= PLANNING for a, b in zip(starts, starts[1:], strict=False))
    drives.idle(2000)
    assert [drives.inputs()[0x6064 + 0x800 * n, 0] for n in range(AXES)] == [
        0, 200_000, 300_000, 400_000, 500_000,
    ]  # fmt: skip


def test_profile_position__target_that_comes_while_one_is_planned():
    drives = pp_drives(5_000_000, 100_000_000, 10_000_000_000)
    drives.set(position=1_000_000, control=ENABLE | 0x30)
    follow(drives, 10)
    drives.set(control=ENABLE | 0x20)
    follow(drives, 2)
    drives.set(position=-50_000, control=ENABLE | 0x30)
    rows = follow(drives, 6000)
    assert rows[-1, 0] == -50_000
    assert np.abs(np.diff(rows[:, 0])).max() <= 5_000_000 * TICK * 1.001


def test_halt__stops_on_the_ramp():
    drives = pp_drives(5_000_000, 100_000_000, 10_000_000_000)
    drives.set(position=3_000_000, control=ENABLE | 0x10)
    follow(drives, 1500)
    drives.set(control=ENABLE | 0x100)
    rows = follow(drives, 800)
    assert rows[-1, 1] == 0 and rows[-1, 0] < 3_000_000
    assert np.diff(rows[:, 1]).min() >= -100_000_000 * TICK * 1.01
    assert drives.statusword() & 0x0400 and drives.state() == "OPERATION ENABLED"


def test_halt__target_reached_only_when_it_stands():
    drives = pp_drives(5_000_000, 100_000_000, 10_000_000_000)
    drives.set(position=3_000_000, control=ENABLE | 0x10)
    follow(drives, 1500)
    drives.set(control=ENABLE | 0x100)
    drives.step()
    seen = 0
    while drives.command.axis[0].velocity:
        assert not drives.statusword() & 0x0400, drives.command.axis[0].velocity
        drives.step()
        seen += 1
    assert seen > 100
    drives.step()
    assert drives.statusword() & 0x0400


class Mapped(Drives):
    """The first axis alone, with profile velocity and acceleration in its process data."""

    def __init__(self, velocity: int, acceleration: int) -> None:
        self.limits = (velocity, acceleration)
        super().__init__(PP)
        self.put(0x6065, 0, 0xFFFFFFFF)
        self.enable()

    def process_managers(self, outputs: int = 0, inputs: int = 0) -> None:
        self.put(0x1C12, 0, 0)
        self.put(0x1600, 0, 0)
        entries = (0x60400010, 0x60600008, 8, 0x607A0020, 0x60810020, 0x60830020)
        for n, entry in enumerate(entries):
            self.put(0x1600, n + 1, entry)
        self.put(0x1600, 0, len(entries))
        self.put(0x1C12, 1, 0x1600)
        self.put(0x1C12, 0, 1)
        super().process_managers(outputs=16)

    def outputs(self, values=None) -> None:
        values = values or {}
        words = [values.get((index, 0), 0) for index in (0x6040, 0x6060, 0x607A)]
        self.write(0x1200, struct.pack("<HbxiII", *words, *self.limits))


@pytest.mark.parametrize(("velocity", "acceleration"), [(0, 100_000_000), (5_000_000, 0), (0, 0)])
def test_mapped_limits_of_0__are_held_at_1_and_nothing_jumps(velocity, acceleration):
    drives = Mapped(velocity, acceleration)
    assert drives.get(0x6081) == max(1, velocity) and drives.get(0x6083) == max(1, acceleration)
    drives.set(position=1_000_000, control=ENABLE | 0x10)
    rows = follow(drives, 3000)
    assert np.abs(rows[:, 1]).max() <= max(1, velocity) and np.abs(np.diff(rows[:, 0])).max() < 2
    assert 0 < rows[-1, 0] < 2
    drives.limits = (5_000_000, 100_000_000)
    drives.set(position=100, control=ENABLE)
    drives.step()
    drives.set(control=ENABLE | 0x30)
    assert follow(drives, 3000)[-1, 0] == 100


@pytest.mark.parametrize("way", ["halt", "quick stop", "fault"])
def test_mapped_acceleration_of_0__every_ramp_ends(way):
    drives = Mapped(10, 100_000_000)
    drives.put(0x605A, 0, 1)
    drives.put(0x605E, 0, 1)
    drives.set(position=1_000_000, control=ENABLE | 0x10)
    follow(drives, 1000)
    assert drives.command.axis[0].velocity == 10
    drives.limits = (10, 0)
    drives.set(control={"halt": ENABLE | 0x100, "quick stop": QUICK_STOP, "fault": ENABLE}[way])
    drives.feedback.axis[0].fault = 0x5441 if way == "fault" else 0
    follow(drives, 9 * 10_000)
    assert drives.command.axis[0].velocity > 0
    follow(drives, 2 * 10_000)
    assert drives.command.axis[0].velocity == 0
    assert drives.command.axis[0].power == (way == "halt")


# -------------------------------------------------------------------- faults, stops, I/O


def moving(option: int, value: int, velocity: int = 4_000_000) -> Drives:
    drives = Drives(CSV)
    drives.put(option, 0, value)
    drives.enable(velocity=velocity)
    drives.idle(200)
    assert abs(drives.command.axis[0].velocity - velocity) < 1
    return drives


@pytest.mark.parametrize(
    ("option", "control", "value", "deceleration", "end"),
    [
        (0x605A, QUICK_STOP, 0, None, "SWITCH ON DISABLED"),
        (0x605A, QUICK_STOP, 1, 1e8, "SWITCH ON DISABLED"),
        (0x605A, QUICK_STOP, 2, 4e8, "SWITCH ON DISABLED"),
        (0x605A, QUICK_STOP, 5, 1e8, "QUICK STOP ACTIVE"),
        (0x605A, QUICK_STOP, 6, 4e8, "QUICK STOP ACTIVE"),
        (0x605B, SHUTDOWN, 0, None, "READY TO SWITCH ON"),
        (0x605B, SHUTDOWN, 1, 1e8, "READY TO SWITCH ON"),
        (0x605C, SWITCH_ON, 0, None, "SWITCHED ON"),
        (0x605C, SWITCH_ON, 1, 1e8, "SWITCHED ON"),
        (0x605E, None, 0, None, "FAULT"),
        (0x605E, None, 1, 1e8, "FAULT"),
        (0x605E, None, 2, 4e8, "FAULT"),
    ],
)
def test_stop__on_the_ramp_of_its_option_then_without_power(
    option, control, value, deceleration, end
):
    drives = moving(option, value)
    if control is None:
        drives.feedback.axis[0].fault = 0x5441
    else:
        drives.set(control=control)
    drives.outputs(drives.values)
    speeds = []
    for _ in range(600):
        drives.cycle()
        if drives.command.axis[0].power:
            speeds.append(drives.command.axis[0].velocity)
        drives.feedback.axis[0].fault = 0
        drives.outputs(drives.values)
    assert drives.state() == end
    if deceleration is None:
        assert len(speeds) <= 2
    else:
        ticks = 4_000_000 / (deceleration * TICK)
        steps = -np.diff(speeds)[1:]
        assert np.abs(steps[: int(ticks) - 3] - deceleration * TICK).max() < 1
        if end != "QUICK STOP ACTIVE":
            assert abs(len(speeds) - ticks) < 4
    assert drives.command.axis[0].power == (end == "QUICK STOP ACTIVE")


def test_following_error__faults_after_its_time_out_with_code_and_emergency():
    drives = Drives()
    drives.put(0x6065, 0, 1000)
    drives.put(0x6066, 0, 5)
    drives.enable()
    drives.held.add(0)
    for k in range(100):
        drives.set(position=min(20 * k, 1100))
        drives.step(10)
        if drives.state() == "FAULT":
            break
    assert drives.state() == "FAULT"
    inputs = drives.inputs()
    assert inputs[0x603F, 0] == 0x8611 and abs(inputs[0x60F4, 0]) <= 1100
    assert all(drives.state(n) != "FAULT" for n in range(1, AXES))
    kind, data = drives.receive()
    assert data[2:4] == b"\x11\x86" and data[5] == 0
    drives.set(control=RESET)
    drives.step(2)
    assert drives.inputs()[0x603F, 0] == 0 and drives.upload(0x1001) == b"\0"


def test_master_that_dies__watchdog_quick_stop_fault_outputs_to_their_error_value():
    drives = Drives(CSV)
    drives.put(0x10F1, 2, 0)
    drives.put(0x8A07, 1, 0x5A)
    for n in range(AXES):
        drives.enable(n, velocity=3_000_000)
    drives.values[0x8A00, 1] = 0xFF
    drives.idle(100)
    assert drives.command.digital_outputs == 0xFF
    speeds = []
    for _ in range(1300):
        drives.cycle()
        speeds.append(drives.command.axis[4].velocity)
    assert drives.status == (SAFEOP | ERROR, 0x001B)
    for n in range(AXES):
        assert drives.state(n) == "FAULT" and not drives.command.axis[n].power
        assert drives.inputs()[0x603F + 0x800 * n, 0] == 0x7500
    assert drives.command.digital_outputs == 0x5A
    assert 0 in speeds and np.diff(speeds).min() >= -4e8 * TICK * 1.01  # the quick stop ramp
    # The way back: acknowledge, OP, reset of the fault.
    drives.set(control=RESET)
    drives.outputs(drives.values)
    drives.cycle()
    assert drives.ask(OP | ERROR) == (OP, 0)
    drives.set(control=0)
    drives.step()
    drives.set(control=RESET)
    drives.step()
    assert drives.state() == "SWITCH ON DISABLED"


def test_lost_outputs__fault_before_the_watchdog_when_the_limit_says_so():
    drives = Drives()
    drives.put(0x10F1, 2, 4)
    drives.enable()
    drives.idle(100)
    drives.cycle(35)
    assert drives.state() == "OPERATION ENABLED"
    drives.cycle(25)
    assert drives.state() == "FAULT" and drives.status == (SAFEOP | ERROR, 0x001A)
    assert drives.inputs()[0x603F, 0] == 0x7500 and drives.get(0x1C32, 32) == 1


def test_op_left_on_request__quick_stop_without_a_fault():
    drives = moving(0x605A, 2)
    assert drives.ask(SAFEOP) == (SAFEOP, 0)
    rows = []
    for _ in range(200):
        drives.cycle()
        rows.append((drives.command.axis[0].velocity, drives.command.axis[0].power))
    assert rows[0][1] and not rows[-1][1]
    assert state_of(drives.inputs()[0x6041, 0]) == "SWITCH ON DISABLED"
    assert np.diff([v for v, _ in rows]).min() >= -4e8 * TICK * 1.01


@pytest.mark.parametrize("option", [0, 1, 2, 5, 6])
@pytest.mark.parametrize("state", [SAFEOP, PREOP])
def test_op_left__no_torque_after_the_stop_whatever_the_option(option, state):
    drives = moving(0x605A, option)
    assert drives.ask(state) == (state, 0)
    drives.cycle(500)
    assert not drives.command.axis[0].power
    assert state_of(int(drives.get(0x6041))) == "SWITCH ON DISABLED"


def test_inputs_and_outputs_of_the_device__in_the_axes_too():
    drives = Drives()
    drives.feedback.digital_inputs = 0xA5
    drives.values[0x8A00, 1] = 0x0F
    drives.step(2)
    assert drives.command.digital_outputs == 0x0F
    assert [drives.get(0x60FD + 0x800 * n) for n in range(AXES)] == [0xA50000] * AXES
    drives.put(0x70FE, 1, 0x12_0000)
    drives.step()
    assert drives.command.digital_outputs == 0x0F  # not in the mask
    drives.put(0x70FE, 2, 0x33_0001)
    drives.step()
    assert drives.command.digital_outputs == 0x1E
    drives.put(0x8A07, 1, 0x40)
    drives.ask(SAFEOP)
    drives.cycle()
    assert drives.command.digital_outputs == 0x40


def test_digital_inputs_and_outputs__eight_each_and_pose():
    drives = Drives()
    for value in (0x00, 0xA5, 0xFF):
        drives.values[0x8A00, 1] = value
        drives.feedback.digital_inputs = value ^ 0x3C
        drives.step()
        assert drives.command.digital_outputs == value
        assert drives.inputs()[0x8800, 1] == value ^ 0x3C
    drives.feedback.pose[2] = 0.25
    drives.step()
    assert drives.get(0x2010, 3) == 0.25


def test_gain_of_the_law__goes_to_the_law_at_once():
    drives = Drives()
    assert drives.command.setting_number == 0
    for n in range(AXES):
        drives.put(0x2001, n + 1, 100.0 + n)
    seen = []
    for _ in range(8):
        drives.step()
        found = drives.command
        seen.append((found.setting_number, found.setting_index, found.setting_subindex,
                     found.setting_value))  # fmt: skip
    assert seen[:5] == [(n + 1, 0x2001, n + 1, 100.0 + n) for n in range(AXES)]
    assert seen[-1] == seen[4]
