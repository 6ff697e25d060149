# SPDX-License-Identifier: Apache-2.0
"""Random sequences of writes to the objects that configure the device, and what they may leave.

`Configuration` holds what the rules between objects say of the values that the device has at the
end; it is written from the dictionary's source and from the pages, not from the program.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from random import Random

from sim.bus.coe.dictionary import MAP_STEP, RX_MAP, TX_MAP, Entry, Object
from sim.bus.gen.esc_regmap import AL_CONTROL
from tests.ethercat import managers
from tests.ethercat.host import DEVICE, ERROR, PREOP, SAFEOP, AbortedError, Host

CAMPAIGN = 100_000
MAPS, WRITES, RESTART, STATES = 6, 6, 50, 10  # per device; every so many sequences
CYCLE_US, PROCESS_BYTES = 100, 512
LISTS = {"rx": (0x1C12, RX_MAP), "tx": (0x1C13, TX_MAP)}
ENTRIES = {(o.index, e.subindex): e for o in DEVICE.objects for e in o.entries}
MAPPABLE = {d: [(i, s, e) for (i, s), e in ENTRIES.items() if e.pdo == d] for d in LISTS}


def _settings() -> list[tuple[Object, Entry]]:
    """What a master may configure: all that it may write but texts, maps and lists."""
    return [
        (one, entry)
        for one in DEVICE.objects
        for entry in one.entries
        if entry.access in ("rw", "preop") and entry.type != "string" and one.index not in _OWN
    ]


_OWN = {n for index, first in LISTS.values() for n in (index, *range(first, first + 16 * MAPS))}
SETTINGS = _settings()
RULED = {index & 0x7FF for index in (0x607D, 0x60B8, 0x60C2, 0x60D0)}
COUPLED = [(o, e) for o, e in SETTINGS if o.index & 0x7FF in RULED]


def setting(random: Random) -> tuple[int, int, bytes]:
    """A write of a number: within what its entry allows, at an edge of it, or anything."""
    one, entry = random.choice(COUPLED if random.random() < 0.4 else SETTINGS)
    if entry.type == "f32":
        return one.index, entry.subindex, struct.pack("<f", random.choice((0.0, 1.0, -1.0, 1e9)))
    bits = 8 * struct.calcsize(entry.format)
    signed = entry.format[-1].islower()
    least, most = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
    values = [least, most, 0, 1, 2, 100, 125, *entry.values]
    if one.index & 0x7FF == 0x60B8 & 0x7FF:  # probes that are on, as they may be and not
        values += [random.getrandbits(16) | 0x0101 for _ in range(8)] + [
            0x3511,
            0x1533,
            0x1515,
            0x3919,
            0x1939,
        ]
    values += [random.randint(least, most), random.randint(max(least, -2000), min(most, 2000))]
    for edge in map(int, entry.limits or ()):
        values += [edge - 1, edge, edge + 1]
    value = random.choice([v for v in values if least <= v <= most])
    return one.index, entry.subindex, struct.pack(entry.format, value)


def mapping(random: Random) -> Iterator[tuple[int, int, bytes]]:
    """Writes to a map or a list, as a master does them and as it should not."""
    side = random.choice(tuple(LISTS))
    index, first = LISTS[side]
    own = first + MAP_STEP * random.randrange(MAPS)
    count = random.choice((0, 1, 2, 5, 6, 8, 10, 11))
    kind = random.random()
    if kind < 0.15:  # a whole list
        pdos = [first + MAP_STEP * n for n in range(MAPS)]
        random.shuffle(pdos)
        yield index, 0, b"\0"
        yield from ((index, n, struct.pack("<H", pdo)) for n, pdo in enumerate(pdos, 1))
        yield index, 0, bytes([MAPS])
        return
    if kind < 0.4:  # a whole map, long or of few objects, which other maps may have too
        words = [248, *(i << 16 | s << 8 | e.bits for i, s, e in MAPPABLE[side][:3])]
        words = words[:1] if random.random() < 0.6 else words
        yield own, 0, b"\0"
        for n in range(1, count + 1):
            yield own, n, struct.pack("<I", random.choice(words))
        yield own, 0, bytes([count])
        return
    if random.random() < 0.8:
        yield (index if random.random() < 0.5 else own), 0, b"\0"
    for _ in range(random.randrange(3)):
        if random.random() < 0.4:
            pdo = first + MAP_STEP * random.randrange(MAPS + 1)
            yield index, random.randint(1, MAPS), struct.pack("<H", random.choice((pdo, pdo, 0)))
            continue
        one, sub, entry = random.choice(MAPPABLE[random.choice((side, side, side, "rx", "tx"))])
        word = one << 16 | sub << 8 | random.choice((entry.bits, entry.bits, entry.bits, 8, 64))
        word = random.choice((word, word, word, 8, 248, 0))
        yield own, random.randint(1, 10), struct.pack("<I", word)
    yield random.choice((index, own)), 0, bytes([count])


def sequence(host: Host, random: Random) -> None:
    """Some writes; refused ones change nothing that counts."""
    for _ in range(WRITES):
        if random.random() < 0.5:
            writes = [setting(random)]
        else:
            writes = list(mapping(random))
        for index, subindex, data in writes:
            try:
                if random.random() < 0.1:  # as a whole object, what it has now with other bytes
                    whole = bytearray(host.upload(index, 0, complete=True))
                    whole[-len(data) :] = data
                    host.download(index, random.choice((0, 0, 1)), bytes(whole), complete=True)
                else:
                    host.download(index, subindex, data)
            except AbortedError:
                pass


def number(host: Host, index: int, subindex: int) -> float:
    """The value that the device has."""
    return struct.unpack(ENTRIES[index, subindex].format, host.upload(index, subindex))[0]


def side_of(host: Host, side: str) -> tuple[list[str], int, bool]:
    """What is wrong with the process data of a direction, their bytes, and whether the master would
    write an object twice.
    """
    wrong, bits, written = [], 0, []
    index, first = LISTS[side]
    whole = host.upload(index, 0, complete=True)
    pdos = [pdo for pdo in struct.unpack_from(f"<{whole[0]}H", whole, 2) if pdo]
    if len(set(pdos)) != len(pdos):
        wrong.append(f"{index:04X} has a PDO twice")
    for pdo in pdos:
        if pdo not in range(first, first + MAP_STEP * MAPS, MAP_STEP):
            wrong.append(f"{index:04X} has {pdo:04X}")
            continue
        whole = host.upload(pdo, 0, complete=True)
        for word in struct.unpack_from(f"<{whole[0]}I", whole, 2):
            place, length = (word >> 16, word >> 8 & 0xFF), word & 0xFF
            bits += length
            if not place[0]:
                if length == 0 or length % 8:
                    wrong.append(f"{pdo:04X} has a padding of {length} bits")
                continue
            written.append(place)
            entry = ENTRIES.get(place)
            if entry is None or entry.pdo != side or entry.bits != length:
                wrong.append(f"{pdo:04X} maps {word:08X}")
    if bits > 8 * PROCESS_BYTES:
        wrong.append(f"{index:04X}: {bits // 8} bytes of process data")
    return wrong, bits // 8, side == "rx" and len(set(written)) != len(written)


def inconsistent(host: Host, random: Random, states: bool) -> list[str]:
    """What does not go together in the device's objects. states: also bring it to SAFEOP, which has
    to take exactly what the objects say.
    """
    wrong = []
    for index in range(0x6000, 0x8800, 0x800):
        period = number(host, index + 0xC2, 1) * 10 ** (6 + number(host, index + 0xC2, 2))
        if period < CYCLE_US:
            wrong.append(f"{index + 0xC2:04X}: {period} us")
        if number(host, index + 0x7D, 1) > number(host, index + 0x7D, 2):
            wrong.append(f"{index + 0x7D:04X}: least above most")
        probes = int(number(host, index + 0xB8, 0))
        wrong += [
            f"{index + 0xB8:04X}: {probes:04X}"
            for n, one in enumerate((probes & 0xFF, probes >> 8), 1)
            if one & 0x01  # reserved bits and source, or falling index, also by 60D0
            and (one & 0xC0 or one & 0x0C == 0x0C or one & 0x24 == 0x24)
            or one & 0x29 == 0x29
            and number(host, index + 0xD0, n) == 3
        ]
    for one, entry in random.sample(SETTINGS, 8):
        value = number(host, one.index, entry.subindex)
        if entry.values and value not in entry.values:
            wrong.append(f"{one.index:04X}:{entry.subindex:02X} has {value}")
        if entry.limits and not entry.limits[0] <= value <= entry.limits[1]:
            wrong.append(f"{one.index:04X}:{entry.subindex:02X} has {value}")
    found = {side: side_of(host, side) for side in LISTS}
    wrong += found["rx"][0] + found["tx"][0]
    if states and not wrong:
        wrong += _wrong_states(host, found["rx"][1], found["tx"][1], found["rx"][2])
    return wrong


def _wrong_states(host: Host, outputs: int, inputs: int, twice: bool) -> list[str]:
    sync = number(host, 0x1C32, 1) == 2  # SYNC0, which is off here
    host.manager(2, 0x1200, outputs, managers.OUTPUTS, int(outputs > 0))
    host.manager(3, 0x1800, inputs, managers.INPUTS, int(inputs > 0))
    code = 0x0025 if twice else 0x0030 if sync else 0
    expected = (PREOP | ERROR, code) if code else (SAFEOP, 0)
    if (status := host.ask(SAFEOP)) != expected:
        return [f"SAFEOP: {status} for {outputs} and {inputs} bytes, expected {expected}"]
    host.cycle(2)
    host.write(AL_CONTROL.address, struct.pack("<H", PREOP | ERROR))
    host.background()
    return [] if host.status == (PREOP, 0) else [f"PREOP: {host.status}"]


def campaign(seed: int, count: int) -> Iterator[tuple[str, list[str]]]:
    """How to run it again, and findings, of each sequence; a device has `RESTART` of them."""
    for block in range(0, count, RESTART):
        random, host = Random(f"{seed} {block}"), Host().to_preop()
        for n in range(block, min(block + RESTART, count)):
            sequence(host, random)
            name = f"campaign({seed}, {block + RESTART}), sequence {n}"
            yield name, inconsistent(host, random, states=n % STATES == STATES - 1)
