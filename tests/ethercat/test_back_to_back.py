# SPDX-License-Identifier: Apache-2.0
"""Frames at the least gap: each sees what the one before wrote, up to a stated number of bytes."""

from __future__ import annotations

from random import Random

import pytest

from sim.bus.gen import esc_regmap
from sim.bus.line import GAP_NIBBLES, Line
from tests.bench.seed import SEED
from tests.ethercat import managers
from tests.ethercat.frames import MEMORY, WRITES, Datagram, Fmmu, Slave, frame
from tests.ethercat.test_frames import COMMIT_NS, check_answer, datagrams_of, random_chain, set_up

# Bytes that a frame may write when the next one comes at the least gap: the number that
# docs/ethercat.md states. Mappings of the dictionary may be longer, up to 512 bytes.
MOST_BYTES = 343
CLOCKS_PER_NIBBLE, PART = 4, 3
AWAY_NS = 130_000  # a frame of the longest size


def clocks(slave: Slave, datagrams: list[Datagram]) -> int:
    """What the writes of a frame take, at most: a byte a clock; three where an FMMU may write parts
    of bytes, each that it has."""
    count = 0
    for d in datagrams:
        if d.command in (11, 12):
            for f in slave.fmmus:
                begin, end = (
                    max(f.logical, d.logical),
                    min(f.logical + f.length, d.logical + len(d.data)),
                )
                count += PART * max(0, end - begin) if f.write else 0
        elif d.command in WRITES:
            count += len(d.data)
    return count


def random_chains(slave: Slave, random: Random, count: int) -> list[list[Datagram]]:
    """So many, each of which the next may follow at the least gap."""
    chains: list[list[Datagram]] = []
    while len(chains) < count:
        chain = random_chain(random)
        if clocks(slave, chain) <= MOST_BYTES:
            chains.append(chain)
    return chains


def check_frames(line: Line, slave: Slave, chains: list[list[Datagram]]) -> None:
    """Send them one after the other at the least gap; all come back as the model has them."""
    sent = [frame(chain) for chain in chains]
    for data in sent:
        line.send(data, gap=GAP_NIBBLES)
    line.run(AWAY_NS * len(sent))
    for n, (data, chain) in enumerate(zip(sent, chains, strict=True)):
        back = line.receive()
        assert back is not None and back.good and len(back.data) == len(data), f"frame {n}"
        check_answer(data, back.data, chain, slave.process(chain), f"frame {n}, ")
    assert line.receive() is None
    line.run(COMMIT_NS * sum(len(d.data) for chain in chains for d in chain))


def run_frames(count: int, seed: int) -> int:
    """So many groups of frames at the least gap; the most clocks that a frame's writes took."""
    most = 0
    for block in range(0, count, 50):
        random = Random(f"{seed} {block}")
        with Line() as line:
            slave = set_up(line, random)
            for n in range(block, min(block + 50, count)):
                chains = random_chains(slave, random, random.randrange(2, 5))
                most = max(most, *(clocks(slave, chain) for chain in chains[:-1]))
                try:
                    check_frames(line, slave, chains)
                except AssertionError as error:
                    again = f"group {n}; again with SEED={seed}, groups from {block}"
                    raise AssertionError(f"{again}: {error}") from error
    return most


@pytest.mark.full
def test_chains__at_the_least_gap_agree_with_the_memory_model():
    assert run_frames(200, SEED) > 0.8 * MOST_BYTES


@pytest.mark.full
def test_chains__ten_thousand_at_the_least_gap():
    run_frames(10_000, SEED)


def counter_behind(size: int, logical: bool, cable_ps: int = 25_000, more: int = 0) -> int:
    """Counter of a datagram of one byte that follows a frame that writes `size` at the least gap
    and `more` nibbles; logical: outputs of a sync manager, by an FMMU."""
    with Line(cable_ps=cable_ps) as line:
        if logical:
            fmmu = Fmmu(0x10000, size, 0, 7, MEMORY, 0, False, True)
            at = esc_regmap.FMMU_LOGICAL_START.at(0)
            line.exchange(frame([Datagram(2, fmmu.registers(), 0, at)]))
            manager = managers.registers(MEMORY, size, managers.OUTPUTS)
            at = esc_regmap.SM_START.at(2)
            line.exchange(frame([Datagram(2, manager, 0, at)]))
        write = [Datagram(11 if logical else 2, bytes(size), 0, MEMORY, logical=0x10000)]
        read = [Datagram(1, bytes(1), 0, MEMORY + 0x1800)]
        line.send(frame(write))
        line.send(frame(read), gap=GAP_NIBBLES + more)
        line.run(2 * AWAY_NS)
        first, second = line.receive(), line.receive()
        assert datagrams_of(first.data, write)[0][2] == 1
        return datagrams_of(second.data, read)[0][2]


@pytest.mark.parametrize("logical", (False, True))
@pytest.mark.parametrize("cable_ps", (0, 10_000, 32_500))  # phases of the sender's clock
def test_write__of_the_most_bytes_leaves_the_next_frame_served(logical: bool, cable_ps: int):
    assert counter_behind(MOST_BYTES, logical, cable_ps) == 1
    assert counter_behind(MOST_BYTES + 1, logical, cable_ps) == 0


@pytest.mark.parametrize("size", (400, 512))
def test_write__of_more_needs_a_clock_a_byte_more(size: int):
    more = -(-(size - MOST_BYTES) // CLOCKS_PER_NIBBLE)
    assert counter_behind(size, True, more=more) == 1
    assert counter_behind(size, True, more=more - 2) == 0
