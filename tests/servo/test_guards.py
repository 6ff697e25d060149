# SPDX-License-Identifier: Apache-2.0
"""Guards of the current sensors, alone: voltage and current of a phase, sum of three sensors."""

from __future__ import annotations

import numpy as np
import pytest

from tests.bench.seed import SEED
from tests.servo.clocked import Clocked
from tests.servo.test_currents import CLOCKS_PER_BIT, SLOW, modulated, timing

AXES, HALF = 2, 1250
PLAUSIBLE_IN = (
    *("write", "axis", "phase", "value", "current_a", "current_b"),
    *("run", "clear", "voltage", "current", "persist"),
)
LATE = 6  # clocks from the last value of a set to the report
SET = 3  # clocks of a set: the processor's fastest bus


def lost(
    values: np.ndarray, currents: np.ndarray, gap: int = SET, **registers: np.ndarray | int
) -> np.ndarray:
    """lost_o (clocks,) while sets of values (n, 3) with currents (n, 2) come, axis 0 and 1 in turn,
    a set in every `gap` clocks."""
    clocks = gap * len(values) + 12
    given = {
        name: np.zeros(clocks, dtype=np.int64)
        for name in ("write", "axis", "phase", "value", "current_a", "current_b")
    }
    for n, (row, pair) in enumerate(zip(values, currents, strict=True)):
        for phase in range(3):
            clock = gap * n + phase
            given["write"][clock], given["axis"][clock] = 1, n % AXES
            given["phase"][clock], given["value"][clock] = phase, row[phase]
        given["current_a"][clock], given["current_b"][clock] = pair
    block = Clocked("drive_plausible", PLAUSIBLE_IN, ("lost",), {"Axes": AXES})
    return block.run(clocks, **given, **registers)["lost"]


def odd(values: np.ndarray, currents: np.ndarray, voltage: int, current: int) -> np.ndarray:
    """Sets (n,) of which a phase has a large voltage and a small current."""
    volts = np.abs(3 * values - values.sum(axis=1, keepdims=True))
    amps = np.abs(np.column_stack([currents, -currents.sum(axis=1)]))
    return ((volts >= voltage) & (amps < current)).any(axis=1)


@pytest.mark.parametrize("gap", [SET, 15])
def test_plausible__random_values_and_currents_as_the_model(gap):
    draw = np.random.default_rng([SEED, gap])
    sets, voltage, current, persist = 3000, (700, 900), 2000, 4
    values = draw.integers(0, HALF + 1, (sets, 3))
    currents = np.where(
        draw.random((sets, 2)) < 0.6, 0, draw.choice([-1, 1], (sets, 2)) * 2000
    ) + draw.integers(-1999, 2000, (sets, 2)) * (draw.random((sets, 2)) < 0.3)
    found = lost(
        values,
        currents,
        gap,
        run=3,
        voltage=voltage[1] << 14 | voltage[0],
        current=current,
        persist=persist,
    )
    firsts = []
    for axis in range(AXES):
        row = odd(values[axis::AXES], currents[axis::AXES], voltage[axis], current)
        ends = [n for n in range(len(row)) if row[max(0, n - persist + 1) : n + 1].sum() == persist]
        firsts.append(gap * (AXES * ends[0] + axis) + 2 + LATE)
        assert 0.1 < row.mean() < 0.9
    rises = [int(np.flatnonzero(found >> axis & 1)[0]) for axis in range(AXES)]
    assert rises == firsts


@pytest.mark.parametrize("phase", [0, 1, 2])
@pytest.mark.parametrize("sign", [1, -1])
def test_plausible__each_phase_either_way_and_its_limits_are_exact(phase, sign):
    sets, voltage = 20, 600
    others = np.roll(np.eye(3, dtype=np.int64), 1, axis=1)[phase]
    values = np.full((sets, 3), 600)
    values[:, phase] += sign * 300  # 2 * 300 against the others
    flows = {0: (0, 1), 1: (1, 0), 2: (1, -1)}[phase]  # none in the phase
    currents = np.tile(np.array(flows) * 5000, (sets, 1))
    registers = {"run": 3, "current": 100, "persist": 3}
    at = [voltage << 14 | voltage, (voltage + 1) << 14 | voltage + 1]
    assert lost(values, currents, voltage=at[0], **registers)[-1] == 3
    assert not lost(values, currents, voltage=at[1], **registers).any()
    assert not lost(values, currents, voltage=0, **registers).any(), "0: never"
    enough = currents + np.array({0: (100, 0), 1: (0, 100), 2: (100, 0)}[phase])
    assert not lost(values, enough, voltage=at[0], **registers).any()
    fewer = currents + np.array({0: (99, 0), 1: (0, 99), 2: (99, 0)}[phase])
    assert lost(values, fewer, voltage=at[0], **registers)[-1] == 3
    assert others.sum() == 1


def test_plausible__counts_without_a_break_while_the_axis_runs():
    sets = 60
    values, currents = np.tile([1200, 600, 600], (sets, 1)), np.zeros((sets, 2), dtype=np.int64)
    limit = {"voltage": 900 << 14 | 900, "current": 100}
    clocks = np.arange(SET * sets + 12)
    assert not lost(values, currents, run=3, persist=0, **limit).any()
    assert lost(values, currents, run=2, persist=5, **limit)[-1] == 2
    broken = values.copy()
    broken[8::10] = broken[9::10] = 600  # of either axis a calm set after four
    assert not lost(broken, currents, run=3, persist=5, **limit).any()
    assert lost(broken, currents, run=3, persist=4, **limit)[-1] == 3
    paused = np.where(clocks // 24 % 2 == 0, 3, 0)  # four sets of each axis, then none
    assert not lost(values, currents, run=paused, persist=5, **limit).any()
    clear = np.where(clocks == 100, 1, 0)
    found = lost(values, currents, run=3, persist=10, clear=clear, **limit)
    assert found[100] == 3 and found[101] == 2 and found[-1] == 3
    calm = values.copy()
    calm[25:] = 600
    assert lost(calm, currents, run=3, persist=10, **limit)[-1] == 3, "the report stays"


# ---------------------------------------------------------------- sum
SUM_IN = ("bit_a", "bit_b", "bit_c", "strobe", "corner", "done", "limit", "clear")
FULL = SLOW**3 // 2


def summed(shares: np.ndarray, limit: int, clear: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """over_o and done_o (clocks,) of currents (3, bits) as shares of full scale."""
    clocks = shares.shape[1] * CLOCKS_PER_BIT
    when = timing(clocks, np.arange(clocks) % 1250 == 7)
    bits = [np.repeat(modulated(row), CLOCKS_PER_BIT) for row in shares]
    block = Clocked("current_sum", SUM_IN, ("over",))
    found = block.run(
        clocks,
        **dict(zip(("bit_a", "bit_b", "bit_c"), bits, strict=True)),
        **{name: when[name] for name in ("strobe", "corner", "done")},
        limit=limit,
        clear=clear,
    )
    return found["over"], when["done"]


def three(bits: int, size: float) -> np.ndarray:
    """Currents (3, bits) of a machine that turns: their sum is 0."""
    angle = 2 * np.pi * (np.arange(bits) / 1500 + np.array([[0], [1 / 3], [2 / 3]]))
    return size * np.cos(angle)


@pytest.mark.parametrize("sensor", [0, 1, 2])
def test_sum__of_a_sensor_that_sticks_or_drifts_is_found_with_the_next_sample(sensor):
    good = three(4000, 0.5)
    assert not summed(good, FULL // 50)[0].any(), "the sum of good sensors is small"
    stuck, at = good.copy(), 2000
    stuck[sensor, at:] = 0
    over, done = summed(stuck, FULL // 50)
    samples = np.flatnonzero(done)
    first = np.flatnonzero(over)[0]
    assert first - 2 in samples and at < first / CLOCKS_PER_BIT < at + 2 * 1250 / CLOCKS_PER_BIT
    drifted = good.copy()
    drifted[sensor, at:] += 0.03
    over, _ = summed(drifted, FULL // 50)
    assert not over[: at * CLOCKS_PER_BIT].any() and over[-1]
    assert not summed(drifted, 0)[0].any(), "0: never"


@pytest.mark.parametrize("ones", [0, 1])
def test_sum__of_full_scale_is_exact_either_way(ones):
    """Bits of one level: three times the full scale."""
    clocks = 10_000
    when = timing(clocks, np.arange(clocks) % 1250 == 7)
    block = Clocked("current_sum", SUM_IN, ("over",))
    given = {name: when[name] for name in ("strobe", "corner", "done")}
    given |= {f"bit_{k}": np.full(clocks, ones) for k in "abc"}
    clear = {"clear": np.where(np.arange(clocks) == 6000, 1, 0)}
    found = block.run(clocks, **given, limit=3 * FULL, **clear)["over"]
    assert found[5999] and not found[6001] and found[-1]
    assert not block.run(clocks, **given, limit=3 * FULL + 1)["over"].any()
