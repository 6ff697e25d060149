# SPDX-License-Identifier: Apache-2.0
"""The whole device in RTL, five axes enabled in OP, while a master floods its mailbox: no control
pass is late. Frames are made here and come at exact times; there is no master.
"""

from __future__ import annotations

import ctypes
import functools
import itertools
import multiprocessing
import os
import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from sim.bus.coe import sii
from sim.bus.coe.dictionary import Device, load
from sim.bus.datagram import APRD, APWR, ETHERNET, datagram, frame
from sim.bus.device import CYCLE_NS, IMAGES, WORD_CLOCKS, DeviceRtl
from sim.bus.gen import esc_regmap
from sim.bus.session import CSP, ENABLE, SHUTDOWN, START_NS, SWITCH_ON, outputs
from tests.ethercat import managers

AL_CONTROL, AL_STATUS = esc_regmap.AL_CONTROL.address, esc_regmap.AL_STATUS.address
MAILBOX_OUT, MAILBOX_IN, MAILBOX_BYTES = 0x1000, 0x1100, 256
OUTPUTS, INPUTS = 0x1200, 0x1800
PROFILE_POSITION = 1
POWER, POWER_AT = 0x10000, 20  # of the words of a tick
EMERGENCY, SDO_REQUEST, SDO_RESPONSE, INFORMATION = 1, 2, 3, 8  # services of CoE
# Between two frames; it comes at another place of the control cycle each time.
MESSAGE_NS, MESSAGES = 139_000, 7
SLOW = 100_000  # increments/s, object 607F
# Most clocks of a pass, by the control cycle in ns: nine tenths, so that one change of the program
# is not too many; at 62.5 us all but those that the machine needs for the words of a tick.
MOST = {100_000: 9000, 62_500: 6250 - WORD_CLOCKS}

# A frame of process data at 100 Mbit/s: preamble, headers, three datagrams, sequence, gap.
FRAME_NS = 80 * (8 + 14 + 2 + 3 * 12 + 101 + 101 + 6 + 4 + 12)


def sdo(service: int, data: bytes) -> bytes:
    return struct.pack("<H", service << 12) + data


def upload(index: int, subindex: int = 0, complete: bool = False) -> bytes:
    return sdo(SDO_REQUEST, struct.pack("<BHB4x", 0x50 if complete else 0x40, index, subindex))


def download(index: int, subindex: int, data: bytes) -> bytes:
    head = struct.pack("<BHBI", 0x21, index, subindex, len(data))
    return sdo(SDO_REQUEST, head + data)


def information(opcode: int, *words: int) -> bytes:
    data = struct.pack(f"<{len(words)}H", *words)
    return sdo(INFORMATION, struct.pack("<BBH", opcode, 0, 0) + data)


REQUESTS = {
    "uploads": [upload(0x1000), upload(0x8FFF), upload(0x1C32, 1), upload(0x1000)],
    "objects": [upload(0x1600, 0, True), upload(0x2020), upload(0x1C32, 0, True)],
    "downloads": [download(0x2020, 0, bytes(range(33, 33 + 200))), download(0x2000, 1, bytes(4))],
    "aborts": [upload(0x3000), download(0x1000, 0, bytes(4)), download(0x1018, 1, bytes(4))],
    "list": [information(1, 1)],
    "lengths": [information(1, 0)],
    "descriptions": [information(3, 0x1C32), information(5, 0x8081, 0x7000)],
}


def exchanged(path: Path) -> Iterator[tuple[int, int, bytes]]:
    """Offset in the device, working counter and data of each datagram in a capture."""
    data, at = path.read_bytes(), 24
    while at < len(data):
        (size,) = struct.unpack_from("<I", data, at + 8)
        body, place, more = data[at + 16 : at + 16 + size], len(ETHERNET) + 2, True
        at += 16 + size
        while more:
            offset, length = struct.unpack_from("<HH", body, place + 4)
            more, length = bool(length & 0x8000), length & 0x7FF
            (counter,) = struct.unpack_from("<H", body, place + 10 + length)
            yield offset, counter, body[place + 10 : place + 10 + length]
            place += 12 + length


def right(device: Device, answer: bytes) -> bool:
    """Whether an answer of the SDO server has the value of an object that nothing changes."""
    command, index, subindex = struct.unpack_from("<BHB", answer)
    if index not in (0x1000, 0x8FFF):
        return True
    return command == 0x43 and answer[4:8] == device.object(index).entry(subindex).data()


class Bench:
    """A device that was brought to OP, its axes enabled and moving."""

    def __init__(self, device: Device, mode: int, cycle_ns: int) -> None:
        self.device, self.mode, self.control, self.counter = device, mode, 0, 0
        self.rtl = DeviceRtl(cycle_ns)
        self.nowhere = os.open(os.devnull, os.O_WRONLY)  # answers are read from the capture
        self.rtl.run(START_NS)
        self.rtl.restart_counts()
        self.path, self.frames = itertools.count(), itertools.count()
        for n, (_, start, size, control) in enumerate(sii.managers(device)):
            self.write(esc_regmap.SM_START.at(n), managers.registers(start, size, control))
        for state in (2, 4, 8):
            self.write(AL_CONTROL, struct.pack("<H", state))
            for _ in range(2):
                self.exchange(1_000_000)
        for self.control in (SHUTDOWN, SWITCH_ON, ENABLE):
            for _ in range(3):
                self.exchange(1_000_000)

    def write(self, offset: int, data: bytes) -> None:
        self.send(datagram(APWR, 0, offset, data), 100_000)

    def send(self, datagrams: bytes, run_ns: int) -> None:
        self.rtl.send(frame(datagrams))
        self.rtl.run(run_ns)
        self.rtl.give(self.nowhere)

    def process_data(self) -> bytes:
        """All axes go on; in profile position each second frame has a new target, at once."""
        n = next(self.path)
        rises = self.control == ENABLE and self.mode == PROFILE_POSITION and n & 1
        values = {
            "controlword": self.control | (0x30 if rises else 0),
            "mode": self.mode,
            "target_position": 1000 * n,
            "velocity_offset": 100,
        }
        return outputs(self.device, values)

    def exchange(self, run_ns: int) -> None:
        """A frame of process data."""
        self.send(
            datagram(APWR, 0, OUTPUTS, self.process_data(), more=True)
            + datagram(APRD, 0, INPUTS, bytes(self.device.bytes("tx")), more=True)
            + datagram(APRD, 0, AL_STATUS, bytes(6)),
            run_ns,
        )

    def ask(self, message: bytes, run_ns: int) -> None:
        """A frame that takes what is in the mailbox and leaves a request."""
        self.counter = self.counter % 7 + 1
        head = struct.pack("<HHBB", len(message), 0, 0, 3 | self.counter << 4)
        self.send(
            datagram(APRD, 0, MAILBOX_IN, bytes(MAILBOX_BYTES), more=True)
            + datagram(APWR, 0, MAILBOX_OUT, (head + message).ljust(MAILBOX_BYTES, b"\0")),
            run_ns,
        )


@functools.cache
def bench_in(mode: int, cycle_ns: int) -> Bench:
    """The bench in OP, for copies of this process: to bring it there takes longer than a flood."""
    return Bench(load(), mode, cycle_ns)


def in_copy(
    function: Callable[..., dict],
    *arguments: object,
    mode: int = CSP,
    cycle_ns: int = CYCLE_NS,
) -> dict:
    """What the function gives in a copy of this process, so that no run sees one before it."""
    bench_in(mode, cycle_ns)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        return pool.apply(function, (*arguments, mode, cycle_ns))


def flood(
    requests: list[bytes], cycles: int, capture: Path, mode: int, cycle_ns: int
) -> dict[str, object]:
    """What came of so many cycles of process data while requests come without a pause."""
    bench = bench_in(mode, cycle_ns)
    rtl, device = bench.rtl, bench.device
    rtl.capture(capture)
    asked = itertools.cycle(requests)
    rtl.restart_counts()
    began = rtl.now
    for _ in range(cycles * MESSAGES):
        if next(bench.frames) % MESSAGES == 0:
            bench.exchange(MESSAGE_NS)
        elif requests:
            bench.ask(next(asked), MESSAGE_NS)
        else:
            rtl.run(MESSAGE_NS)
    counts, passed = rtl.counts(), rtl.now - began
    powered = all(word & POWER for word in rtl.outputs[POWER_AT : POWER_AT + 5])
    console = rtl.console
    ctypes.CDLL(None).fflush(None)  # the capture; the model's threads, to close it, are not here
    answers, wrong, state = 0, 0, None
    for offset, counter, data in exchanged(capture):
        if offset == MAILBOX_IN and counter:
            answers += data[7] >> 4 in (SDO_REQUEST, SDO_RESPONSE, INFORMATION)
            wrong += data[7] >> 4 == SDO_RESPONSE and not right(device, data[8:])
        if offset == AL_STATUS and counter:
            state = struct.unpack_from("<HxxH", data)
    return {
        "longest": counts["longest"],
        "mean": counts["sum"] // counts["ticks"],
        "ticks": counts["ticks"],
        "wanted": passed // (1000 * cycle_ns),
        "overrun": counts["overrun"],
        "answers": answers,
        "wrong": wrong,
        "state": state,
        "powered": powered,
        "console": console,
    }


@pytest.mark.quick("100000-uploads-*")
@pytest.mark.parametrize(
    ("requests", "mode"), [*((name, CSP) for name in REQUESTS), ("objects", PROFILE_POSITION)]
)
@pytest.mark.parametrize("cycle_ns", IMAGES)
def test_flooded_mailbox__no_pass_is_late(tmp_path, requests, mode, cycle_ns):
    place = tmp_path / "flood.pcap"
    found = in_copy(flood, REQUESTS[requests], 12, place, mode=mode, cycle_ns=cycle_ns)
    assert found["state"] == (8, 0) and found["powered"] and found["console"] == "", found
    assert found["longest"] < MOST[cycle_ns] and not found["overrun"], found
    assert abs(found["ticks"] - found["wanted"]) <= 1, found
    assert found["answers"] > 12 and not found["wrong"], found


def states_and_frames(mode: int, cycle_ns: int) -> dict[str, object]:
    """Passes of the device whose mailbox's manager is written in OP, with targets faster than 607F,
    until no frames come any more. Frames have the least gap, at 62.5 us one comes in each cycle."""
    bench = bench_in(mode, cycle_ns)
    rtl = bench.rtl
    for _ in range(20):
        bench.exchange(139_000)
        bench.write(0x800, struct.pack("<HHB", MAILBOX_OUT, MAILBOX_BYTES, 0x26))
    for axis in range(5):
        slow = download(0x607F + 0x800 * axis, 0, struct.pack("<I", SLOW))
        bench.ask(slow, 139_000)
    here = next(bench.path)
    for path, frames in (((here + 40, here - 40), 60), ((here,), 60)):  # it rests at the end
        bench.path = itertools.cycle(path)
        for _ in range(frames):
            bench.exchange(FRAME_NS if cycle_ns == CYCLE_NS else cycle_ns)
    powered = [bool(word & POWER) for word in rtl.outputs[POWER_AT : POWER_AT + 5]]
    rtl.run(30_000_000)
    left = [bool(word & POWER) for word in rtl.outputs[POWER_AT : POWER_AT + 5]]
    return {"powered": powered, "left": left, **rtl.counts()}


@pytest.mark.full
@pytest.mark.parametrize("cycle_ns", IMAGES)
def test_states_and_frames_without_a_pause__no_pass_is_late(cycle_ns):
    """To OP and the axes enabled; the manager of the mailbox written in OP; frames with the least
    gap, whose targets are faster than 607F; no frames any more: the device falls to SAFEOP."""
    found = in_copy(states_and_frames, cycle_ns=cycle_ns)
    assert all(found["powered"]) and not any(found["left"]), found
    assert found["longest"] < MOST[cycle_ns] and not found["overrun"], found
