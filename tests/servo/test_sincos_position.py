# SPDX-License-Identifier: Apache-2.0
"""Positions from sine and cosine lines against arctan2 in double precision, and counts from the
bits of two modulators against the true position in every clock."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.bench.seed import SEED
from tests.servo import clocked
from tests.servo.clocked import Clocked, signed
from tests.servo.test_absolute_position import EXACT

HERE = Path(__file__).parent
INPUTS = ("valid", "sine", "cosine", "sample")
OUTPUTS = ("window", "busy", "done", "good", "position")
OWN = {"Width": 19, "Bits": 10, "Least": 32768, "Most": 98304, "After": 0}


def error_bound(parameters: dict[str, int]) -> float:
    """Counts before the cut, by the contract."""
    bits = parameters["Bits"]
    return 1 / 6 + (bits + 1) / 128 + bits * 2**bits / (100 * parameters["Least"])


def read(
    sine: np.ndarray, cosine: np.ndarray, parameters: dict[str, int] = OWN
) -> tuple[np.ndarray, np.ndarray]:
    """Positions and good of these samples, one request each."""
    bits = parameters["Bits"]
    span = bits + 8
    clocks = span * len(sine)
    columns = {name: np.zeros(clocks, dtype=np.int64) for name in INPUTS}
    begins = np.arange(0, clocks, span)
    columns["sample"][begins] = 1
    columns["valid"][begins + 2] = 1
    # Only the sample of valid_i may count.
    columns["sine"][:], columns["cosine"][:] = -12345, 54321
    columns["sine"][begins + 2], columns["cosine"][begins + 2] = sine, cosine
    found = Clocked("sincos_position", INPUTS, OUTPUTS, parameters).run(clocks, **columns)
    ends = begins + 2 + bits + 3
    np.testing.assert_array_equal(np.flatnonzero(found["done"]), ends)
    np.testing.assert_array_equal(np.flatnonzero(found["window"]), begins)
    return found["position"][ends], found["good"][ends].astype(bool)


def counts_off(position: np.ndarray, angle: np.ndarray, bits: int) -> np.ndarray:
    """Distance of a count's middle from the angle [rad], in counts, by the shorter way."""
    line = 1 << bits
    return (position + 0.5 - angle / (2 * math.pi) * line + line / 2) % line - line / 2


@pytest.mark.parametrize(
    "parameters",
    [
        OWN,
        {"Width": 16, "Bits": 10, "Least": 4096, "Most": 12288, "After": 0},
        {"Width": 8, "Bits": 4, "Least": 16, "Most": 64, "After": 0},
        {"Width": 24, "Bits": 16, "Least": 1 << 20, "Most": 1 << 22, "After": 0},
    ],
    ids=["own", "16", "8", "24"],
)
def test_position__is_the_arctangent_within_its_bound(parameters):
    """Whole circles with the amplitude at both limits and between, axes and diagonals included."""
    random = np.random.default_rng(SEED)
    least, most = parameters["Least"], parameters["Most"]
    angle = random.uniform(-math.pi, math.pi, 20_000)
    amplitude = random.uniform(least * 1.01, most * 0.99, len(angle))
    angle[:64] = np.arange(64) * math.pi / 32
    sine = np.rint(amplitude * np.sin(angle)).astype(np.int64)
    cosine = np.rint(amplitude * np.cos(angle)).astype(np.int64)
    size = np.hypot(sine, cosine)
    inside = (size > least * 1.001) & (size < most * 0.999)
    position, good = read(sine, cosine, parameters)
    assert good[inside].all() and inside.sum() > 19_000
    off = counts_off(position, np.arctan2(sine, cosine), parameters["Bits"])[inside]
    assert np.abs(off).max() <= 0.5 + error_bound(parameters)
    assert (
        set(np.unique(position)) == set(range(1 << parameters["Bits"])) or parameters["Bits"] == 16
    )


def test_amplitude__is_good_within_its_limits_alone():
    angle = np.linspace(-math.pi, math.pi, 500)
    for share, wanted in ((0.999, False), (1.001, True)):
        for limit, right in ((OWN["Least"], wanted), (OWN["Most"], not wanted)):
            sine = np.rint(limit * share * np.sin(angle)).astype(np.int64)
            cosine = np.rint(limit * share * np.cos(angle)).astype(np.int64)
            assert (read(sine, cosine)[1] == right).all()
    # Both lines lost, one lost, both at the end of the samples.
    full = (1 << 18) - 1
    sine = np.array([0, 0, 60000, -full - 1, full])
    cosine = np.array([0, 60000, 0, -full - 1, full])
    assert read(sine, cosine)[1].tolist() == [False, True, True, False, False]


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_dead_line__at_rest_is_good_only_near_the_peaks_of_the_other(share):
    """Least is a share of the amplitude: within b = arccos(share) of a peak the amplitude is good,
    and the position off by b / (2 pi) lines at most."""
    amplitude = OWN["Least"] / share
    angle = (np.arange(3000) + 0.5) * 2 * math.pi / 3000
    limit = math.acos(share)
    for dead in ("sine", "cosine"):
        sine, cosine = (np.rint(amplitude * f(angle)).astype(int) for f in (np.sin, np.cos))
        away = angle if dead == "sine" else angle - math.pi / 2
        away = np.abs((away + math.pi / 2) % math.pi - math.pi / 2)
        (sine if dead == "sine" else cosine)[:] = 0
        position, good = read(sine, cosine)
        clear = np.abs(away - limit) > 0.002 * math.pi
        np.testing.assert_array_equal(good[clear], (away < limit)[clear])
        off = np.abs(counts_off(position, angle, OWN["Bits"]))[good].max()
        most = limit / (2 * math.pi) * (1 << OWN["Bits"])
        assert 0.97 * most < off <= most + 0.5 + error_bound(OWN)


def test_own_size__requests_at_work_are_ignored_and_the_position_holds():
    """The block as it is without parameters; a sample that nobody asked for ends nothing."""
    columns = {name: np.zeros(400, dtype=np.int64) for name in INPUTS}
    columns["sine"][:], columns["cosine"][:] = 39_000, -40_000
    columns["sample"][[10, 15, 52, 60, 133]] = 1
    columns["valid"][[5, 50, 56, 100, 125, 300]] = 1
    columns["sine"][120:] *= -1
    found = Clocked("sincos_position", INPUTS, OUTPUTS).run(400, **columns)
    assert np.flatnonzero(found["window"]).tolist() == [10, 133]
    assert np.flatnonzero(found["done"]).tolist() == [63, 313]
    busy = np.flatnonzero(np.diff(found["busy"]))
    assert busy.tolist() == [10, 63, 133, 313]
    assert (found["position"][63:313] == 386).all() and found["position"][-1] == 637


def test_errors_of_the_lines__are_errors_of_the_position_by_their_formulas():
    """Of an offset of o amplitudes o / (2 pi) lines, of a gain of 1 + g against the other
    g / (4 pi), of a phase p [rad] p / (2 pi) at most; the cut adds its half count."""
    angle = np.linspace(-math.pi, math.pi, 4001)
    line, cut = 1 << OWN["Bits"], 0.5 + error_bound(OWN)
    for o, g, p in ((0.05, 0, 0), (0, 0.05, 0), (0, 0, 0.05), (0.02, -0.03, -0.02)):
        sine = np.rint(65536 * ((1 + g) * np.sin(angle + p) + o)).astype(np.int64)
        cosine = np.rint(65536 * np.cos(angle)).astype(np.int64)
        position, good = read(sine, cosine)
        off = np.abs(counts_off(position, angle, OWN["Bits"])).max()
        formula = (abs(o) / (2 * math.pi) + abs(g) / (4 * math.pi) + abs(p) / (2 * math.pi)) * line
        # Of second order are products of the errors, and that of the gain.
        assert good.all() and off <= formula * 1.06 + cut
        if (o, g, p).count(0) == 2:
            assert off >= 0.97 * formula


def test_noise__of_the_samples_is_that_of_the_position():
    """rms: s / (2 pi A) lines of a noise of s in both samples, next to that of whole counts."""
    random = np.random.default_rng(SEED)
    parameters = {"Width": 19, "Bits": 14, "Least": 32768, "Most": 98304, "After": 0}
    angle = random.uniform(-math.pi, math.pi, 10_000)
    noise = random.normal(0, 100, (2, len(angle)))
    sine, cosine = np.rint(65536 * np.array([np.sin(angle), np.cos(angle)]) + noise).astype(int)
    position, good = read(sine, cosine, parameters)
    rms = np.sqrt(np.mean(counts_off(position, angle, 14) ** 2))
    wanted = math.hypot(100 / (2 * math.pi * 65536) * (1 << 14), 1 / math.sqrt(12))
    assert good.all() and rms == pytest.approx(wanted, rel=0.03)


# The loop: windows of 3 x 32 bits of 6 clocks each.
BIT, RATE, PERIOD, BITS = 6, 32, 660, 10
LINE = 1 << BITS
JUMP = 448
# The middle of the window, less two bits of the modulator and the clocks until its bit is taken.
INSTANT = (3 * RATE - 1) * BIT // 2 - 2 * BIT - (BIT - 1)
FULL = RATE**3 // 2
AMPLITUDE = 0.5  # of the full scale
Position = Callable[[np.ndarray], np.ndarray]
LOOP = ("bit_sine", "bit_cosine", "clear")
LOOP_OUTPUTS = ("strobe", "position", "jump", "lost", "bad_count", "done")
Strength = Callable[[np.ndarray], np.ndarray]


def modulated(values: np.ndarray) -> np.ndarray:
    """Bits of a modulator of second order for values of the full scale, one a bit."""
    first = second = 0.0
    bits = np.zeros(len(values), dtype=np.int64)
    for n, value in enumerate(values.tolist()):
        bits[n] = second >= 0
        back = 2.0 * bits[n] - 1
        first = min(max(first + value - back, -8.0), 8.0)
        second = min(max(second + first - 2 * back, -16.0), 16.0)
    return bits


def steady(clock: np.ndarray) -> np.ndarray:
    """A line of full strength."""
    return np.ones(len(clock))


def window_noise(bits: dict[str, np.ndarray], true: Position) -> float:
    """Greatest distance of arctan2 of the windows from the true angle [counts], in double
    precision."""
    weights = np.ones(RATE)
    for _ in range(2):
        weights = np.convolve(weights, np.ones(RATE))
    begins = np.arange(PERIOD // BIT - 1, len(bits["bit_sine"]) - 3 * RATE, PERIOD // BIT)
    taken = begins[:, None] + 1 + np.arange(len(weights))
    sine, cosine = ((2 * values - 1)[taken] @ weights for values in bits.values())
    angle = 2 * math.pi * true(begins * BIT + BIT - 1 + INSTANT) / LINE
    return float(
        np.abs(counts_off(np.arctan2(sine, cosine) * LINE / 2 / math.pi - 0.5, angle, BITS)).max()
    )


def loop(
    clocks: int,
    true: Position,
    sine: Strength = steady,
    cosine: Strength = steady,
    after: int = 4,
) -> tuple[dict[str, np.ndarray], np.ndarray, float]:
    """Outputs, the distance of the count from the true position [counts] by clock, and what it may
    be at a constant speed; sine, cosine: strengths of the lines, in the clocks of the bits."""
    instants = np.arange(0, clocks, BIT)
    angle = 2 * math.pi * true(instants) / LINE
    bits = {
        "bit_sine": modulated(AMPLITUDE * sine(instants) * np.sin(angle)),
        "bit_cosine": modulated(AMPLITUDE * cosine(instants) * np.cos(angle)),
    }
    columns = {name: np.repeat(values, BIT)[:clocks] for name, values in bits.items()}
    block = Clocked("sincos_loop", LOOP, LOOP_OUTPUTS, {"After": after}, (*clocked.FOLDERS, HERE))
    found = block.run(clocks, **columns)
    strobes = np.flatnonzero(found["strobe"])
    np.testing.assert_array_equal(strobes, np.arange(BIT - 1, clocks, BIT))
    first = float(np.floor(true(np.array([PERIOD - 1 + INSTANT]))[0]))
    off = signed(found["position"], 32) - (true(np.arange(clocks)) - first)
    # Three samples with weights of 2, 1 and 1 at most, and the first one is the zero.
    noise = window_noise(bits, true) + error_bound({"Bits": BITS, "Least": 4096})
    return found, off, EXACT + 5 * noise


def quiet(found: dict[str, np.ndarray]) -> None:
    """No fault, no bad sample."""
    assert not found["jump"].any() and not found["lost"].any() and not found["bad_count"].any()


# At the limit: MostJump is less than half a line, which the motor may move in a period at most.
FASTEST = 0.49 * LINE / PERIOD


@pytest.mark.parametrize("speed", [0.0, 0.0137, 0.3, FASTEST])
def test_loop__counts_lines_at_a_constant_speed_in_every_clock(speed):
    """Both ways, over many lines."""
    clocks = 60_000
    for sign in (1, -1):
        found, off, most = loop(clocks, lambda clock, v=sign * speed: 300.5 + v * clock)
        quiet(found)
        assert np.abs(off[6 * PERIOD :]).max() <= most < 8
        moved = np.abs(signed(found["position"], 32)).max()
        assert moved >= speed * (clocks - 2 * PERIOD) - most


def ramp(clock: np.ndarray, speed: float, rate: float) -> np.ndarray:
    """Counts of an acceleration [counts / clock^2] to a speed, then back through rest to minus
    that speed."""
    time, top = clock.astype(float), speed / rate
    up = np.minimum(time, top)
    down = np.clip(time - 2 * top, 0, 2 * top)
    after = np.maximum(time - 4 * top, 0)
    steady = np.clip(time - top, 0, top)
    return (
        300.5
        + rate / 2 * up**2
        + speed * steady
        + speed * down
        - rate / 2 * down**2
        - speed * after
    )


def test_loop__reversals_lose_no_line_below_the_limit_and_one_above_it_is_a_jump():
    rate = FASTEST / 15_000
    found, off, most = loop(90_000, lambda clock: ramp(clock, FASTEST, rate))
    quiet(found)
    # As absolute_position has it: the speed is that of the last two samples.
    time = INSTANT + RATE * 3 * BIT // 2 + 3 * BIT + BITS + 9
    span = PERIOD + time
    lag = rate * (span**2 / 2 + PERIOD * span / 2 + PERIOD * time)
    assert np.abs(off[6 * PERIOD :]).max() <= most + lag < LINE / 8
    found, off, _ = loop(60_000, lambda clock: ramp(clock, 1.1 * FASTEST, rate))
    (begins,) = np.flatnonzero(np.diff(found["jump"]) > 0)
    # Until the fault is known no line is lost.
    assert begins > 15_000 and np.abs(off[6 * PERIOD : begins]).max() <= most + lag


def gone(*periods: int) -> Strength:
    """A line that is not there in these periods."""
    return lambda clock: np.where(np.isin(clock // PERIOD, periods), 0.0, 1.0)


@pytest.mark.parametrize("speed", [0.02, 0.1, 0.2, 0.3, 0.5, 0.7])
@pytest.mark.parametrize("weak", [0.0, 0.3])
def test_loop__a_line_that_is_lost_or_weak_is_a_fault(weak, speed):
    """Within a line of motion, and the periods until the encoder is lost."""
    begins = 20 * PERIOD

    def sine(clock: np.ndarray) -> np.ndarray:
        return np.where(clock < begins, 1.0, weak)

    found, off, _ = loop(90_000, lambda clock: 300.5 + speed * clock, sine)
    fault = found["jump"] | found["lost"]
    assert not fault[:begins].any() and np.abs(off[6 * PERIOD : begins]).max() <= 2 * EXACT
    assert begins < np.argmax(fault) < begins + LINE / speed + 7 * PERIOD


def test_amplitude__samples_after_a_wrong_one_are_bad_too():
    size = np.full(30, 65536)
    size[[5, 7, 20]] = 0
    found = read(size, np.zeros(30, dtype=int), OWN | {"After": 4})[1]
    assert np.flatnonzero(~found).tolist() == [*range(5, 12), *range(20, 25)]


def test_loop__short_gaps_of_both_lines_are_bridged_and_counted():
    """One and two samples at a speed at which three periods are less than half a line."""
    strength = gone(20, 40, 41)
    found, off, _ = loop(60_000, lambda clock: 300.5 + 0.2 * clock, strength, strength, after=0)
    assert not found["jump"].any() and not found["lost"].any() and found["bad_count"][-1] == 3
    assert np.abs(off[6 * PERIOD :]).max() <= 2 * EXACT


def test_loop__a_gap_of_more_than_half_a_line_is_a_jump():
    strength = gone(20)
    found, _, _ = loop(30_000, lambda clock: 300.5 + 0.6 * clock, strength, strength, after=0)
    (begins,) = np.flatnonzero(np.diff(found["jump"]) > 0)
    assert 21 * PERIOD < begins < 23 * PERIOD
