# SPDX-License-Identifier: Apache-2.0
"""Datagrams as they pass: all commands, counters, chains at random against a memory model."""

from __future__ import annotations

from random import Random

import pytest
from scapy.contrib.ethercat import EtherCat
from scapy.layers.inet import IPOption
from scapy.layers.l2 import Ether

from sim.bus.gen import esc_regmap
from sim.bus.line import Line, check_sequence
from tests.bench.seed import SEED
from tests.ethercat.frames import (
    HEADER,
    MEMORY,
    Area,
    Datagram,
    Fmmu,
    Slave,
    frame,
    in_udp,
    out_of_udp,
    passed,
    random_fmmus,
    register_memory,
)

STATION = 0x1001
COMMIT_NS = 25  # of a byte written, two clocks and some
READABLE = ((0x0000, 12), (0x0010, 2), (0x0600, 0x80), (MEMORY, 0x2000))


def datagrams_of(data: bytes, shapes: list[Datagram]) -> list[tuple[bytes, int, int]]:
    """Data, position and counter of each datagram in a frame that has the shapes of these."""
    at, found = HEADER, []
    for shape in shapes:
        n = len(shape.data)
        position = int.from_bytes(data[at + 2 : at + 4], "little")
        counter = int.from_bytes(data[at + 10 + n : at + 12 + n], "little")
        found.append((data[at + 10 : at + 10 + n], position, counter))
        at += 12 + n
    return found


def check_answer(
    sent: bytes,
    back: bytes,
    chain: list[Datagram],
    wanted: list[tuple[bytes, int, int]],
    where: str = "",
) -> None:
    """Header and datagrams of a frame that is back are those of the model."""
    got = datagrams_of(back, chain)
    for n, (datagram, mine, theirs) in enumerate(zip(chain, wanted, got, strict=True)):
        position = datagram.logical & 0xFFFF if datagram.command in (10, 11, 12) else mine[1]
        assert (mine[0], position, mine[2]) == theirs, f"{where}datagram {n}: {datagram}"
    assert back[:HEADER] == passed(sent)[:HEADER]


def check(
    line: Line, slave: Slave, datagrams: list[Datagram], good: bool = True, udp: bool = False
) -> None:
    """Send them in a frame, good or with a wrong check sequence, or in UDP; what comes back must be
    what the model says."""
    plain = frame(datagrams)
    sent = in_udp(plain) if udp else plain
    back = line.exchange(sent, sequence=None if good else bytes(4))
    assert back is not None and back.good == good and len(back.data) == len(sent)
    data = out_of_udp(back.data) if udp else back.data
    check_answer(plain, data, datagrams, slave.process(datagrams, good))
    line.run(COMMIT_NS * sum(len(d.data) for d in datagrams))


def set_up(line: Line, random: Random, fmmus: bool = True) -> Slave:
    """Station address and FMMUs, in the RTL and in the model."""
    slave = register_memory()
    line.exchange(frame([Datagram(2, STATION.to_bytes(2, "little"), 0, 0x0010)]))
    slave.station = STATION
    slave.memory[0x0010:0x0012] = STATION.to_bytes(2, "little")
    slave.fmmus = random_fmmus(random) if fmmus else []
    for n in range(8):
        registers = slave.fmmus[n].registers() if n < len(slave.fmmus) else bytes(16)
        line.exchange(frame([Datagram(2, registers, 0, esc_regmap.FMMU_LOGICAL_START.at(n))]))
        slave.memory[0x0600 + 16 * n : 0x060D + 16 * n] = registers[:13]
    return slave


def random_datagram(random: Random, room: int) -> Datagram:
    command = random.randrange(15)
    length = min(room, random.choice((1, 1, 2, 4, 8, 13, 32, 100)))
    reads_registers = command in (1, 4, 7) and random.random() < 0.3
    first, size = random.choice(READABLE) if reads_registers else READABLE[-1]
    if reads_registers:
        length = min(length, size)
    offset = first + random.randrange(max(1, size - length + 1))
    if random.random() < 0.02:
        offset = 0x3000 - random.randrange(length + 3)  # over the end of the memory
    position = random.choice((0, 0, 0, 1, 0xFFFF))
    if command in (4, 5, 6, 14):
        position = random.choice((STATION, STATION, 0x1002))
    return Datagram(
        command,
        random.randbytes(length),
        position,
        offset,
        logical=0x10000 - 4 + random.randrange(100),
        counter=random.choice((0, 0, 5, 0xFFFE, 0xFFFF, random.randrange(1 << 16))),
        index=random.randrange(256),
    )


def random_chain(random: Random) -> list[Datagram]:
    chain: list[Datagram] = []
    room = random.choice((40, 100, 300, 1400))
    while room > 13 and len(chain) < 15:
        chain.append(random_datagram(random, room - 12))
        room -= 12 + len(chain[-1].data)
        if random.random() < 0.2:
            break
    return chain


def run_chains(count: int, seed: int) -> None:
    """So many chains, the FMMUs new every 100."""
    for block in range(0, count, 100):
        random = Random(f"{seed} {block}")
        with Line() as line:
            slave = set_up(line, random)
            for n in range(block, min(block + 100, count)):
                try:
                    check(line, slave, random_chain(random), udp=random.random() < 0.2)
                except AssertionError as error:
                    raise AssertionError(
                        f"chain {n}; again with SEED={seed}, chains from {block}: {error}"
                    ) from error


def test_chains__agree_with_the_memory_model():
    run_chains(600, SEED)


@pytest.mark.full
def test_chains__hundred_thousand_agree_with_the_memory_model():
    run_chains(100_000, SEED)


AREAS = 0x1800
LOGICAL = 0x20000


def halves(area: Area, logical: int, turned: bool) -> list[Fmmu]:
    """Two FMMUs of an area, whose halves follow each other or change places."""
    cut = area.length // 2
    parts = [(area.start, cut), (area.start + cut, area.length - cut)]
    found = []
    for start, length in reversed(parts) if turned else parts:
        if length:
            kind = {"read": not area.master_writes, "write": area.master_writes}
            found.append(Fmmu(logical, length, 0, 7, start, 0, **kind))
            logical += length
    return found


def set_up_areas(line: Line, random: Random) -> Slave:
    """Two areas of three buffers, one a direction, each after two FMMUs."""
    slave = register_memory()
    for n, master_writes in ((2, True), (3, False)):
        length = random.choice((1, 2, 3, 6, 8, 13))
        area = Area(AREAS + 0x100 * n + random.randrange(4), length, master_writes)
        line.exchange(frame([Datagram(2, area.registers(), 0, esc_regmap.SM_START.at(n))]))
        slave.areas.append(area)
        slave.fmmus += halves(area, LOGICAL + 0x40 * n, random.random() < 0.3)
    for n, fmmu in enumerate(slave.fmmus):
        line.exchange(
            frame([Datagram(2, fmmu.registers(), 0, esc_regmap.FMMU_LOGICAL_START.at(n))])
        )
    return slave


def part_of(area: Area, random: Random) -> tuple[int, int]:
    """Mostly all of an area, or a part of it and of what is around: first byte, bytes."""
    if random.random() < 0.4:
        return area.start, area.length
    first = random.randrange(-1, area.length)
    return area.start + first, random.randrange(1, area.length - first + 2)


def area_datagram(slave: Slave, random: Random) -> Datagram:
    """An access of the master to an area, by its address or through FMMUs."""
    n = random.randrange(2)
    start, count = part_of(slave.areas[n], random)
    logical = LOGICAL + 0x40 * (n + 2) + start - slave.areas[n].start
    command = random.choice((1, 2, 3, 10, 11, 12))
    return Datagram(command, random.randbytes(count), 0, start, logical=logical)


def run_areas(seed: int, steps: int) -> None:
    random = Random(f"areas {seed}")
    with Line() as line:
        slave = set_up_areas(line, random)
        for _ in range(steps):
            if random.random() < 0.5:
                chain = [area_datagram(slave, random) for _ in range(random.choice((1, 1, 2, 3)))]
                check(line, slave, chain, random.random() < 0.8)
                continue
            start, count = part_of(random.choice(slave.areas), random)
            if random.random() < 0.5:
                seen = line.read(start, width=count).to_bytes(count, "little")
                assert seen == slave.application(start, None, count)
            else:
                data = random.randbytes(count)
                line.write(start, int.from_bytes(data, "little"), width=count)
                slave.application(start, data)


@pytest.mark.parametrize("seed", range(SEED, SEED + 6))
def test_areas__agree_with_the_memory_model(seed: int):
    run_areas(seed, 80)


@pytest.mark.full
def test_areas__thousand_set_ups_agree_with_the_memory_model():
    for seed in range(SEED, SEED + 1000):
        run_areas(seed, 100)


@pytest.mark.parametrize("command", range(15))
def test_command__addressed_and_not(line: Line, command: int):
    slave = set_up(line, Random(command))
    for position in (0, 1, STATION):
        for offset in (MEMORY, 0x2FFE):
            check(line, slave, [Datagram(command, b"\x5a\xc3\x0f", position, offset, 0x10000)])
    check(line, slave, [Datagram(1, bytes(8), 0, MEMORY), Datagram(1, bytes(4), 0, 0x2FFC)])


def test_frame__longest_passes_whole(line: Line):
    slave = set_up(line, Random(2), fmmus=False)
    check(line, slave, [Datagram(3, Random(3).randbytes(1486), 0, MEMORY)])
    check(line, slave, [Datagram(1, bytes(1486), 0, MEMORY)])


def test_writes__of_a_register_only_read_are_not_counted(line: Line):
    back = line.exchange(frame([Datagram(2, b"\xff", 0, 0x0000)]))
    assert datagrams_of(back.data, [Datagram(2, b"\xff")]) == [(b"\xff", 1, 0)]
    assert line.read(esc_regmap.TYPE) == esc_regmap.TYPE.reset


@pytest.mark.parametrize("first", [0x00, 0x01, 0x02, 0x10, 0xFD, 0xFF])
@pytest.mark.parametrize("kind", [b"\x88\xa4", b"\x08\x00"])
def test_source__is_marked_in_every_frame(line: Line, first: int, kind: bytes):
    """Masters (ethercrab, SOEM) know an answer from their own frame by bit 1 of its first byte."""
    sent = frame([Datagram(0, bytes(4))])
    sent = sent[:6] + bytes([first]) + sent[7:12] + kind + sent[14:]
    back = line.exchange(sent)
    assert back.good
    assert back.data == sent[:6] + bytes([first | 2]) + sent[7:]


def test_frame__of_another_type_passes(line: Line):
    data = b"\xff" * 6 + b"\x10\0\0\0\0\1" + b"\x08\x00" + bytes(range(200))
    assert line.exchange(data).data == passed(data)
    assert line.read(esc_regmap.PROCESSING_ERRORS) == 0


def test_frame__with_a_tag_is_processed(line: Line):
    plain = frame([Datagram(7, bytes(4), 0, 0)])
    back = line.exchange(plain[:12] + b"\x81\x00\x00\x05" + plain[12:])
    assert back.good and back.data[30:34] == bytes([0x4D, 1, 1, 0]) and back.data[34] == 1


def test_datagrams_in_udp__are_processed_and_the_headers_pass(line: Line):
    sent = in_udp(
        frame([Datagram(7, bytes(4), 0, 0)]), id=0x1234, dst="255.255.255.255", flags="DF"
    )
    back = line.exchange(sent)
    assert back.good and back.data[:40] == passed(sent)[:40] and back.data[40:42] == bytes(2)
    assert back.data[54:58] == bytes([0x4D, 1, 1, 0]) and back.data[58] == 1
    tagged = line.exchange(sent[:12] + b"\x81\x00\x00\x05" + sent[12:])
    assert tagged.good and tagged.data[62] == 1


@pytest.mark.parametrize(
    "fields",
    [
        {"port": 0x88A5},
        {"port": 0x89A4},
        {"proto": 6},
        {"version": 6},
        {"options": [IPOption(b"\x01\x01\x01\x00")]},
        {"frag": 1},
        {"frag": 256},
        {"flags": "MF"},
    ],
    ids=str,
)
def test_packet_of_ip__without_datagrams__passes(line: Line, fields: dict):
    sent = in_udp(frame([Datagram(2, b"\x5a" * 4, 0, MEMORY)]), **fields)
    assert line.exchange(sent).data == passed(sent)
    assert line.read(MEMORY, width=4) == 0 and line.read(esc_regmap.PROCESSING_ERRORS) == 0


def test_packet_of_ip__that_ends_in_its_headers__passes(line: Line):
    sent = in_udp(frame([Datagram(7, bytes(4), 0, 0)]))[:30]
    back = line.exchange(sent)
    assert back.data == passed(sent) and line.read(esc_regmap.PROCESSING_ERRORS) == 0


def test_answer__is_dissected_by_scapy(line: Line):
    back = line.exchange(frame([Datagram(7, bytes(10), 0, 0, index=9)]))
    layer = Ether(back.data)[EtherCat].payload
    assert (layer.idx, layer.adp, layer.wkc) == (9, 1, 1)
    assert bytes(layer.data)[:2] == bytes([0x4D, 1])


def test_events__of_the_master_stand_in_the_interrupt_field(line: Line):
    event = esc_regmap.MASTER_EVENT.word(al_status=1)
    mask = event.to_bytes(2, "little")
    line.exchange(frame([Datagram(2, mask, 0, esc_regmap.MASTER_EVENT_MASK.address)]))
    line.write(esc_regmap.AL_STATUS, esc_regmap.AL_STATUS.word(state=2))
    sent = frame([Datagram(1, bytes(2), 0, esc_regmap.AL_STATUS.address)])
    assert line.exchange(sent).data[HEADER + 8] == event
    assert line.exchange(sent).data[HEADER + 8] == 0  # the read of the first cleared it


def test_forwarding__is_constant_and_short():
    with Line([0.0], closed=True) as line:
        delays = set()
        for n in range(60):
            sent = frame([Datagram(12, bytes(1 + 20 * n), logical=0x10000)])
            line.send(sent)
            sent_at = line.now
            back = None
            while back is None:
                line.run(1000)
                back = line.receive(1)
            assert back.data[HEADER:] == sent[HEADER:] and back.sequence == check_sequence(
                back.data
            )
            delays.add((back.began - sent_at) % 40_000)
            line.run(3000 + 40 * 7 * n)
        assert len(delays) == 1


@pytest.mark.parametrize(("in_use", "most"), [(1, 20), (3, 20), (6, 30), (7, 50)])
def test_application__while_logical_bytes_pass__waits_for_the_fmmus_in_use_alone(in_use, most):
    """Clocks of a word: its bytes go in when no FMMU needs the clock, and are done 8 later."""
    with Line() as line:
        for n in range(in_use):
            fmmu = Fmmu(0x10000 + n, 1, 0, 7, MEMORY + n, 0, True, True)
            line.exchange(
                frame([Datagram(2, fmmu.registers(), 0, esc_regmap.FMMU_LOGICAL_START.at(n))])
            )
        line.send(frame([Datagram(12, bytes(1400), logical=0x10000)]))
        line.run(20_000)  # the datagram has begun, and 1100 of its bytes are to come
        spent = []
        for n in range(200):
            before = line.clocks()
            line.read(MEMORY + 0x800 + 4 * (n % 64), width=4)
            spent.append(line.clocks() - before)
        assert line.receive() is None  # it still passes
        assert max(spent) <= most, spent
