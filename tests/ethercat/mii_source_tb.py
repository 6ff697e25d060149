# SPDX-License-Identifier: Apache-2.0
"""cocotb side of the test with cocotbext-eth: what port 0 of `mii_slave` does with its frames.

Started by test_mii_source.py. Environment: SEED.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from random import Random

import cocotb
from cocotb.task import bridge

from sim.bus.datagram import APRD, APWR, BRD, FPRD, FPWR, LRW, answer, datagram, frame, single
from sim.bus.gen import esc_regmap
from sim.bus.line import GAP_NIBBLES, SEQUENCE_BYTES, check_sequence
from sim.cocotb.mii import Port
from tests.ethercat.frames import MEMORY, MEMORY_END, Datagram, Fmmu, Slave
from tests.ethercat.test_back_to_back import check_frames, random_chains
from tests.ethercat.test_frames import COMMIT_NS, STATION, check, random_chain, set_up

SEED = os.environ["SEED"]
CHAINS, GOOD = 100, 0.9
GROUPS, FRAMES = 8, 4
BAD_FRAMES = 10
CLEARED = 1024  # bytes a frame
LOGICAL = 0x10000
WRITE = single(APWR, 0, MEMORY, b"\xa5\x5a\xa5\x5a")


def scenario(talk: Callable[[Port, Random], None]) -> Callable:
    """A cocotb test of this name: `talk` to a port that is open, its slave out of reset."""

    @functools.wraps(talk)
    async def test(dut) -> None:
        random = Random(f"{talk.__name__} {SEED}")
        port = Port(dut, random)
        dut._log.info("SEED=%s: source %d ps late, %d ps a nibble", SEED, port.phase, port.period)
        await port.start()
        await bridge(talk)(port, random)

    return cocotb.test()(test)


def asked(port: Port, data: bytes, count: int) -> tuple[int, int]:
    """Value and counter of a frame's first datagram, of `count` bytes, when it is back."""
    back = port.exchange(data)
    assert back and back.good and len(back.data) == len(data)
    return answer(back.data, count)


def register(port: Port, address: int, count: int = 1) -> int:
    """Bytes of the slave, as a master reads them."""
    value, counter = asked(port, single(APRD, 0, address, bytes(count)), count)
    assert counter == 1
    return value


def modelled(port: Port, random: Random) -> Slave:
    """The model of a slave set up at random; its memory, which no reset clears, is zeros."""
    for address in range(MEMORY, MEMORY_END, CLEARED):
        assert asked(port, single(APWR, 0, address, bytes(CLEARED)), CLEARED) == (0, 1)
        port.run(COMMIT_NS * CLEARED)
    return set_up(port, random)


@scenario
def commands__answered_with_the_bytes_of_the_text(port: Port, random: Random) -> None:
    type_ = esc_regmap.TYPE
    assert asked(port, single(BRD, 0, type_.address, b"\0"), 1) == (type_.reset, 1)
    station = STATION.to_bytes(2, "little")
    assert asked(port, single(APWR, 0, 0x0010, station), 2) == (STATION, 1)
    for place, write in ((STATION, 1), (STATION + 1, 0)):
        assert asked(port, single(FPWR, place, MEMORY, b"\x12\x34"), 2) == (0x3412, write)
    assert asked(port, single(FPRD, STATION, MEMORY, bytes(2)), 2) == (0x3412, 1)
    fmmu = Fmmu(LOGICAL, 2, 0, 7, MEMORY, 0, read=True, write=True).registers()
    assert asked(port, single(APWR, 0, esc_regmap.FMMU_LOGICAL_START.at(0), fmmu), 16)[1] == 1
    logical = single(LRW, LOGICAL & 0xFFFF, LOGICAL >> 16, b"\x56\x78")
    assert asked(port, logical, 2) == (0x3412, 3)
    assert asked(port, logical, 2) == (0x7856, 3)
    two = frame(
        datagram(BRD, 0, type_.address, b"\0", more=True), datagram(APRD, 0, MEMORY, bytes(2))
    )
    assert asked(port, two, 1) == (type_.reset, 1)


@scenario
def chains__agree_with_the_memory_model(port: Port, random: Random) -> None:
    slave = modelled(port, random)
    for n in range(CHAINS):
        try:
            check(port, slave, random_chain(random), random.random() < GOOD)
        except AssertionError as error:
            raise AssertionError(f"chain {n}; again with SEED={SEED}: {error}") from error
    check(port, slave, [Datagram(3, random.randbytes(1486), 0, MEMORY)])


@scenario
def frames_at_the_least_gap__agree_with_the_memory_model(port: Port, random: Random) -> None:
    slave = modelled(port, random)
    for _ in range(GROUPS):
        port.sent.clear()
        check_frames(port, slave, random_chains(slave, random, FRAMES))
        gaps = [
            after.sim_time_start - before.sim_time_end - port.period
            for before, after in zip(port.sent, port.sent[1:], strict=False)
        ]
        assert gaps == [GAP_NIBBLES * port.period] * (FRAMES - 1), gaps


@scenario
def bad_frames__take_no_effect_and_are_counted(port: Port, random: Random) -> None:
    invalid, receive_errors = esc_regmap.INVALID_FRAMES_0, esc_regmap.RX_ERRORS_0
    right, before = check_sequence(WRITE), b"\x11\x22\x33\x44"
    assert asked(port, single(APWR, 0, MEMORY, before), 4)[1] == 1
    for n in range(BAD_FRAMES):
        flipped = int.from_bytes(right, "little") ^ 1 << random.randrange(32)
        wrong = {"sequence": flipped.to_bytes(4, "little")}
        marked = {"error_at": random.randrange(len(WRITE) + SEQUENCE_BYTES)}
        for m, options in enumerate((wrong, marked), 1):
            back = port.exchange(WRITE, **options)
            assert back and not back.good and len(back.data) == len(WRITE), options
            assert register(port, MEMORY, 4) == 0x44332211, options
            assert register(port, invalid.address) == 2 * n + m, options
            assert register(port, receive_errors.address) == n + m - 1, options
    assert asked(port, WRITE, 4)[1] == 1 and register(port, MEMORY, 4) == 0x5AA55AA5
    assert register(port, invalid.address) == 2 * BAD_FRAMES
    assert register(port, receive_errors.address) == BAD_FRAMES
