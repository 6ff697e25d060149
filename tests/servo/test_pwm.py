# SPDX-License-Identifier: Apache-2.0
"""PWM: ordered states, dead time, bounds, modes and trip, clock by clock against the contracts."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tests.bench.seed import SEED
from tests.servo.clocked import Clocked

BEHIND = 2  # clocks from the carrier to the gates
LEAST = 12  # dead time that no register undercuts
BRIDGE = ("count", "up", "load", "mode", "dead_time", "write", "phase", "value")
FAULTS = ("commit", "fault", "alarm", "clear")
OFF, BRAKE, RUN = 0, 1, 2


def bridge() -> Clocked:
    return Clocked("pwm_bridge", (*BRIDGE, *FAULTS), ("trip", "high", "low", "ordered"))


def triangle(halves: list[int]) -> dict[str, np.ndarray]:
    """Carrier by definition: up 0 .. h - 1, down h .. 1, load in the last clock of a half."""
    count, up, load = [], [], []
    for number, half in enumerate(halves):
        rising = number % 2 == 0
        count += range(half) if rising else range(half, 0, -1)
        up += [rising] * half
        load += [False] * (half - 1) + [True]
    return {"count": np.array(count), "up": np.array(up), "load": np.array(load)}


def orders(halves: list[int], values: list[int]) -> np.ndarray:
    """Ordered state: each half's value of clocks, at the valley's side of it."""
    parts = []
    for number, (half, value) in enumerate(zip(halves, values, strict=True)):
        on = np.arange(half) < value
        parts.append(on if number % 2 == 0 else on[::-1])
    return np.concatenate(parts)


def written(clocks: int, halves: list[int], values: np.ndarray) -> dict[str, np.ndarray]:
    """Writes and a commit early in each half, of the three values of the next one."""
    columns = {name: np.zeros(clocks, dtype=np.int64) for name in ("write", "phase", "value")}
    commit = np.zeros(clocks, dtype=bool)
    start = 0
    for half, row in zip(halves[:-1], values[1:], strict=True):
        for phase, value in enumerate(row):
            at = start + 5 + 3 * phase
            columns["write"][at], columns["phase"][at], columns["value"][at] = 1, phase, value
        commit[start + 20] = True
        start += half
    return columns | {"commit": commit}


def bits(word: np.ndarray) -> np.ndarray:
    """Rows of the three phases."""
    return (word[:, None] >> np.arange(3) & 1).astype(bool)


def check_dead_time(high: np.ndarray, low: np.ndarray, least: int) -> None:
    """Never both; from one gate to either, `least` clocks of none."""
    assert not (high & low).any()
    on = np.flatnonzero(high | low)
    gaps = np.diff(on) - 1
    changed = high[on][1:] != high[on][:-1]
    assert (gaps[changed] >= least).all()
    assert ((gaps == 0) | (gaps >= least)).all()


def test_carrier__is_the_triangle_of_its_halves_with_one_window_each():
    carrier = Clocked(
        "pwm_carrier", ("half_period", "window_start"), ("count", "up", "load", "window", "half")
    )
    random = np.random.default_rng(SEED)
    halves = [64, *(int(h) for h in random.integers(64, 300, 12)), 64, 4095, 64]
    half_period = np.repeat(halves[1:] + [0], halves)  # requested in the half before
    start = np.repeat(random.integers(0, 320, len(halves)), halves)
    found = carrier.run(sum(halves), half_period=half_period, window_start=start)
    for name, want in triangle(halves).items():
        np.testing.assert_array_equal(found[name], want, err_msg=name)
    np.testing.assert_array_equal(found["half"], np.repeat(halves, halves))
    at = 0
    for half, asked in zip(halves, start[np.cumsum(halves) - 1], strict=True):
        window = found["window"][at : at + half]
        assert np.flatnonzero(window).tolist() == [min(asked, half - 1)]
        at += half


@pytest.mark.parametrize("minimum", [0, 1, 40, 200])
def test_bound__values_near_0_and_the_half_become_them(minimum):
    bound = Clocked("pwm_bound", ("half", "minimum", "value"), ("value",))
    half, value = 150, np.arange(4096)
    found = bound.run(4096, half=half, minimum=minimum, value=value)["value"][1:]
    want = np.where(value < minimum, 0, np.where(value > max(half - minimum, 0), half, value))
    np.testing.assert_array_equal(found[2:], want[2:-1])


def expected_gates(state: np.ndarray, wait: int) -> np.ndarray:
    """(high, low) a clock: the gate of the ordered state, `wait` clocks after the last one on."""
    gates = np.zeros((len(state), 2), dtype=bool)
    last = 0  # clock in which a gate was on
    for now in range(BEHIND, len(state)):
        gate = 0 if state[now - BEHIND] else 1
        if gates[now - 1, gate] or now - last > wait:
            gates[now, gate], last = True, now
    return gates


@pytest.mark.parametrize("dead_time", [0, LEAST, 30])
def test_run__ordered_clocks_are_the_values_and_gates_keep_the_dead_time(dead_time):
    random = np.random.default_rng([SEED, dead_time])
    halves = [int(h) for h in random.integers(64, 200, 40)]
    values = random.integers(0, 220, (40, 3))
    values[random.random((40, 3)) < 0.2] = 0
    values[0] = 0
    clocks = sum(halves)
    inputs = triangle(halves) | written(clocks, halves, values)
    found = bridge().run(clocks, **inputs, mode=RUN, dead_time=dead_time)
    ordered, high, low = (bits(found[name]) for name in ("ordered", "high", "low"))
    for phase in range(3):
        want = orders(halves, values[:, phase].tolist())
        np.testing.assert_array_equal(ordered[1:, phase], want[:-1])
        check_dead_time(high[:, phase], low[:, phase], max(dead_time, LEAST))
        gates = expected_gates(want, max(dead_time, LEAST))
        found_gates = np.stack([high[:, phase], low[:, phase]], axis=1)
        np.testing.assert_array_equal(found_gates[300:], gates[300:])
    assert not found["trip"].any()


def test_values__come_into_force_together_with_the_half_behind_their_commit():
    halves = [100] * 6
    clocks = 600
    columns = {
        name: np.zeros(clocks, dtype=np.int64) for name in ("write", "phase", "value", "commit")
    }
    for phase in range(3):
        at = 110 + phase
        columns["write"][at], columns["phase"][at], columns["value"][at] = 1, phase, 10 + phase
    columns["commit"][310] = 1  # two halves later
    found = bridge().run(clocks, **triangle(halves), **columns, mode=RUN)
    on = bits(found["ordered"])[1:]
    assert not on[:399].any()
    np.testing.assert_array_equal(on[400:500].sum(axis=0), [10, 11, 12])


@pytest.mark.parametrize("mode", [OFF, BRAKE, RUN, 3])
def test_modes__off_brake_and_run(mode):
    halves = [100] * 4
    clocks = 400
    found = bridge().run(clocks, **triangle(halves), mode=mode, dead_time=20)
    assert not found["high"].any()
    low = {OFF: 0, 3: 0, BRAKE: 7, RUN: 7}[mode]  # compare values are 0
    assert (found["low"][300:] == low).all()


def test_mode_and_dead_time_at_random__no_shoot_through():
    random = np.random.default_rng(SEED)
    halves = [int(h) for h in random.integers(64, 90, 200)]
    values = random.integers(0, 100, (200, 3))
    clocks = sum(halves)

    def now_and_then(choices: int, every: int) -> np.ndarray:
        return np.repeat(random.integers(0, choices, clocks // every + 1), every)[:clocks]

    found = bridge().run(
        clocks,
        **triangle(halves),
        **written(clocks, halves, values),
        mode=now_and_then(4, 37),
        dead_time=now_and_then(40, 3),
        fault=random.random(clocks) < 0.001,
        alarm=random.random(clocks) < 0.001,
        clear=random.random(clocks) < 0.01,
    )
    high, low = bits(found["high"]), bits(found["low"])
    for phase in range(3):
        check_dead_time(high[:, phase], low[:, phase], LEAST)
    assert found["trip"].any() and high.any() and low.any()


@pytest.mark.parametrize(
    ("which", "at"), tuple(itertools.product(("fault", "alarm"), range(300, 550, 7)))
)
def test_trip__all_gates_off_behind_the_second_edge_until_cleared(which, at):
    halves = [100] * 12
    clocks = 1200
    values = np.full((12, 3), 60)
    inputs = triangle(halves) | written(clocks, halves, values)
    inputs |= {which: np.arange(clocks) == at, "clear": np.arange(clocks) == 800}
    found = bridge().run(clocks, **inputs, mode=RUN)
    gates = found["high"] | found["low"]
    assert not gates[at + 2 : 801].any() and gates[: at + 1].any() and gates[801:].any()
    assert found["trip"][at + 2 : 801].all() and not found["trip"][801:].any()
    assert not found["trip"][: at + 1].any()


def test_clear__while_the_fault_lasts__keeps_the_trip():
    clocks = 600
    fault = (np.arange(clocks) >= 200) & (np.arange(clocks) < 400)
    clear = np.arange(clocks) % 50 == 0
    found = bridge().run(clocks, **triangle([100] * 6), mode=BRAKE, fault=fault, clear=clear)
    assert found["trip"][202:402].all() and not found["low"][202:402].any()
    assert not found["trip"][460:].any() and found["low"][500:].all()
