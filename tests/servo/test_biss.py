# SPDX-License-Identifier: Apache-2.0
"""BiSS-C master against a model of an encoder: positions, CRC, delays, a lost encoder.

The model answers the edges of MA as the BiSS C protocol description (iC-Haus) says; its CRC is
polynomial division of whole numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pytest

from tests.bench.seed import SEED
from tests.servo.clocked import Clocked

WIDTH, CLOCKS_PER_BIT, LIMIT = 26, 10, 400  # the block's own
POLYNOMIAL = 0x43  # x^6 + x + 1
OUTPUTS = ("ma", "busy", "done", "position", "error", "warning", "crc_error", "lost", "delay")
START = 20  # clock of the request


def remainder(bits: list[int], polynomial: int = POLYNOMIAL, start: int = 0) -> int:
    """Of the bits, times x^n, modulo the polynomial of degree n; start: of the register."""
    degree = polynomial.bit_length() - 1
    value = int("".join(map(str, bits)), 2) << degree ^ start << len(bits)
    while value.bit_length() > degree:
        value ^= polynomial << (value.bit_length() - degree - 1)
    return value


@dataclass
class Encoder:
    """Line of an encoder as a function of MA, both a level per clock at the master."""

    position: int = 0
    error: bool = False
    warning: bool = False
    wait: int = 2  # bits of acknowledge
    delay: int = 0  # clocks of the line, there and back
    timeout: int = 120  # clocks without an edge until it is ready
    flip: int | None = None  # this bit of the frame is wrong
    width: int = WIDTH
    later: tuple[Encoder, ...] = ()  # what it sends in the frames after this one

    def frame(self) -> list[int]:
        """Bits from the second rising edge on."""
        data = [self.position >> bit & 1 for bit in reversed(range(self.width))]
        data += [int(not self.error), int(not self.warning)]
        crc = [1 - (remainder(data) >> (5 - bit) & 1) for bit in range(6)]
        bits = [*[0] * self.wait, 1, 0, *data, *crc]
        if self.flip is not None:
            bits[self.wait + 2 + self.flip] ^= 1
        return bits

    def line(self, ma: np.ndarray) -> np.ndarray:
        """SLO for each clock."""
        frames = [each.frame() for each in (self, *self.later)]
        bits: list[int] = []
        slo = np.ones(len(ma), dtype=np.int64)
        edges, last, level = 0, -self.timeout, 1
        for now in range(1, len(ma)):
            if ma[now] != ma[now - 1]:
                if ma[now]:
                    edges += 1
                    if edges == 1 and frames:  # it takes its position
                        bits = frames.pop(0)
                    place = edges - 2
                    if place >= 0:
                        level = bits[place] if place < len(bits) else 0
                last = now
            elif now - last >= self.timeout:
                edges, level = 0, 1
            slo[now] = level
        return np.concatenate([np.ones(self.delay, dtype=np.int64), slo])[: len(ma)]


class Silent(Encoder):
    """No encoder: its line stays high."""

    def line(self, ma: np.ndarray) -> np.ndarray:
        return np.ones(len(ma), dtype=np.int64)


class Answers(Protocol):
    """An encoder: its line as a function of what the master drives (the clock, and for EnDat the
    data and their direction), each a level per clock at the master."""

    @property
    def line(self) -> Callable[..., np.ndarray]: ...


def with_encoder(
    block: Clocked,
    encoder: Answers,
    frames: int,
    clocks: int,
    ports: tuple[str, ...] = ("ma", "slo"),
    **inputs: np.ndarray,
) -> dict[str, np.ndarray]:
    """Outputs of a block with the encoder at the end of its line, for so many frames at most;
    ports: what the encoder sees, the clock first, and the line."""
    *seen, line = ports
    level = np.ones(clocks, dtype=np.int64)
    for _ in range(2 * frames + 2):  # each round carries the answer further
        found = block.run(clocks, **inputs, **{line: level})
        answer = encoder.line(*(found[name] for name in seen))
        if (answer == level).all():
            return found
        level = answer
    raise AssertionError("the block and the encoder do not come to rest")


def read(encoder: Encoder, clocks: int = 1500, starts: tuple[int, ...] = (START,)):
    """Outputs of the master, with the encoder at its end."""
    master = Clocked("biss_master", ("start", "slo"), OUTPUTS)
    start = np.isin(np.arange(clocks), starts)
    return with_encoder(master, encoder, len(starts), clocks, start=start)


@pytest.mark.parametrize("delay", [0, 1, 4, 9, 10, 37, 250])
def test_frame__position_and_bits_arrive_at_any_delay(delay):
    random = np.random.default_rng([SEED, delay])
    for wait in (1, 3, 12):
        position = int(random.integers(0, 1 << WIDTH))
        error, warning = (bool(bit) for bit in random.integers(0, 2, 2))
        found = read(Encoder(position, error, warning, wait, delay))
        (done,) = np.flatnonzero(found["done"])
        assert found["position"][done] == position
        assert (found["error"][done], found["warning"][done]) == (error, warning)
        assert not found["lost"][done] and not found["crc_error"][done]
        assert found["delay"][done] == delay + 2  # the synchroniser


def test_clock__10_mhz_begins_low_and_ends_high():
    found = read(Encoder(position=0x2AAAAAA))
    ma = found["ma"]
    falls = np.flatnonzero((ma[1:] == 0) & (ma[:-1] == 1))
    rises = np.flatnonzero((ma[1:] == 1) & (ma[:-1] == 0))
    assert falls[0] == START and (np.diff(falls) == CLOCKS_PER_BIT).all()
    assert (rises[: len(falls) - 1] - falls[:-1] == CLOCKS_PER_BIT // 2).all()
    assert ma[-1] == 1 and ma[:START].all()


def test_wrong_bit_anywhere__is_a_crc_error_and_the_position_stays():
    for flip in range(WIDTH + 8):
        found = read(Encoder(position=0x155AA55, flip=flip))
        (done,) = np.flatnonzero(found["done"])
        assert found["crc_error"][done] and found["position"][done] == 0 and not found["lost"][done]


def test_frames_one_after_another__each_is_read():
    found = read(Encoder(position=0x3FFFFFF), 4000, (START, 1200, 2400))
    assert len(np.flatnonzero(found["done"])) == 3
    assert found["position"][-1] == 0x3FFFFFF and not found["lost"].any()


def test_no_encoder__is_lost_within_its_limit():
    found = read(Silent(), 6000)
    (done,) = np.flatnonzero(found["done"])
    assert found["lost"][done] and done - START <= LIMIT * CLOCKS_PER_BIT + 3
    assert not found["busy"][done + 1 :].any() and found["ma"][-1] == 1


def test_line_low_at_the_request__is_lost_at_once():
    master = Clocked("biss_master", ("start", "slo"), OUTPUTS)
    start = np.arange(100) == START
    found = master.run(100, start=start, slo=0)
    assert np.flatnonzero(found["done"]).tolist() == [START + 1] and found["lost"][-1]
    assert found["ma"].all()


def test_no_start_bit__is_lost():
    found = read(Encoder(wait=450), 6000)
    (done,) = np.flatnonzero(found["done"])[:1]
    assert found["lost"][done] and found["position"][done] == 0
