# SPDX-License-Identifier: Apache-2.0
"""EnDat master and its port against a model of an encoder: commands, CRC, delays, a broken line.

The model follows the makers' documents (HEIDENHAIN: EnDat 2.2 technical information, PWM 20
manual): the first falling edge of the clock takes the position, the rising edges 3 to 8 the mode
command; from the tenth on the encoder has the line, low until the start bit. Each rising edge then
brings a bit. A clock that rests high for the recovery time ends a cycle; a clock too many makes
the encoder ignore the next one. Its CRC is polynomial division of whole numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.bench.seed import SEED
from tests.servo.clocked import Clocked
from tests.servo.test_biss import remainder, with_encoder
from tests.servo.test_biss_port import Port, falls, word
from tests.servo.test_ssi import at

OUTPUTS = (
    *("clock", "data", "data_en", "busy", "done"),
    *("position", "error", "crc_error", "lost", "delay"),
)
PORTS = ("clock", "data", "data_en", "data")
POLYNOMIAL = 0x2B  # x^5 + x^3 + x + 1
COMMANDS = {False: [0, 0, 0, 1, 1, 1], True: [1, 1, 1, 0, 0, 0]}
START = 20  # clock of the first request
FIRST_BIT = 12  # pulse that brings the start bit of an encoder without calculation time


def check(bits: list[int]) -> int:
    """CRC of the bits, the first sent first."""
    return remainder(bits, POLYNOMIAL, 0x1F) ^ 0x1F


def from_low(value: int, width: int) -> list[int]:
    """Bits, least significant first."""
    return [value >> bit & 1 for bit in range(width)]


@dataclass(frozen=True)
class Frame:
    """What the encoder sends, and how fast: clocks of a bit, of the recovery time, of a slow bit,
    and more clocks of the first low phase, as the block's parameters."""

    width: int = 25
    endat22: bool = True
    clocks_per_bit: int = 14
    recovery: int = 1000
    measure: int = 400
    start: int = 200
    limit: int = 100

    def bits(self, position: int, f1: bool, f2: bool) -> list[int]:
        """After the start bit, in the order on the line."""
        data = [int(f1), *[int(not f2)] * self.endat22, *from_low(position, self.width)]
        return [*data, *reversed(from_low(check(data), 5))]

    @property
    def parameters(self) -> dict[str, int]:
        """Of the block."""
        return {
            "Width": self.width,
            "Endat22": int(self.endat22),
            "ClocksPerBit": self.clocks_per_bit,
            "RecoveryClocks": self.recovery,
            "MeasureClocks": self.measure,
            "StartClocks": self.start,
            "Limit": self.limit,
        }

    def period(self, slow: bool) -> int:
        """Clocks of a bit."""
        return self.measure if slow else self.clocks_per_bit

    @property
    def apart(self) -> int:
        """Clocks from a request to the next one, with any frame that is not lost in between."""
        return self.start + (self.width + 25) * self.measure + self.recovery + 200


@dataclass(frozen=True)
class Encoder:
    """An encoder and its line. position: of a clock; f1, f2: its errors; calculation: clocks until
    the start bit, at least; recovery: clocks; idle: level of the line that nobody drives; flip:
    these bits after the start bit are wrong; stuck: from that clock on at that level; drift: from
    that clock on so many clocks more of delay; absent: not there until that clock."""

    frame: Frame
    position: Callable[[int], int]
    f1: bool = False
    f2: bool = False
    calculation: int = 0
    recovery: int = 900
    delay: int = 0  # clocks of the line, there and back
    idle: int = 0
    flip: tuple[int, ...] = ()
    stuck: tuple[int, int] | None = None
    drift: tuple[int, int] = (0, 0)
    absent: int = 0

    def answer(self, position: int) -> list[int]:
        """The start bit and the bits after it."""
        bits = self.frame.bits(position, self.f1, self.f2)
        return [1, *(bit ^ int(place in self.flip) for place, bit in enumerate(bits))]

    def line(self, clock: np.ndarray, data: np.ndarray, enable: np.ndarray) -> np.ndarray:
        """Level of the data line at the master for each clock."""
        clocks, there = len(clock), self.delay // 2
        driven = np.where(enable, data, self.idle)
        ma, sent, has = (
            np.concatenate([np.full(there, first), each])[:clocks].tolist()
            for first, each in ((1, clock), (self.idle, driven), (0, enable))
        )
        own = np.full(clocks, -1)
        now_own, quiet, state = -1, 0, "ready"
        rises = began = 0
        command: list[int] = []
        bits: list[int] = []
        for now in range(1, clocks):
            quiet = quiet + 1 if ma[now] and ma[now - 1] else 0
            if quiet == self.recovery and state != "ready":
                state, now_own = ("ignores" if state == "too many" else "ready"), -1
            if not ma[now] and ma[now - 1]:
                if state == "ready":  # it takes its position
                    bits, command, rises, began = self.answer(self.position(now)), [], 0, now
                    state = "cycle"
                elif state == "ignores":
                    state = "silent"
            elif ma[now] and not ma[now - 1]:
                rises += 1
                if state == "ends":
                    state, now_own = "too many", 0
                elif state == "cycle":
                    if 3 <= rises <= 8:
                        assert has[now], "nobody sends the command"
                        command.append(sent[now])
                    if rises == 10:
                        known = command == COMMANDS[self.frame.endat22]
                        state, now_own = ("cycle", 0) if known else ("silent", -1)
                    started = len(bits) <= len(self.frame.bits(0, False, False))
                    late = now - began < self.calculation
                    if state == "cycle" and rises >= FIRST_BIT and (started or not late):
                        now_own = bits.pop(0)
                        state = "cycle" if bits else "ends"
            assert now_own < 0 or not has[now], "both drive the line"
            own[now] = now_own
        times = np.arange(clocks)
        back = self.delay - there + np.where(times >= self.drift[0], self.drift[1], 0)
        heard = np.where(times < self.absent, -1, own[np.maximum(times - back, 0)])
        level = np.where(enable, data, np.where(heard < 0, self.idle, heard))
        if self.stuck:
            level[self.stuck[0] :] = self.stuck[1]
        return level


def read(encoder: Encoder, frames: int = 1, more: int = 0):
    """Outputs of the master, with the encoder at its end and so many requests; more: clocks."""
    frame = encoder.frame
    apart = frame.apart + more
    master = Clocked("endat_master", ("start", "data"), OUTPUTS, frame.parameters)
    clocks = START + frames * apart
    start = np.isin(np.arange(clocks), START + apart * np.arange(frames))
    return with_encoder(master, encoder, frames, clocks, PORTS, start=start)


def pulses(found: dict[str, np.ndarray], start: int, end: int) -> np.ndarray:
    """Clocks of the falling edges of the clock between two clocks."""
    all_falls = falls(found["clock"])
    return all_falls[(all_falls > start) & (all_falls <= end)]


FRAMES = [
    Frame(),
    Frame(13, endat22=False, clocks_per_bit=50, start=0),
    Frame(48, clocks_per_bit=6, measure=100, start=1),
    Frame(1, endat22=False, clocks_per_bit=254, measure=254),
]


def test_crc__is_that_of_published_values():
    """Examples of an EnDat library (thiagoesteves/endat): a parameter of 8 and 16 bits, most
    significant first, and F1 with a position of 25 bits, from a high and a low word."""
    number = 100 << 16 | 10000
    assert check(list(reversed(from_low(number, 24)))) == 30
    assert check([0, *from_low(1000 << 32 | 1234324343, 25)]) == 29


@pytest.mark.quick("25")
@pytest.mark.parametrize("frame", FRAMES, ids=lambda frame: f"{frame.width}")
def test_frame__position_and_errors_arrive_at_any_delay_with_one_pulse_a_bit(frame):
    """The first frame is slow and measures the delay; those after it are fast."""
    random = np.random.default_rng([SEED, frame.width])
    bit = frame.clocks_per_bit
    most = min(frame.measure - 4, 9 * bit)
    delays = {0, 1, bit - 3, bit - 2, bit - 1, bit, int(random.integers(most)), most}
    for delay in sorted(delay for delay in delays if delay <= most):
        position = int(random.integers(0, 1 << frame.width))
        f1, f2, idle = (bool(one) for one in random.integers(0, 2, 3))
        encoder = Encoder(frame, at(position), f1, f2, delay=delay, idle=int(idle))
        found = read(encoder, 2)
        done = np.flatnonzero(found["done"])
        assert len(done) == 2 and not found["lost"].any() and not found["crc_error"].any()
        assert (found["position"][done] == position).all()
        assert (found["error"][done] == (f1 or (f2 and frame.endat22))).all()
        assert (found["delay"][done] == delay + 2).all()
        for number, end in enumerate(done):
            start = START + number * frame.apart
            edges = pulses(found, start, start + frame.apart)
            assert edges[0] == start + 1
            assert len(edges) == FIRST_BIT + len(frame.bits(0, False, False))
            period = frame.period(not number)
            low = frame.start * (np.arange(len(edges)) > 0)
            assert (edges == start + 1 + low + period * np.arange(len(edges))).all()
            last_rise = edges[-1] + period // 2
            assert end == last_rise + delay + period // 2 + 2
            (idles,) = np.flatnonzero(np.diff(found["busy"][end:]))[:1] + end + 1
            assert idles == end + frame.recovery


@pytest.mark.quick("8")
@pytest.mark.parametrize("delay", [8, 12, 13, 14, 26, 60])
def test_delay_that_drifts__still_one_pulse_a_bit(delay):
    """By a third of a bit either way, also across a whole bit."""
    frame = Frame(20)
    for drift in (-4, -1, 1, 4):
        encoder = Encoder(frame, at(0xABCDE), delay=delay, drift=(START + frame.apart, drift))
        found = read(encoder, 3)
        assert found["done"].sum() == 3 and not found["lost"].any()
        assert not found["crc_error"].any() and found["position"][-1] == 0xABCDE
        for start in START + frame.apart * np.arange(3):
            assert len(pulses(found, start, start + frame.apart)) == FIRST_BIT + 27


@pytest.mark.parametrize("endat22", [False, True], ids=["2.1", "2.2"])
def test_command__is_on_the_line_while_the_master_has_it(endat22):
    found = read(Encoder(Frame(endat22=endat22), at(5), idle=int(not endat22)))
    edges = falls(found["clock"])
    rises = edges[:9] + 200
    rises[0] += 200  # the first low phase
    sent = np.flatnonzero(found["data_en"])
    assert sent.min() == edges[1] and sent.max() == edges[8] - 1
    assert found["data"][rises[2:8]].tolist() == COMMANDS[endat22]
    assert not found["data"][edges[1] : edges[2]].any()


def test_position_that_moves__is_that_of_the_first_falling_edge():
    encoder = Encoder(Frame(), lambda now: 37 * now, delay=40)
    found = read(encoder, 2)
    done = np.flatnonzero(found["done"])
    starts = START + encoder.frame.apart * np.arange(2)
    assert found["position"][done].tolist() == (37 * (starts + 1 + 20)).tolist()


@pytest.mark.parametrize("endat22", [False, True], ids=["2.1", "2.2"])
def test_wrong_bit_anywhere__is_a_crc_error_and_the_position_stays(endat22):
    frame = Frame(13, endat22, measure=100)
    bits = len(frame.bits(0, False, False))
    for flip in [*((place,) for place in range(bits)), (3, 4), (0, bits - 1)]:
        found = read(Encoder(frame, at(0x1234), flip=flip, delay=30), 2)
        done = np.flatnonzero(found["done"])
        assert len(done) == 2 and found["crc_error"][done].all() and not found["lost"].any()
        assert not found["position"].any() and not found["error"].any()


def test_late_start_bit__is_waited_for_until_the_limit():
    """The first request is slow, the second one fast, the third slow again: one was lost."""
    frame = Frame(limit=40)
    bit = frame.clocks_per_bit
    for pulse, lost in ((38, False), (39, False), (40, True)):  # of the fast frame's start bit
        rise = frame.start + bit // 2 + (pulse - 1) * bit
        encoder = Encoder(frame, at(7), calculation=rise)
        found = read(encoder, 3)
        done = np.flatnonzero(found["done"])
        assert found["lost"][done].tolist() == [False, lost, False]
        assert found["position"][-1] == 7
        third = pulses(found, START + 2 * frame.apart, START + 3 * frame.apart)
        assert np.diff(third)[-1] == frame.period(lost)


def test_line_breaks__at_any_time_no_position():
    """Stuck from the request on: lost. Within the frame: lost or a wrong CRC."""
    frame = Frame(limit=40)
    for level in (0, 1):
        for clock in (0, START + 700, START + 14 * 400 + 200, START + 25 * 400):
            found = read(Encoder(frame, at(0x0AAAAAA), stuck=(clock, level)))
            (done,) = np.flatnonzero(found["done"])
            assert found["lost"][done] or found["crc_error"][done]
            assert found["position"][done] == 0 and found["clock"][done:].all()
            if clock <= START + 700:
                assert found["lost"][done] and not found["crc_error"][done]
                assert done == START + 1 + frame.start + 40 * 400 - 200
            assert not found["busy"][done + frame.recovery :].any()


def test_no_encoder__is_lost_and_the_next_frame_is_found():
    """Without an encoder at the first request, the line at either level."""
    frame = Frame(limit=30)
    for idle in (0, 1):
        found = read(Encoder(frame, at(9), idle=idle, absent=START + frame.apart), 2)
        done = np.flatnonzero(found["done"])
        assert found["lost"][done].tolist() == [True, False] and found["position"][-1] == 9


def test_short_recovery_time__may_be_set_with_a_measuring_clock_of_1_mhz():
    frame = Frame(recovery=375, measure=100)
    found = read(Encoder(frame, at(11), recovery=125, delay=90), 3)
    assert found["done"].sum() == 3 and found["position"][-1] == 11 and not found["lost"].any()


class EndatPort(Port):
    """With the registers."""

    top, ports = "endat_port", PORTS


def test_port__frames_a_dropped_request_and_a_broken_line_are_read_through_the_registers():
    """The block as it is without parameters."""
    frame = Frame(recovery=3000, limit=400)
    apart = frame.apart
    port = EndatPort(4 * apart)
    port.read(2, "ID", "CONFIG", "STATUS")
    port.write(START, "CONTROL", start=1)
    port.read(START + apart - 100, "GOOD", "STATUS", "POSITION_LOW", "POSITION_HIGH", "DELAY")
    port.write(START + apart, "TRIGGER", sample=1)
    port.sample[START + apart + 10] = 1
    end = START + apart + 10 + frame.start + 44 * 14 + 50  # in the recovery time
    port.read(end, "GOOD", "STATUS", "POSITION_LOW")
    port.sample[end + 20] = 1
    port.read(end + 30, "STATUS", "BAD")
    port.write(START + 2 * apart - 10, "CONTROL", clear=1)
    port.sample[START + 2 * apart] = 1
    port.read(4 * apart - 100, "GOOD", "STATUS", "POSITION_LOW", "BAD")
    encoder = Encoder(frame, lambda now: now, delay=21, stuck=(START + 2 * apart + 50, 0))
    words, clock = port.run(encoder)
    assert words[:3] == [0x454E4454, word("CONFIG", width=25, bit_clocks=14, limit=400), 0]
    valid, second = word("STATUS", valid=1), START + apart + 10 + 1 + 10
    assert words[3:8] == [1, valid, START + 1 + 10, 0, 23]
    assert words[8:11] == [2, word("STATUS", valid=1, busy=1), second]
    assert words[11:13] == [word("STATUS", valid=1, busy=1, missed=1), 0]
    assert words[13:] == [0, word("STATUS", lost=1), second, word("BAD", lost=1)]
    assert len(falls(clock)) == 2 * (FIRST_BIT + 32) + frame.limit


@pytest.mark.parametrize("endat22", [False, True], ids=["2.1", "2.2"])
def test_port__errors_and_a_wrong_crc_are_bits_of_the_status(endat22):
    frame = Frame(37, endat22, clocks_per_bit=12)
    position = 0x15_89AB_CDEF
    for f1, f2, flip in ((1, 0, ()), (0, 1, ()), (0, 0, ()), (1, 1, (20,))):
        encoder = Encoder(frame, at(position), bool(f1), bool(f2), flip=flip)
        port = EndatPort(frame.apart, **frame.parameters)
        port.write(START, "CONTROL", start=1)
        port.read(frame.apart - 50, "STATUS", "POSITION_LOW", "POSITION_HIGH", "BAD")
        words, _ = port.run(replace(encoder, flip=flip))
        if flip:
            assert words == [word("STATUS", crc=1), 0, 0, word("BAD", crc=1)]
            continue
        status = word("STATUS", valid=1, error=int(f1 or (f2 and endat22)))
        assert words == [status, position & 0xFFFFFFFF, position >> 32, 0]
