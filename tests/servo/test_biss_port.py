# SPDX-License-Identifier: Apache-2.0
"""Absolute encoder through the registers of its port, against the encoder of test_biss.

Accesses are at fixed clocks: a write takes one, a read two, or the test fails.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.rtl.gen.absolute_regmap import REGMAP
from tests.bench.seed import SEED
from tests.servo.clocked import Accesses, Clocked
from tests.servo.test_biss import Answers, Encoder, Silent, with_encoder

FIRST = 20  # clock of the first request
APART = 1200  # clocks between two requests
STATUS = REGMAP.registers["STATUS"].fields


def word(name: str, **fields: int) -> int:
    """Word of a register with these fields."""
    return REGMAP.registers[name].word(**fields)


class Port(Accesses):
    """The block with accesses and pulses of `sample_i` at given clocks."""

    top = "biss_port"
    ports: tuple[str, ...] = ("ma", "slo")

    def __init__(self, clocks: int, **parameters: int) -> None:
        super().__init__(REGMAP, clocks)
        self.sample = self.columns["sample"] = np.zeros(clocks, dtype=np.int64)
        *seen, line = self.ports
        outputs = ("readdata", "waitrequest", *seen)
        self.block = Clocked(self.top, (*self.columns, line), outputs, parameters)

    def run(self, encoder: Answers) -> tuple[list[int], np.ndarray]:
        """Words read, in the order of `read`, and the clock to the encoder."""
        frames = int(self.sample.sum() + self.columns["write"].sum()) + 1
        clocks = len(self.sample)
        found = with_encoder(self.block, encoder, frames, clocks, self.ports, **self.columns)
        return self.words(found), found[self.ports[0]]


def falls(ma: np.ndarray) -> np.ndarray:
    """Clocks in which MA is low and was high."""
    return np.flatnonzero((ma[1:] == 0) & (ma[:-1] == 1)) + 1


@pytest.mark.quick("26-10-0")
@pytest.mark.parametrize(
    ("width", "bit_clocks", "delay"), [(26, 10, 0), (32, 6, 9), (33, 10, 37), (64, 62, 250)]
)
def test_single_reads__positions_bits_and_delay_at_random(width, bit_clocks, delay):
    random = np.random.default_rng([SEED, width])
    frames = [
        Encoder(
            int.from_bytes(random.bytes(8), "little") >> (64 - width),
            *(bool(bit) for bit in random.integers(0, 2, 2)),
            wait=int(random.integers(1, 5)),
            width=width,
        )
        for _ in range(6)
    ]
    apart = (width + 20) * bit_clocks + delay + 200
    port = Port((len(frames) + 1) * apart, Width=width, ClocksPerBit=bit_clocks)
    port.read(2, "ID", "CONFIG", "STATUS")
    for number in range(len(frames)):
        start = FIRST + number * apart
        port.write(start, "CONTROL", start=1)
        port.read(start + 1, "STATUS")
        port.read(
            start + apart - 20,
            *("GOOD", "STATUS", "POSITION_LOW", "POSITION_HIGH", "DELAY", "BAD"),
        )
    encoder = replace(frames[0], delay=delay, timeout=2 * bit_clocks, later=tuple(frames[1:]))
    words, _ = port.run(encoder)
    assert words[0] == REGMAP.registers["ID"].reset
    assert words[1] == word("CONFIG", width=width, bit_clocks=bit_clocks, limit=400)
    assert words[2] == 0
    for number, frame in enumerate(frames):
        busy, good, status, low, high, clocks, bad = words[3 + 7 * number : 10 + 7 * number]
        assert STATUS["busy"].of(busy) and not STATUS["busy"].of(status)
        assert (high << 32) + low == frame.position
        assert status == word("STATUS", valid=1, error=frame.error, warning=frame.warning)
        assert (good, clocks, bad) == (number + 1, delay + 2, 0)


def test_wrong_check_sequence__is_said_and_counted_and_the_position_stays():
    right = Encoder(position=0x2345678, warning=True)
    wrong = replace(right, position=0x1111111, error=True, warning=False, flip=11)
    port = Port(5 * APART)
    for number in range(4):
        start = FIRST + number * APART
        port.write(start, "CONTROL", start=1, clear=int(number == 3))
        port.read(start + APART - 20, "STATUS", "POSITION_LOW", "GOOD", "BAD")
    words, _ = port.run(replace(right, later=(wrong, wrong, right)))
    ended = [words[4 * number : 4 * number + 4] for number in range(4)]
    good, bad = word("STATUS", valid=1, warning=1), word("STATUS", crc=1, warning=1)
    assert ended[0] == [good, right.position, 1, 0]
    assert ended[1] == [bad, right.position, 1, word("BAD", crc=1)]
    assert ended[2] == [bad, right.position, 1, word("BAD", crc=2)]
    assert ended[3] == [good, right.position, 1, 0]


def test_no_encoder__is_lost_and_counted():
    port = Port(11000)
    for start in (FIRST, 5000):
        port.write(start, "CONTROL", start=1)
        port.read(start + 4004, "STATUS", "BAD", "GOOD", "POSITION_LOW")
    words, ma = port.run(Silent())
    lost = word("STATUS", lost=1)
    assert words == [lost, word("BAD", lost=1), 0, 0, lost, word("BAD", lost=2), 0, 0]
    assert ma[-1] == 1


def test_request_before_the_time_out__is_lost_without_a_frame():
    port = Port(3000)
    port.write(FIRST, "CONTROL", start=1)
    port.write(500, "CONTROL", start=1)  # the encoder still holds its line
    port.read(502, "STATUS", "BAD")
    words, ma = port.run(Encoder(position=5))
    assert words == [word("STATUS", lost=1), word("BAD", lost=1)]
    assert (falls(ma) < 500).all()


def test_sample__starts_frames_while_enabled_and_a_dropped_request_is_flagged():
    encoder = Encoder(position=1, later=(Encoder(position=2), Encoder(position=3)))
    port = Port(7 * APART)
    times = [FIRST + number * APART for number in range(4)]
    for clock in (times[0], times[1], times[2], times[2] + 100, times[3]):
        port.sample[clock] = 1
    port.read(times[1] - 10, "GOOD", "TRIGGER")
    port.write(times[1] - 1, "TRIGGER", sample=1)
    port.read(times[2] - 10, "GOOD", "POSITION_LOW", "STATUS", "TRIGGER")
    port.read(times[3] - 10, "GOOD", "POSITION_LOW", "STATUS")
    port.write(times[3] - 2, "CONTROL", clear=1)
    port.write(times[3] - 1, "TRIGGER", sample=0)
    port.read(times[3] + APART, "GOOD", "POSITION_LOW", "STATUS")
    words, ma = port.run(encoder)
    valid, dropped = word("STATUS", valid=1), word("STATUS", valid=1, missed=1)
    assert words[:2] == [0, 0]
    assert words[2:6] == [1, 1, valid, word("TRIGGER", sample=1)]
    assert words[6:9] == [2, 2, dropped]
    assert words[9:] == [0, 2, valid]
    began = falls(ma)
    assert began[0] == times[1] + 1 and times[2] + 1 in began and (began < times[3]).all()


@pytest.mark.parametrize("bit_clocks", [6, 10, 62])
def test_sample__instant_of_the_position_is_half_a_bit_behind(bit_clocks):
    port = Port(FIRST + 60 * bit_clocks, ClocksPerBit=bit_clocks)
    port.write(5, "TRIGGER", sample=1)
    port.sample[FIRST] = 1
    _, ma = port.run(Encoder(timeout=2 * bit_clocks))
    rises = np.flatnonzero((ma[1:] == 1) & (ma[:-1] == 0)) + 1
    assert falls(ma)[0] == FIRST + 1 and rises[0] == FIRST + 1 + bit_clocks // 2


def test_reads_while_frames_run__halves_are_of_one_frame():
    """Reads without a pause: both halves say the same number, whatever ends between them."""
    random = np.random.default_rng([SEED, 48])
    frames = [
        Encoder(position=(number << 32) + number, width=48)
        for number in random.choice(1 << 16, 8, replace=False).tolist()
    ]
    for shift in range(4):  # a read takes two clocks, a pair four
        port = Port((len(frames) + 1) * APART, Width=48)
        port.write(2, "TRIGGER", sample=1)
        port.sample[FIRST + APART * np.arange(len(frames))] = 1
        for clock in range(FIRST + shift, len(frames) * APART, 4):
            port.read(clock, "POSITION_LOW", "POSITION_HIGH")
        words, _ = port.run(replace(frames[0], later=tuple(frames[1:])))
        pairs = np.array(words).reshape(-1, 2)
        assert (pairs[:, 0] == pairs[:, 1]).all()
        changes = pairs[np.flatnonzero(np.diff(pairs[:, 0])) + 1, 0]
        assert changes.tolist() == [frame.position & 0xFFFF for frame in frames]


def test_good_before_and_after__frames_the_position_and_its_bits():
    """What a host does while frames come by themselves, from each clock around a frame's end."""
    encoder = Encoder(position=7, error=True, later=(Encoder(position=9, warning=True),))
    seen = set()
    for start in range(FIRST + APART + 360, FIRST + APART + 430):
        port = Port(FIRST + 2 * APART)
        port.write(2, "TRIGGER", sample=1)
        port.sample[[FIRST, FIRST + APART]] = 1
        port.read(start, "GOOD", "POSITION_LOW", "STATUS", "GOOD")
        (before, position, status, after), _ = port.run(encoder)
        if before == after:
            assert (position, STATUS["error"].of(status)) in ((7, 1), (9, 0))
            assert position == {1: 7, 2: 9}.get(before)
        seen.add((before, after))
    assert seen == {(1, 1), (1, 2), (2, 2)}
