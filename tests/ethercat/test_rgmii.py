# SPDX-License-Identifier: Apache-2.0
"""The adapter to RGMII in front of the slave controller: frames as by MII, errors, link, delay.

The PHYs at the pins are written from the text of RGMII 2.0 (rgmii_harness.cpp). What the slave
answers is compared with the MII model and with the memory model.
"""

from __future__ import annotations

import re
from random import Random

import pytest

from asip_asm.project import ROOT
from sim.bus.clocks import read
from sim.bus.datagram import APWR, LRW, answer, single
from sim.bus.gen import esc_regmap
from sim.bus.line import Line
from sim.bus.register import ByteRegister
from tests.bench.seed import SEED
from tests.ethercat.frames import MEMORY, Datagram, frame
from tests.ethercat.rgmii import DOWN, PERIOD_PS, UP, Phy, Rgmii
from tests.ethercat.test_frames import STATION, check, random_chain, set_up

CLOCK_PS, NIBBLE_NS = 10_000, 40
PHASES = range(0, PERIOD_PS, 2_500)
BETWEEN = 1_250  # no edge of RXC falls upon one of the slave's clock
STATUS_NIBBLES = 8
FRAMES, WHOLE_NS = 4, 300_000  # in each phase; until the longest is back and written
LINKED = (Phy(), Phy())
WRITE = single(APWR, 0, MEMORY, b"\xa5\x5a\xa5\x5a")
BYTE = ByteRegister("MEMORY", MEMORY, 1)
HEADER = (ROOT / "rtl/ethercat/mii_to_rgmii.sv").read_text().split("module")[0]
PAGE = (ROOT / "docs/ethercat.md").read_text()


def stated(pattern: str, text: str) -> int:
    """The number that a text states."""
    (found,) = re.findall(pattern, re.sub(r"\s*(//)?\s*\n(// )?", " ", text))
    return int(found)


@pytest.mark.quick("0-*")
@pytest.mark.parametrize("frames", [FRAMES, pytest.param(24, marks=pytest.mark.full)])
@pytest.mark.parametrize("phase", PHASES)
def test_frames__answered_as_by_mii_in_every_phase(phase: int, frames: int):
    random = Random(f"{SEED} {phase}")
    phy = Phy(
        phase=phase,
        high=random.choice((16_000, 20_000, 24_000)),
        delay=random.choice((1_500, 2_000, 2_500)),
        repeat=random.random() < 0.5,
    )
    ppm = random.choice((-200.0, 0.0, 200.0))
    with Rgmii((phy, Phy(status=DOWN)), ppm) as rgmii, Line() as mii:
        print(f"SEED={SEED}: {phy}, {ppm} ppm")
        state = random.getstate()
        slave = set_up(rgmii, random)
        random.setstate(state)
        set_up(mii, random)
        for _ in range(frames):
            chain = random_chain(random)
            for line in (rgmii, mii):
                line.send(frame(chain))
                line.run(WHOLE_NS)
            ours, theirs = rgmii.receive(), mii.receive()
            assert ours.good and (ours.data, ours.nibbles) == (theirs.data, theirs.nibbles)
            slave.process(chain)
            check(rgmii, slave, [Datagram(4, bytes(32), STATION, MEMORY + 0x100)])
            mii.run(WHOLE_NS)


@pytest.mark.parametrize("sizes", [(1, 1480), (700, 1)])
def test_frames__longest_with_clocks_that_differ(sizes):
    for ppm in (-200.0, 200.0):
        with Rgmii(ppm=ppm) as rgmii:
            for size in sizes:
                sent = single(LRW, 0, 1, bytes(range(256)) * 6)[: 28 + size].ljust(60, b"\0")
                back = rgmii.exchange(sent)
                assert back.good and back.data == sent


def test_frames__by_both_ports():
    with Rgmii((Phy(phase=3_000), Phy(phase=17_000))) as rgmii, Line(closed=True) as mii:
        for line in (rgmii, mii):
            line.send(WRITE)
            line.run(40_000)
        ours, theirs = rgmii.receive(1), mii.receive(1)
        assert ours.good and ours.data == theirs.data and answer(ours.data, 4)[1] == 1
        assert rgmii.receive(0) is None
        rgmii.send(ours.data, port=1)
        rgmii.run(40_000)
        back = rgmii.receive(0)
        assert back.good and back.data == ours.data


def test_transmitter__clock_is_in_the_middle_of_the_data():
    with Rgmii(LINKED) as rgmii:
        for port in (0, 1):
            rgmii.send(WRITE, port=port)
            rgmii.run(40_000)
        for port in (0, 1):
            assert rgmii.receive(1 - port).good
            margins = rgmii.margins(port)
            assert margins.setup == margins.hold == CLOCK_PS
            assert margins.shortest == margins.longest == PERIOD_PS
            assert margins.errors == margins.unlike == 0


@pytest.mark.parametrize("repeat", [False, True])
def test_receive_error__arrives_as_one(repeat: bool):
    with Rgmii((Phy(phase=7_000, repeat=repeat), Phy(status=DOWN))) as rgmii:
        assert not rgmii.exchange(WRITE, error_at=50).good
        assert read(rgmii, 0, esc_regmap.RX_ERRORS_0) == 1
        assert read(rgmii, 0, esc_regmap.INVALID_FRAMES_0) == 1
        assert read(rgmii, 0, BYTE) == 0
        assert rgmii.exchange(WRITE).good
        assert read(rgmii, 0, BYTE) == 0xA5
        assert read(rgmii, 0, esc_regmap.RX_ERRORS_0) == 1


@pytest.mark.parametrize("status", range(16), ids=lambda status: f"{status:04b}")
def test_status__only_100_in_full_duplex_is_a_link(status: int):
    with Rgmii((Phy(status=status), Phy())) as rgmii:
        assert rgmii.link(0) == (status == UP)
        rgmii.status(0, UP)
        rgmii.run(1_000)
        assert rgmii.link(0)
        rgmii.status(0, status)
        rgmii.run(1_000)
        assert rgmii.link(0) == (status == UP)


def test_status__the_slave_opens_and_closes_the_port_by_it():
    with Rgmii(LINKED) as rgmii:
        rgmii.send(WRITE)
        rgmii.run(40_000)
        assert rgmii.receive(1).good
        rgmii.status(1, DOWN)
        rgmii.run(1_000)
        assert rgmii.exchange(WRITE).good and rgmii.receive(1) is None
        assert read(rgmii, 0, esc_regmap.LOST_LINKS_1) == 1


def test_status__changes_behind_eight_nibbles_not_counting_frames():
    with Rgmii(LINKED) as rgmii:
        for nibble, link in ((DOWN, True), (UP, False)):
            rgmii.status(0, nibble)
            rgmii.run((STATUS_NIBBLES - 1) * NIBBLE_NS)
            assert rgmii.link(0) == link
            rgmii.run(3 * NIBBLE_NS)
            assert rgmii.link(0) != link
        rgmii.status(0, DOWN)
        rgmii.run((STATUS_NIBBLES - 3) * NIBBLE_NS)
        rgmii.status(0, UP)
        rgmii.run(2_000)
        assert rgmii.link(0)
        rgmii.send(WRITE, gap=2)  # a nibble of a frame is no status
        rgmii.run(40_000)
        assert rgmii.link(0) and rgmii.receive(1).good


def test_link__falls_without_the_clock_and_comes_back():
    clocks = stated(r"falls (\d+) clocks after the clock that sampled the last edge of RXC", HEADER)
    with Rgmii(LINKED) as rgmii:
        rgmii.stop()
        rgmii.run((clocks - 2) * 10)
        assert rgmii.link(0)
        rgmii.run(40)
        assert not rgmii.link(0) and rgmii.link(1)
        rgmii.stop(stopped=False)
        rgmii.run((STATUS_NIBBLES + 3) * NIBBLE_NS)
        assert rgmii.link(0)


@pytest.mark.parametrize(
    ("period", "status"), [(8_000, 0b1101), (400_000, 0b1001), (400_000, UP), (8_000, DOWN)]
)
def test_other_speed__is_no_link_in_any_phase(period: int, status: int):
    for phase in range(0, 10_000, 1_000):
        phy = Phy(phase=phase, period=period, high=period // 2, status=status, repeat=False)
        with Rgmii((phy, Phy())) as rgmii:
            rgmii.send(WRITE * 4)
            for _ in range(40):
                rgmii.run(500)
                assert not rgmii.link(0)
            assert rgmii.receive(1) is None


def test_delay__is_constant_in_each_phase():
    receive = stated(r"Latency: (\d+) clocks, from the clock that samples RXC low", HEADER)
    added = stated(r"a nibble comes (\d+) clocks later than by MII", HEADER)
    send = stated(r"latency (\d+) clock, from mii_tx", HEADER)
    assert added == stated(r"a frame arrives (\d+) clocks later", PAGE)
    assert send == stated(r"and leaves (\d+) clock later", PAGE)
    delays = []
    for phase in PHASES:
        with Rgmii((Phy(phase=phase + BETWEEN), Phy())) as rgmii:
            seen = set()
            for n in range(6):
                rgmii.send(single(LRW, 0, 1, bytes(1 + 240 * n)))
                rgmii.run(140_000)
                back = rgmii.receive(1)
                assert back.good
                seen.add(back.began - rgmii.began(n))
            assert len(seen) == 1, "between frames of one phase"
            delays += seen
            rgmii.send(WRITE, port=1)
            rgmii.run(40_000)
            assert rgmii.receive(0).good
            found = rgmii.latencies()
            assert found.falling == (receive, receive)
            assert found.rising == (added, added)
            assert found.transmit == (send, send)
    assert max(delays) - min(delays) < PERIOD_PS
    print(f"port to port: {min(delays) / 1000} to {max(delays) / 1000} ns")
