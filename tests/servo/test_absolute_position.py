# SPDX-License-Identifier: Apache-2.0
"""Counts from the words of an absolute encoder against the encoder's true position in every clock.

The model of the port answers each request `LATE` clocks later with the whole part of the true
position at the encoder's instant; bad frames, late frames and wrong positions are planted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from tests.bench.seed import SEED
from tests.servo.clocked import Clocked, signed

INPUTS = ("busy", "done", "good", "position", "clear")
OUTPUTS = ("request", "position", "jump", "lost", "bad_count")
PERIOD, LATE, INSTANT, PERIODS, JUMP = 500, 330, 6, 4, 40
ACTS = 6  # clocks from the end of a frame to position_o
SMALL = {"Width": 20, "Period": PERIOD, "Instant": INSTANT, "MostJump": JUMP, "Periods": PERIODS}
# Counts at a constant speed. Whole parts e of the positions k, k - 1, k - 2, each -1 .. 0, are seen
# as 2 e_k - (1 - L / P) e_{k-1} - L / P e_{k-2} at worst, so -2 .. 1; evenly spread counts add 1.
EXACT = 3
Position = Callable[[np.ndarray], np.ndarray]


class Frames:
    """Frames of an encoder with its position in counts, by clock.

    bad, late, wrong: by number of the frame, how it ends: without a position, after so many clocks
    instead of LATE, with so many counts more. modulus: of the encoder's range; low: bits below a
    count.
    """

    def __init__(
        self,
        clocks: int,
        true: Position,
        bad: frozenset[int] = frozenset(),
        late: Mapping[int, int] | None = None,
        wrong: Mapping[int, int] | None = None,
        modulus: int = 1 << 20,
        low: int = 0,
    ) -> None:
        self.true, self.modulus, self.low = true, modulus, low
        self.columns = {name: np.zeros(clocks, dtype=np.int64) for name in INPUTS}
        self.requests, self.ends, busy_until = [], [], 0
        for tick in range(PERIOD - 1, clocks, PERIOD):
            if tick < busy_until:
                continue
            number = len(self.requests)
            end = tick + (late or {}).get(number, LATE)
            self.requests.append(tick)
            if end >= clocks:
                break
            counts = self.floor(tick + INSTANT) + (wrong or {}).get(number, 0)
            # The bits below a count are not zero.
            word = ((counts % modulus) << low) + (0x5A5A5A5A & ((1 << low) - 1))
            self.columns["busy"][tick + 1 : end + 1] = 1
            self.columns["done"][end] = 1
            self.columns["good"][end] = number not in bad
            self.columns["position"][end:] = word
            self.ends.append(end)
            busy_until = end + 1

    def floor(self, clock: int) -> int:
        """Whole counts in a clock."""
        return int(np.floor(self.true(np.array([clock]))[0]))

    def run(self, parameters: Mapping[str, int] = SMALL, **more: np.ndarray):
        """Outputs, and the distance of position_o from the true position, by clock."""
        clocks = len(self.columns["busy"])
        found = Clocked("absolute_position", INPUTS, OUTPUTS, parameters).run(
            clocks, **(self.columns | more)
        )
        np.testing.assert_array_equal(np.flatnonzero(found["request"]), self.requests)
        first = self.floor(self.requests[0] + INSTANT)
        off = signed(found["position"], 32) - (self.true(np.arange(clocks)) - first)
        return found, off


def steady(speed: float, at: float = 1234.5) -> Position:
    """counts a clock, counts."""
    return lambda clock: at + speed * clock


def quiet(found: Mapping[str, np.ndarray]) -> None:
    """No fault, no bad frame."""
    assert not found["jump"].any() and not found["lost"].any() and not found["bad_count"].any()


def tracks_from(frames: Frames, frame: int = 1) -> int:
    """Clock from which on position_o is right: the frame's action."""
    return frames.ends[frame] + ACTS


@pytest.mark.parametrize("speed", [0.0, 1e-3, 0.0137, 0.3, 0.97, 1.0])
def test_constant_speed__every_clock_is_within_three_counts_of_the_true_position(speed):
    """Both ways, across the end of the encoder's range many times."""
    for sign in (1, -1):
        frames = Frames(60_000, steady(sign * speed), modulus=1 << 14)
        found, off = frames.run(SMALL | {"Width": 14})
        quiet(found)
        assert np.abs(off[tracks_from(frames) + PERIOD :]).max() <= EXACT
        assert np.abs(signed(found["position"], 32)).max() >= speed * 50_000 - 2


def test_range_that_is_no_power_of_two__and_bits_below_a_count():
    frames = Frames(50_000, steady(-0.41), modulus=3000, low=4)
    found, off = frames.run(SMALL | {"Width": 16, "Drop": 4, "Modulus": 3000})
    quiet(found)
    assert np.abs(off[tracks_from(frames) + PERIOD :]).max() <= EXACT
    assert signed(found["position"], 32)[-1] < -6 * 3000


def test_width_of_64_bits__counts_in_32():
    base = 0x7_FFFF_FFF0
    frames = Frames(8000, steady(0.25, base), modulus=1 << 62)
    found, off = frames.run(SMALL | {"Width": 64})
    quiet(found)
    assert np.abs(off[tracks_from(frames) + PERIOD :]).max() <= EXACT


def lag(acceleration: float) -> float:
    """Counts by which an acceleration [counts / clock^2] leads the position at most, just before a
    frame acts: until the frame before acted, the speed was the mean of the period before the last
    one, and then that of the last one."""
    time = LATE + ACTS
    span = PERIOD + time
    return acceleration * (span**2 / 2 + PERIOD * span / 2 + PERIOD * time)


def test_own_size__counts_and_a_lost_encoder():
    """The block as it is without parameters."""
    clocks, period = 60_000, 2500
    given = {name: np.zeros(clocks, dtype=np.int64) for name in INPUTS}
    ticks = np.arange(period - 1, clocks // 2, period)
    given["done"][ticks + 1500] = given["good"][ticks + 1500] = 1
    for tick in ticks:
        given["position"][tick + 1500 :] = 5_000_000 + tick // 20
    found = Clocked("absolute_position", INPUTS, OUTPUTS).run(clocks, **given)
    assert np.flatnonzero(found["request"])[: len(ticks)].tolist() == ticks.tolist()
    seen = slice(ticks[3] + 1506, ticks[-1])
    true = (np.arange(clocks) - ticks[0]) / 20
    assert np.abs(signed(found["position"], 32) - true)[seen].max() <= EXACT
    (begins,) = np.flatnonzero(np.diff(found["lost"]) > 0)
    assert begins == ticks[-1] + 5 * period and not found["jump"].any()


def test_acceleration__error_is_that_of_the_mean_speed():
    """By the closed form of `lag`."""
    rate = 1.2e-5  # counts / clock^2
    frames = Frames(40_000, lambda clock: 77.5 + rate / 2 * clock**2)
    found, off = frames.run()
    quiet(found)
    after = off[tracks_from(frames, 2) :]
    assert lag(rate) - EXACT < np.abs(after).max() <= lag(rate) + EXACT


def test_random_motion__within_the_same_bound():
    random = np.random.default_rng(SEED)
    knots = np.cumsum(random.normal(0, 1.5e-5, 60_000))
    speed = 0.4 * np.sin(np.cumsum(knots) * 1e-2)
    path = np.cumsum(speed)
    most = np.abs(np.diff(speed)).max()
    frames = Frames(60_000, lambda clock: path[clock])
    found, off = frames.run()
    quiet(found)
    assert np.abs(off[tracks_from(frames, 2) :]).max() <= lag(most) + EXACT


def test_bad_frames__are_bridged_by_the_speed_and_counted():
    """As many in a row as are allowed; a frame that is late is one of the next period."""
    bad = frozenset({10, 20, 21, 30, 31, 32})
    frames = Frames(40_000, steady(0.6), bad=bad, late={40: LATE + 2 * PERIOD})
    found, off = frames.run()
    assert not found["jump"].any() and not found["lost"].any()
    assert np.abs(off[tracks_from(frames) + PERIOD :]).max() <= EXACT
    assert found["bad_count"][-1] == len(bad)
    assert (np.diff(found["bad_count"]) > 0).sum() == len(bad)


def test_too_many_bad_frames__set_lost_and_the_next_good_ones_go_on():
    """Lost with the request that follows the last allowed one; rests until the next good frame."""
    bad = frozenset(range(10, 16))
    clear = np.zeros(30_000, dtype=np.int64)
    frames = Frames(30_000, steady(0.6), bad=bad)
    clear[frames.requests[20] + 1] = 1
    found, off = frames.run(clear=clear)
    (begins,) = np.flatnonzero(np.diff(found["lost"]) > 0)
    assert begins == frames.requests[9 + PERIODS + 1]
    resting = found["position"][begins + 3 : frames.ends[16] + ACTS]
    assert np.ptp(resting) == 0 and len(resting) > PERIOD
    assert not found["lost"][frames.requests[20] + 2 :].any()
    assert not found["bad_count"][frames.requests[20] + 2 :].any()
    assert not found["jump"].any()
    assert np.abs(off[tracks_from(frames, 17) + PERIOD :]).max() <= EXACT


def test_no_encoder__is_lost_at_once_and_again_after_a_clear():
    clear = np.zeros(8000, dtype=np.int64)
    clear[4 * PERIOD * PERIODS // 2] = 1
    frames = Frames(8000, steady(0.0), bad=frozenset(range(100)))
    found, _ = frames.run(clear=clear)
    assert not found["position"].any()
    begins = np.flatnonzero(np.diff(found["lost"]) > 0)
    assert begins[0] == (PERIODS + 1) * PERIOD - 1 and len(begins) == 2


@pytest.mark.parametrize("speed", [0.0, -0.6])
def test_jump__is_rejected_at_once_and_a_smaller_step_is_not(speed):
    far, near = JUMP + EXACT + 1, JUMP - EXACT - 1
    for sign in (1, -1):
        frames = Frames(20_000, steady(speed), wrong={12: sign * far})
        found, off = frames.run()
        (begins,) = np.flatnonzero(np.diff(found["jump"]) > 0)
        assert begins + 1 == frames.ends[12] + ACTS
        assert found["bad_count"][-1] == 1 and not found["lost"].any()
        # The position rests until the next good frame and never takes the wrong one.
        most = EXACT + abs(speed) * (PERIOD + LATE + ACTS)
        assert np.abs(off[tracks_from(frames) + PERIOD :]).max() <= most
        assert np.abs(off[tracks_from(frames, 14) + PERIOD :]).max() <= EXACT
        frames = Frames(20_000, steady(speed), wrong=dict.fromkeys(range(12, 50), sign * near))
        found, _ = frames.run()
        assert not found["jump"].any() and not found["bad_count"].any()


def test_faster_than_a_count_a_clock__is_a_jump():
    frames = Frames(10_000, lambda clock: np.where(clock < 5000, 0.0, 1.1 * (clock - 5000)))
    found, _ = frames.run(SMALL | {"MostJump": 1 << 20})
    assert found["jump"].any()
    frames = Frames(10_000, lambda clock: np.where(clock < 5000, 0.0, 0.99 * (clock - 5000)))
    found, _ = frames.run(SMALL | {"MostJump": 1 << 20})
    assert not found["jump"].any()


def test_slow_first_frame_beyond_the_limit__is_dropped_and_the_next_one_is_the_zero():
    """As the frame of an EnDat encoder that measures its delay."""
    frames = Frames(20_000, steady(0.3), late={0: (PERIODS + 3) * PERIOD + 100})
    clear = np.zeros(20_000, dtype=np.int64)
    clear[frames.ends[1] + ACTS] = 1
    found, _ = frames.run(clear=clear)
    assert found["lost"].any() and not found["lost"][frames.ends[1] + ACTS + 1 :].any()
    first = frames.floor(frames.requests[1] + INSTANT)
    off = signed(found["position"], 32) - (steady(0.3)(np.arange(20_000)) - first)
    assert not found["position"][: frames.ends[1] + ACTS].any()
    assert np.abs(off[tracks_from(frames, 2) + PERIOD :]).max() <= EXACT
