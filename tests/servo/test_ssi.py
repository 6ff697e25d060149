# SPDX-License-Identifier: Apache-2.0
"""SSI master and its port against a model of an encoder: codes, parity, repeats, a broken line.

The model is the circuit of the manuals (TR-Electronic COK 65, Posital): a shift register, which a
falling edge of the clock loads while a monoflop rests, each falling edge starts that monoflop
again, each rising edge shifts, and the line is high while the monoflop rests.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.bench.seed import SEED
from tests.servo.clocked import Clocked
from tests.servo.test_biss import with_encoder
from tests.servo.test_biss_port import Port, falls, word

OUTPUTS = ("clock", "busy", "done", "position", "error", "crc_error", "lost", "delay")
PORTS = ("clock", "data")
START = 20  # clock of the request
MONOFLOP = 2000  # clocks: 20 us at 100 MHz


@dataclass(frozen=True)
class Word:
    """What the encoder sends; parity: 0 none, 1 even, 2 odd, as the block's parameters."""

    width: int = 25
    gray: bool = False
    alarm: bool = False
    parity: int = 0
    repeat: bool = False
    clocks_per_bit: int = 100

    def bits(self, position: int, alarm: bool = False) -> list[int]:
        """In the order on the line."""
        code = position ^ position >> 1 if self.gray else position
        bits = [code >> bit & 1 for bit in reversed(range(self.width))]
        bits += [int(alarm)] * self.alarm
        if self.parity:
            bits.append((sum(bits) + self.parity - 1) % 2)
        return bits

    @property
    def parameters(self) -> dict[str, int]:
        """Of the block."""
        return {
            "Width": self.width,
            "Gray": int(self.gray),
            "Alarm": int(self.alarm),
            "Parity": self.parity,
            "Repeat": int(self.repeat),
            "ClocksPerBit": self.clocks_per_bit,
        }


@dataclass(frozen=True)
class Encoder:
    """An encoder and its line. position: of a clock; flip: these bits after the first rising edge
    are wrong; stuck: from that clock on at that level."""

    word: Word
    position: Callable[[int], int]
    alarm: bool = False
    monoflop: int = MONOFLOP
    delay: int = 0  # clocks of line and encoder
    flip: tuple[int, ...] = ()
    ring: bool = True  # sends its word again
    stuck: tuple[int, int] | None = None

    def line(self, ma: np.ndarray) -> np.ndarray:
        """Level of the data line for each clock."""
        level = np.ones(len(ma), dtype=np.int64)
        shift: list[int] = []
        since, edges, now_level = self.monoflop, 0, 1
        for now in range(1, len(ma)):
            since += 1
            if since >= self.monoflop:
                now_level = 1
            if not ma[now] and ma[now - 1]:
                if since >= self.monoflop:  # it takes its position
                    shift = [*self.word.bits(self.position(now), self.alarm), 0]
                    edges = 0
                since = 0
            elif ma[now] and not ma[now - 1] and since < self.monoflop:
                bit = shift.pop(0) if shift else 0
                if self.ring:
                    shift.append(bit)
                now_level = bit ^ int(edges in self.flip)
                edges += 1
            level[now] = now_level
        level = np.concatenate([np.ones(self.delay, dtype=np.int64), level])[: len(ma)]
        if self.stuck:
            level[self.stuck[0] :] = self.stuck[1]
        return level


def at(position: int) -> Callable[[int], int]:
    """At rest."""
    return lambda _: position


def read(encoder: Encoder, starts: tuple[int, ...] = (START,), **more: int):
    """Outputs of the master, with the encoder at its end."""
    bits = 2 * (encoder.word.width + 6) * encoder.word.clocks_per_bit
    clocks = starts[-1] + bits + max(MONOFLOP, encoder.monoflop) + 200
    parameters = encoder.word.parameters | more
    master = Clocked("ssi_master", ("start", "data"), OUTPUTS, parameters)
    start = np.isin(np.arange(clocks), starts)
    return with_encoder(master, encoder, len(starts), clocks, PORTS, start=start)


WORDS = [
    Word(),
    Word(13, gray=True, alarm=True, parity=1, repeat=True, clocks_per_bit=50),
    Word(64, gray=True, parity=2, clocks_per_bit=6),
    Word(12, alarm=True, parity=2, clocks_per_bit=254),
]


@pytest.mark.quick("25")
@pytest.mark.parametrize("word", WORDS, ids=lambda word: f"{word.width}")
def test_frame__position_and_alarm_arrive_at_any_delay_that_is_allowed(word):
    random = np.random.default_rng([SEED, word.width])
    bits = (len(word.bits(0)) + 1) * (2 if word.repeat else 1)
    for delay in (0, 1, word.clocks_per_bit - 3):
        for alarm in (False, True)[: 1 + word.alarm]:
            position = int(random.integers(0, 1 << word.width, dtype=np.uint64))
            monoflop = 3 * word.clocks_per_bit + 40
            found = read(Encoder(word, at(position), alarm, monoflop, delay))
            (done,) = np.flatnonzero(found["done"])
            assert not found["lost"][done] and not found["crc_error"][done]
            assert int(found["position"][done]) % 2**64 == position
            assert found["error"][done] == alarm
            assert found["delay"][done] == monoflop - word.clocks_per_bit // 2 + delay + 2
            last = START + 1 + (bits - 1) * word.clocks_per_bit  # falling edge
            assert done == last + monoflop + delay + 3
            assert not found["busy"][done:].any() and found["clock"][done:].all()


@pytest.mark.parametrize("word", WORDS[:2], ids=lambda word: f"{word.width}")
def test_clock__has_a_pulse_for_each_bit_and_one_for_the_low_bit(word):
    clock = read(Encoder(word, at(1)))["clock"]
    rises = np.flatnonzero((clock[1:] == 1) & (clock[:-1] == 0)) + 1
    pulses = (len(word.bits(0)) + 1) * (2 if word.repeat else 1)
    first = START + 1
    assert falls(clock).tolist() == [first + n * word.clocks_per_bit for n in range(pulses)]
    assert (rises - falls(clock) == word.clocks_per_bit // 2).all()


def test_position_that_moves__is_that_of_the_first_falling_edge():
    for sent in WORDS[:2]:
        found = read(Encoder(sent, lambda now: 37 * now % (1 << 13)))
        (done,) = np.flatnonzero(found["done"])
        assert found["position"][done] == 37 * (START + 1) % (1 << 13)


def test_frames_one_after_another__each_is_read():
    starts = (START, START + 6000, START + 12000)
    found = read(Encoder(Word(), lambda now: now), starts)
    (done,) = np.nonzero(found["done"])
    assert found["position"][done].tolist() == [start + 1 for start in starts]
    assert not found["lost"].any()


@pytest.mark.quick("even")
@pytest.mark.parametrize(
    ("word", "crc_error"),
    [
        (Word(13), False),
        (Word(13, gray=True, parity=1), True),
        (Word(13, parity=2, alarm=True), True),
        (Word(13, repeat=True), True),
    ],
    ids=["plain", "even", "odd", "repeat"],
)
def test_wrong_bit_anywhere__is_found_by_parity_or_the_second_word_and_not_without(word, crc_error):
    for flip in range(len(word.bits(0)) * (2 if word.repeat else 1) + int(word.repeat)):
        found = read(Encoder(word, at(0x1234), flip=(flip,)))
        (done,) = np.flatnonzero(found["done"])
        assert not found["lost"][done]
        assert found["crc_error"][done] == crc_error
        assert found["position"][done] == (0 if crc_error else 0x1234 ^ 1 << (12 - flip))


def test_encoder_without_repeat__is_an_error_not_a_position():
    found = read(Encoder(Word(13, repeat=True), at(0x1234), ring=False))
    (done,) = np.flatnonzero(found["done"])
    assert found["crc_error"][done] and found["position"][done] == 0


def test_line_breaks__at_any_time_a_stuck_line_is_lost():
    """High from the request on: no encoder. Low: before the request, or within the frame."""
    for level in (0, 1):
        for clock in (0, START + 700, START + 2590):
            found = read(Encoder(Word(), at(0x0AAAAAA), stuck=(clock, level)), Limit=40)
            (done,) = np.flatnonzero(found["done"])
            assert found["lost"][done] and not found["crc_error"][done]
            assert found["position"][done] == 0 and not found["busy"][done:].any()
            if not level and not clock:
                assert done == START + 1 and found["clock"].all()
            ends = START + 1 + 26 * 100 - 50 + (100 if level else 40 * 100)
            assert done <= ends + 3


def test_slow_encoder__is_lost_when_its_monoflop_time_exceeds_the_limit():
    for monoflop, lost in ((4040, False), (4060, True)):
        found = read(Encoder(Word(), at(5), monoflop=monoflop), Limit=40)
        (done,) = np.flatnonzero(found["done"])
        assert found["lost"][done] == lost and found["position"][done] == (0 if lost else 5)


class SsiPort(Port):
    """With the registers."""

    top, ports = "ssi_port", PORTS


def test_port__line_breaks_and_good_frames_are_read_through_the_registers():
    """A frame, one with an alarm, a request during the monoflop time, and a line that is lost."""
    port = SsiPort(20000)
    port.read(2, "ID", "CONFIG", "STATUS")
    port.write(START, "CONTROL", start=1)
    port.write(START + 3500, "CONTROL", start=1)  # the monoflop time is not over
    port.read(START + 6000, "GOOD", "STATUS", "POSITION_LOW", "DELAY", "BAD")
    port.write(START + 6100, "TRIGGER", sample=1)
    port.write(START + 6101, "CONTROL", clear=1)
    port.sample[START + 6200] = 1
    port.read(START + 19000, "GOOD", "STATUS", "POSITION_LOW", "BAD")
    encoder = Encoder(Word(), lambda now: now, stuck=(START + 7000, 0))
    words, clock = port.run(encoder)
    assert words[:3] == [0x53534920, word("CONFIG", width=25, bit_clocks=100, limit=60), 0]
    valid = word("STATUS", valid=1, missed=1)
    assert words[3:8] == [1, valid, START + 1, MONOFLOP - 50 + 2, 0]
    assert words[8:] == [0, word("STATUS", lost=1), START + 1, word("BAD", lost=1)]
    assert (np.diff(falls(clock)) >= 100).all() and len(falls(clock)) == 2 * 26


def test_port__alarm_and_parity_are_bits_of_the_status():
    right = Word(20, gray=True, alarm=True, parity=1)
    encoder = Encoder(right, at(0xABCDE), alarm=True)
    for flip, status, position in (
        ((), word("STATUS", valid=1, error=1), 0xABCDE),
        ((7,), word("STATUS", crc=1), 0),
    ):
        port = SsiPort(7000, **right.parameters)
        port.write(START, "CONTROL", start=1)
        port.read(6000, "STATUS", "POSITION_LOW", "BAD")
        words, _ = port.run(replace(encoder, flip=flip))
        assert words == [status, position, word("BAD", crc=len(flip))]
