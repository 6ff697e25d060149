# SPDX-License-Identifier: Apache-2.0
"""Stamps of encoder counts against the counts themselves; registers of the front-end."""

from __future__ import annotations

import numpy as np
import pytest

from sim.rtl.gen.drive_regmap import REGMAP as DRIVE
from tests.bench.seed import SEED
from tests.servo.clocked import Accesses, Clocked, signed
from tests.servo.test_decoder import LATENCY, journey, lines

AGE_BITS = 5  # of a short age; the module's own is 22


def block(bits: int) -> Clocked:
    return Clocked(
        "quadrature_time", ("position", "sample"), ("position", "stamp"), {"AgeBits": bits}
    )


def golden(position: np.ndarray, most: int) -> np.ndarray:
    """Stamp in each clock, (N,): position is 0 before the first clock."""
    moves = np.diff(position, prepend=0)
    clocks = np.arange(len(position))
    last = np.maximum.accumulate(np.where(moves != 0, clocks, -1))
    size = 2 * np.minimum(clocks - last, most) + 1
    return np.where(last < 0, 0, np.where(moves[last] < 0, -size, size))


def sampled(bits: int, position: np.ndarray, sample: np.ndarray) -> None:
    """The module against the model in every clock; outputs are those of the last sample."""
    found = block(bits).run(len(position), position=position, sample=sample)
    taken = np.maximum.accumulate(np.where(sample, np.arange(len(position)), -1))
    for name, want in (("position", position), ("stamp", golden(position, 2**bits - 1))):
        held = np.where(taken < 0, 0, want[taken])
        np.testing.assert_array_equal(signed(found[name], 32)[1:], held[:-1], err_msg=name)


def test_stamp__is_age_and_direction_of_the_last_count():
    random = np.random.default_rng(SEED)
    position = journey(random, 40_000, 1)
    assert np.ptp(position) > 50
    sampled(22, position, random.random(40_000) < 0.2)


def test_age__stops_at_its_greatest_value():
    random = np.random.default_rng(SEED)
    position = np.zeros(4000, dtype=np.int64)
    position[500:] = np.cumsum(random.random(3500) < 0.02) * np.where(np.arange(3500) < 1800, 1, 0)
    position[2300:] = position[2299]
    sampled(AGE_BITS, position, np.ones(4000, dtype=bool))


def test_no_count_since_reset__has_no_stamp():
    found = block(22).run(300, sample=1)
    assert not found["stamp"].any()


def front_end(stamps: int) -> Clocked:
    inputs = ("address", "read", "write", "writedata", "a", "b", "bus")
    return Clocked(
        "drive_front_end",
        inputs,
        ("readdata", "waitrequest"),
        {"Axes": 2, "EdgeStamps": stamps},
    )


@pytest.mark.full
def test_front_end__stamps_all_axes_in_one_clock_and_only_with_the_parameter():
    clocks, at = 5000, 3000
    steps = (np.arange(clocks) > 300) & (np.arange(clocks) % 37 == 0)
    true = np.cumsum(steps)
    # Axis 0 goes up, axis 1 down.
    moved = {name: 2 * lines(-true)[name] + lines(true)[name] for name in ("a", "b")}
    host = Accesses(DRIVE, clocks)
    host.write(at, "CONTROL", stamp=1)
    for n in range(2):
        host.read(4000 + 20 * n, "STAMP", index=n)
        host.read(4010 + 20 * n, "STAMP_POSITION", index=n)
    host.read(4100, "CONFIG")
    config = DRIVE.registers["CONFIG"].fields["edge_stamps"]
    late = LATENCY + DRIVE.registers["ENCODER"].fields["filter"].of(
        DRIVE.registers["ENCODER"].reset
    )
    seen = np.concatenate([np.zeros(late, dtype=np.int64), true])[: at + 1]
    *words, build = host.words(front_end(1).run(clocks, **host.columns, **moved))
    for n, way in enumerate((1, -1)):
        stamp, position = signed(np.array(words[2 * n : 2 * n + 2]), 32)
        assert (stamp, position) == (golden(way * seen, 2**22 - 1)[-1], way * seen[-1])
    assert config.of(build) == 1
    *words, build = host.words(front_end(0).run(clocks, **host.columns, **moved))
    assert not any(words) and config.of(build) == 0
