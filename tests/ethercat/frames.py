# SPDX-License-Identifier: Apache-2.0
"""Frames built with scapy, and a slave's memory as the published text describes it.

The model knows nothing of the RTL: registers that are plain memory, the process data memory,
FMMUs bit by bit, areas of three buffers. A frame's reads see what earlier frames wrote; its own
writes come into force after it. An area is open for a side from its access to the first byte to
that of the last one, which hands it over; what is accessed outside is refused.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random

from scapy.contrib import ethercat as ec
from scapy.layers.inet import IP, UDP
from scapy.layers.l2 import Ether
from scapy.packet import Raw

from sim.bus.gen import esc_regmap
from tests.ethercat import managers

NAMES = "APRD APWR APRW FPRD FPWR FPRW BRD BWR BRW LRD LWR LRW ARMW FRMW"
COMMANDS = {n: getattr(ec, f"EtherCat{name}") for n, name in enumerate(NAMES.split(), 1)}
READS, WRITES = {1, 3, 4, 6, 7, 9, 10, 12, 13, 14}, {2, 3, 5, 6, 8, 9, 11, 12, 13, 14}
MEMORY, MEMORY_END = 0x1000, 0x3000
HEADER = 16  # bytes of Ethernet and EtherCAT headers
SOURCE = "10:10:10:10:10:10"  # of the frames, as ethercrab sends them


@dataclass(frozen=True)
class Datagram:
    """One datagram; address: of 32 bits, or position (station) and offset below."""

    command: int
    data: bytes
    position: int = 0
    offset: int = 0
    logical: int = 0
    counter: int = 0
    index: int = 0

    def layer(self):
        """As scapy's layer."""
        words = {"idx": self.index, "data": list(self.data), "wkc": self.counter}
        if self.command in (10, 11, 12):
            return COMMANDS[self.command](adr=self.logical, **words)
        words |= {"adp": self.position, "ado": self.offset}
        if self.command == 0:
            return ec.EtherCatAPRD(_cmd=0, **words)
        return COMMANDS[self.command](**words)


def frame(datagrams: list[Datagram]) -> bytes:
    """The frame, padded to 60 bytes, by scapy."""
    packet = Ether(dst="ff:ff:ff:ff:ff:ff", src=SOURCE) / ec.EtherCat()
    last = packet.lastlayer()
    for datagram in datagrams:  # `/` would copy all of them each time
        layer = datagram.layer()
        last.add_payload(layer)
        last = layer
    return bytes(packet).ljust(60, b"\0")


def in_udp(data: bytes, port: int = 0x88A4, **fields) -> bytes:
    """A frame of datagrams as IPv4 and UDP carry it, by scapy; fields: of IPv4."""
    packet = Ether(data[:14]) / IP(**fields) / UDP(sport=0x88A4, dport=port) / Raw(data[14:])
    packet.type = 0x0800
    return bytes(packet)


def out_of_udp(data: bytes) -> bytes:
    """The frame of datagrams from IPv4 and UDP; the check sum of UDP must be 0, which is none."""
    assert data[40:42] == bytes(2)
    return data[:12] + b"\x88\xa4" + data[42:]


def passed(data: bytes) -> bytes:
    """The frame after a slave that serves none of it: the source is locally administered."""
    return data[:6] + bytes([data[6] | 2]) + data[7:]


@dataclass(frozen=True)
class Fmmu:
    """As its registers hold it."""

    logical: int
    length: int
    first_bit: int
    last_bit: int
    physical: int
    physical_bit: int
    read: bool
    write: bool

    def registers(self) -> bytes:
        """The bytes of its registers."""
        return (
            self.logical.to_bytes(4, "little")
            + self.length.to_bytes(2, "little")
            + bytes([self.first_bit, self.last_bit])
            + self.physical.to_bytes(2, "little")
            + bytes([self.physical_bit, self.read | self.write << 1, 1, 0, 0, 0])
        )

    def bits(self):
        """Logical and physical address of every bit, counted in bits."""
        begin = 8 * self.logical + self.first_bit
        end = 8 * (self.logical + self.length - 1) + self.last_bit
        physical = 8 * self.physical + self.physical_bit
        for n in range(max(0, end - begin + 1)):
            yield begin + n, physical + n


@dataclass
class Area:
    """Three buffers of a sync manager, and for which side it is open.

    bus: the master's side, as good frames left it; passing: as the present frame goes on; opened:
    the present frame has its buffer.
    """

    start: int
    length: int
    master_writes: bool
    writer: int = 0
    newest: int = 1
    reader: int = 2
    fresh: bool = False
    bus: bool = False
    passing: bool = False
    opened: bool = False
    application: bool = False

    def registers(self) -> bytes:
        """The bytes of its registers."""
        control = managers.UNWATCHED if self.master_writes else managers.INPUTS
        return managers.registers(self.start, self.length, control)

    def hand_over(self) -> None:
        """The writer is at the end."""
        self.writer, self.newest, self.fresh = self.newest, self.writer, True

    def take(self) -> None:
        """The reader begins."""
        if self.fresh:
            self.reader, self.newest, self.fresh = self.newest, self.reader, False

    def at(self, writes: bool) -> int:
        """How far after its addresses the buffer of that side lies."""
        return self.length * (self.writer if writes else self.reader)


@dataclass(frozen=True)
class Touch:
    """Bits of a datagram's byte and where they lie: (bit of the data, bit of the memory)."""

    pairs: tuple[tuple[int, int], ...]

    @property
    def first(self) -> int:
        return self.pairs[0][1] >> 3

    @property
    def last(self) -> int:
        return self.pairs[-1][1] >> 3


@dataclass
class Slave:
    """One slave's memory."""

    memory: bytearray = field(default_factory=lambda: bytearray(MEMORY_END))
    fmmus: list[Fmmu] = field(default_factory=list)
    station: int = 0
    areas: list[Area] = field(default_factory=list)

    def bit(self, address: int) -> int:
        return self.memory[address >> 3] >> (address & 7) & 1

    def area(self, address: int) -> Area | None:
        """The area that holds the byte."""
        inside = (a for a in self.areas if a.start <= address < a.start + a.length)
        return next(inside, None)

    def process(self, datagrams: list[Datagram], good: bool = True) -> list[tuple[bytes, int, int]]:
        """Data, position and counter of each datagram as it leaves; of a good frame the writes are
        done."""
        left: list[tuple[bytes, int, int]] = []
        later: list[tuple[Touch, int | None]] = []
        for area in self.areas:
            area.passing, area.opened = area.bus, False
        for datagram in datagrams:
            left.append(self._one(datagram, later))
        for touch, byte in later if good else []:
            self._commit(touch, byte)
        return left

    def _commit(self, touch: Touch, byte: int | None) -> None:
        """A write of a good frame, or the end of its reading."""
        area = self.area(touch.first)
        shift = 0
        if area:
            shift = 8 * area.at(True)
            area.bus = touch.last != area.start + area.length - 1
        if byte is None:
            return
        for n, physical in touch.pairs:
            place = physical + shift
            kept = self.memory[place >> 3] & ~(1 << (place & 7))
            self.memory[place >> 3] = kept | (byte >> (n & 7) & 1) << (place & 7)
        if area and not area.bus:
            area.hand_over()

    def application(self, address: int, data: bytes | None, count: int = 0) -> bytes:
        """What the application reads; data: it writes these. One byte after the other."""
        out = bytearray()
        for n in range(len(data) if data is not None else count):
            area, place = self.area(address + n), address + n
            if area:
                begins, ends = place == area.start, place == area.start + area.length - 1
                allowed = area.master_writes != (data is not None) and (begins or area.application)
                if not allowed:
                    out.append(0)
                    continue
                if begins and data is None:
                    area.take()
                place += area.at(data is not None)
                area.application = not ends
            if data is not None:
                self.memory[place] = data[n]
                if area and ends:
                    area.hand_over()
            else:
                out.append(self.memory[place])
        return bytes(out)

    def _pass(self, touch: Touch, reads: bool, writes: bool) -> tuple[bool, bool, int]:
        """Whether a passing frame may read and write there, and how far after its buffer lies."""
        area = self.area(touch.first)
        if area is None:
            return reads, writes, 0
        begins, ends = touch.first == area.start, touch.last == area.start + area.length - 1
        allowed = begins or area.passing
        reads, writes = reads and not area.master_writes, writes and area.master_writes
        if not allowed or not (reads or writes):
            return False, False, 0
        area.passing = not ends
        if reads and begins:
            area.bus = True
            if not area.opened:
                area.take()
                area.opened = True
        return reads, writes, 8 * area.at(False)

    def _touches(self, d: Datagram) -> list[tuple[Touch, bool, bool]]:
        """What a logical datagram means, byte by byte, of each the FMMUs in their order."""
        base, found = 8 * d.logical, []
        for place, fmmu in enumerate(self.fmmus):
            of: dict[int, list[tuple[int, int]]] = {}
            for logical, physical in fmmu.bits():
                n = logical - base
                if 0 <= n < 8 * len(d.data):
                    of.setdefault(n >> 3, []).append((n, physical))
            for byte, pairs in of.items():
                found.append((byte, place, Touch(tuple(pairs)), fmmu.read, fmmu.write))
        return [each[2:] for each in sorted(found, key=lambda each: each[:2])]

    def _one(self, d: Datagram, later: list[tuple[Touch, int | None]]) -> tuple[bytes, int, int]:
        position, reads, writes = d.position, d.command in READS, d.command in WRITES
        addressed = True
        if d.command in (1, 2, 3, 13):
            addressed = d.position == 0
        elif d.command in (4, 5, 6, 14):
            addressed = d.position == self.station
        if d.command in (1, 2, 3, 7, 8, 9, 13):
            position = (position + 1) & 0xFFFF
        if d.command in (13, 14):
            reads, writes = addressed, not addressed
            addressed = True
        if not addressed or d.command == 0:
            return d.data, position, d.counter
        out = bytearray(d.data)
        did_read = did_write = False
        if d.command in (10, 11, 12):
            touches = self._touches(d)
        else:
            touches = [
                (
                    Touch(tuple((8 * n + k, 8 * (d.offset + n) + k) for k in range(8))),
                    True,
                    d.offset + n >= MEMORY,
                )
                for n in range(min(len(out), MEMORY_END - d.offset))
            ]
        for touch, readable, writable in touches:
            now_read, now_write, shift = self._pass(touch, reads and readable, writes and writable)
            ends = (area := self.area(touch.first)) and touch.last == area.start + area.length - 1
            for n, physical in touch.pairs if now_read else ():
                held = self.bit(physical + shift)
                if d.command in (7, 9):
                    held |= out[n >> 3] >> (n & 7) & 1
                out[n >> 3] = out[n >> 3] & ~(1 << (n & 7)) | held << (n & 7)
            if now_write:
                later.append((touch, d.data[touch.pairs[0][0] >> 3]))
            elif now_read and ends:
                later.append((touch, None))
            did_read, did_write = did_read or now_read, did_write or now_write
        both = d.command in (3, 6, 9, 12)
        counter = d.counter + did_read + did_write * (2 if both else 1)
        return bytes(out), position, counter & 0xFFFF


def register_memory() -> Slave:
    """A slave's memory after reset, as the register map states it."""
    slave = Slave()
    for register in esc_regmap.REGISTERS:
        for place in range(register.count):
            value = (register.reset or 0).to_bytes(register.width, "little")
            slave.memory[register.at(place) : register.at(place) + register.width] = value
    return slave


def random_fmmus(random: Random) -> list[Fmmu]:
    """Eight FMMUs over a few logical bytes; those that write map memory of their own each."""
    found = []
    first_byte, size = 0x1100, 0xE0
    for n in range(8):
        length = random.choice((1, 1, 2, 3, 5, 16, 40))
        first, last = random.randrange(8), random.randrange(8)
        if length == 1 and last < first:
            first, last = last, first
        found.append(
            Fmmu(
                logical=0x10000 + random.randrange(60),
                length=length,
                first_bit=first,
                last_bit=last,
                physical=first_byte + n * size + random.randrange(size // 2),
                physical_bit=random.randrange(8),
                read=random.random() < 0.6,
                write=random.random() < 0.6,
            )
        )
    return apart(found)


def apart(fmmus: list[Fmmu]) -> list[Fmmu]:
    """Without those that read a bit which one before reads: what both give is not defined."""
    seen: set[int] = set()
    kept = []
    for fmmu in fmmus:
        mine = {logical for logical, _ in fmmu.bits()} if fmmu.read else set()
        if not mine & seen:
            kept.append(fmmu)
            seen |= mine
    return kept
