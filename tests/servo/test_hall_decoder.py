# SPDX-License-Identifier: Apache-2.0
"""Counts from Hall lines against the true electrical angle in every clock."""

from __future__ import annotations

import numpy as np
import pytest

from tests.bench.seed import SEED
from tests.servo.clocked import Clocked, signed

INPUTS = ("u", "v", "w", "clear")
OUTPUTS = ("position", "jump", "illegal", "bad_count")
SMALL = {"Bits": 8, "Filter": 6, "Limit": 20_000}
SECTOR, LATE = 1 << SMALL["Bits"], 4 + SMALL["Filter"]
TURN = 6 * SECTOR


def lines(true: np.ndarray, sector: int = SECTOR) -> dict[str, np.ndarray]:
    """Lines of a motor at these positions [counts]: each is high for half an electrical turn, a
    third of a turn after the one before."""
    turn = true / (6 * sector)
    return {
        name: (np.mod(turn - shift, 1) < 0.5).astype(np.int64)
        for name, shift in (("u", 0), ("v", 1 / 3), ("w", 2 / 3))
    }


def run(
    true: np.ndarray, **given: np.ndarray
) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
    """Outputs, position, and the true one as the lines show it at the output."""
    found = Clocked("hall_decoder", INPUTS, OUTPUTS, SMALL).run(len(true), **(lines(true) | given))
    shown = np.concatenate([np.full(LATE, true[0]), true[:-LATE]])
    return found, signed(found["position"], 32), shown


def quiet(found: dict[str, np.ndarray]) -> None:
    """No fault."""
    assert not found["jump"].any() and not found["illegal"].any() and not found["bad_count"].any()


def test_lines__are_those_of_the_contract():
    """The model of the lines has the states of the header, sector by sector."""
    found = lines((np.arange(6) + 0.5) * SECTOR)
    states = list(zip(found["u"], found["v"], found["w"], strict=True))
    assert states == [(1, 0, 1), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)]


@pytest.mark.parametrize("speed", [0.02, 0.1, 0.37, 0.95])
def test_constant_speed__every_clock_is_within_its_bound(speed):
    """Both ways, from the fourth edge on: a count of the cut, and the motion in a clock of the
    edge and in one of the sector's time."""
    for sign in (1, -1):
        true = 700.3 + sign * speed * np.arange(80_000)
        found, position, shown = run(true)
        quiet(found)
        begins = int(4 * SECTOR / speed)
        assert np.abs(position - shown)[begins:].max() <= 1 + 2 * speed
        assert np.abs(position[-1]) > speed * 70_000 - TURN


@pytest.mark.parametrize("sector", range(6))
def test_start__is_the_middle_of_the_sector_of_the_lines(sector):
    true = np.full(200, (sector + 0.9) * SECTOR)
    found, position, _ = run(true)
    quiet(found)
    assert (position[LATE + 1 :] == sector * SECTOR + SECTOR // 2).all()


def motion(clocks: int) -> np.ndarray:
    """A random motion with reversals, stops and at most a count in two clocks."""
    random = np.random.default_rng(SEED)
    speed = np.repeat(random.choice([0, 0.02, 0.1, 0.5], clocks // 2000), 2000)
    speed *= np.repeat(random.choice([-1, 1], clocks // 2000), 2000)
    smooth = np.convolve(speed, np.ones(800) / 800)[:clocks]
    return 1000.4 + np.cumsum(smooth)


def test_random_motion__the_sector_is_exact_in_every_clock():
    """Hence the count is within a sector of the true one, whatever its speed."""
    true = motion(300_000)
    found, position, shown = run(true)
    quiet(found)
    assert (position >> SMALL["Bits"] == np.floor(shown / SECTOR))[2 * LATE :].all()
    assert (np.diff(np.sign(np.diff(true))) != 0).sum() > 20


def test_acceleration__the_error_is_that_of_the_last_sectors_speed():
    """Of a sector of the time s: a s^2 counts, at its end."""
    rate = 2e-6
    true = 0.5 + 0.02 * np.arange(60_000) + rate / 2 * np.arange(60_000.0) ** 2
    found, position, shown = run(true)
    quiet(found)
    speed = 0.02 + rate * np.arange(60_000)
    begins = int(np.argmax(true > 4 * SECTOR))
    most = 1.5 * rate * (SECTOR / speed) ** 2 + 2
    off = np.abs(position - shown)
    assert (off <= most)[begins:].all() and off[begins:].max() > 5


def test_reversal__is_the_middle_until_a_sector_is_timed():
    clock = np.arange(60_000)
    true = 0.5 + 0.1 * np.minimum(clock, 60_000 - clock)
    found, position, shown = run(true)
    quiet(found)
    back = np.argmax(shown[30_100:] < np.floor(shown[30_100] / SECTOR) * SECTOR) + 30_100
    place = int(position[back + 2]) >> SMALL["Bits"]
    timed = back + int(SECTOR / 0.1)
    assert (position[back + 2 : timed - 2] == place * SECTOR + SECTOR // 2).all()
    assert np.abs(position - shown)[timed + 2 :].max() <= 2


def test_standstill__is_the_middle_after_the_limit():
    """Before that, the count stays at the end of its sector."""
    limit = SMALL["Limit"]
    stop = 10.2 * SECTOR
    true = np.minimum(0.2 * np.arange(4 * limit), stop)
    found, position, _ = run(true)
    quiet(found)
    edge = int(10 * SECTOR / 0.2) + LATE
    assert (position[edge + 2 * SECTOR * 5 : edge + limit - 2] == 11 * SECTOR - 1).all()
    assert (position[edge + limit + 3 :] == 10 * SECTOR + SECTOR // 2).all()


def test_noise_on_a_line__shorter_than_the_filter_changes_nothing():
    random = np.random.default_rng(SEED)
    true = 100.0 + 0.05 * np.arange(60_000)
    clean, _, _ = run(true)
    given = lines(true)
    for begin in np.arange(500, 59_000, 400):
        name = random.choice(["u", "v", "w"])
        if (np.diff(np.floor(true[begin - 20 : begin + 30] / SECTOR)) == 0).all():
            given[name][begin : begin + SMALL["Filter"]] ^= 1
    found, _, _ = run(true, **given)
    quiet(found)
    np.testing.assert_array_equal(found["position"], clean["position"])


def test_illegal_states__are_flagged_counted_and_forgotten_by_a_clear():
    true = 100.0 + 0.05 * np.arange(60_000)
    for level in (0, 1):
        given = lines(true)
        for name in ("u", "v", "w"):
            given[name][30_000:30_100] = level
        clear = np.zeros(60_000, dtype=np.int64)
        clear[40_000] = 1
        found, position, shown = run(true, **given, clear=clear)
        assert np.flatnonzero(np.diff(found["illegal"])).tolist() == [30_000 + LATE - 1, 40_000]
        assert found["bad_count"][39_000] == 1 and found["bad_count"][-1] == 0
        assert not found["jump"].any()
        assert (position >> SMALL["Bits"] == np.floor(shown / SECTOR))[2 * LATE :].all()
        assert np.abs(position - shown)[45_000:].max() <= 2


@pytest.mark.parametrize("skipped", [1, 2, -1, -2])
def test_skipped_sectors__are_a_jump_by_the_shorter_way(skipped):
    steps = skipped + np.sign(skipped)
    true = np.where(np.arange(4000) < 2000, 0.5, 0.5 + steps) * SECTOR
    found, position, _ = run(true)
    (begins,) = np.flatnonzero(np.diff(found["jump"]) > 0)
    assert begins == 2000 + LATE - 1 and found["bad_count"][-1] == 1
    assert not found["illegal"].any()
    # Three sectors are as far both ways.
    way = 3 if abs(steps) == 3 else steps
    assert position[-1] - position[1000] == way * SECTOR


def test_no_sensor__is_illegal_from_the_start():
    for level in (0, 1):
        given = {name: np.full(100, level) for name in ("u", "v", "w")}
        found, _, _ = run(np.zeros(100), **given)
        assert found["illegal"][LATE + 2 :].all() and found["bad_count"][-1] == 1


def test_own_size__counts():
    """The block as it is without parameters."""
    true = 300.0 - 0.3 * np.arange(30_000)
    found = Clocked("hall_decoder", INPUTS, OUTPUTS).run(30_000, **lines(true, 256))
    position = signed(found["position"], 32)
    shown = np.concatenate([np.full(19, true[0]), true[:-19]])
    assert np.abs(position - shown)[5000:].max() <= 2
