# SPDX-License-Identifier: Apache-2.0
"""Frames built with scapy, and a slave's memory as the published text describes it.

The model knows nothing of the RTL: registers that are plain memory, the process data memory,
FMMUs bit by bit. A frame's reads see what earlier frames wrote; its own writes come into force
behind it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random

from scapy.contrib import ethercat as ec
from scapy.layers.l2 import Ether

from sim.ethercat.gen import esc_regmap

COMMANDS = {
    1: ec.EtherCatAPRD,
    2: ec.EtherCatAPWR,
    3: ec.EtherCatAPRW,
    4: ec.EtherCatFPRD,
    5: ec.EtherCatFPWR,
    6: ec.EtherCatFPRW,
    7: ec.EtherCatBRD,
    8: ec.EtherCatBWR,
    9: ec.EtherCatBRW,
    10: ec.EtherCatLRD,
    11: ec.EtherCatLWR,
    12: ec.EtherCatLRW,
    13: ec.EtherCatARMW,
    14: ec.EtherCatFRMW,
}
READS, WRITES = {1, 3, 4, 6, 7, 9, 10, 12, 13, 14}, {2, 3, 5, 6, 8, 9, 11, 12, 13, 14}
MEMORY, MEMORY_END = 0x1000, 0x3000
HEADER = 16  # bytes of Ethernet and EtherCAT headers


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
        words = list(self.data)
        if self.command == 0:
            return ec.EtherCatAPRD(
                _cmd=0,
                idx=self.index,
                adp=self.position,
                ado=self.offset,
                data=words,
                wkc=self.counter,
            )
        kind = COMMANDS[self.command]
        common = {"idx": self.index, "data": words, "wkc": self.counter}
        if self.command in (10, 11, 12):
            return kind(adr=self.logical, **common)
        return kind(adp=self.position, ado=self.offset, **common)


def frame(datagrams: list[Datagram]) -> bytes:
    """The frame, padded to 60 bytes, by scapy."""
    packet = Ether(dst="ff:ff:ff:ff:ff:ff", src="02:00:00:00:00:01") / ec.EtherCat()
    last = packet.lastlayer()
    for datagram in datagrams:  # `/` would copy all of them each time
        layer = datagram.layer()
        last.add_payload(layer)
        last = layer
    return bytes(packet).ljust(60, b"\0")


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
class Slave:
    """One slave's memory."""

    memory: bytearray = field(default_factory=lambda: bytearray(MEMORY_END))
    fmmus: list[Fmmu] = field(default_factory=list)
    station: int = 0

    def bit(self, address: int) -> int:
        return self.memory[address >> 3] >> (address & 7) & 1

    def process(self, datagrams: list[Datagram], event: int = 0) -> list[tuple[bytes, int, int]]:
        """Data, position and counter of each datagram as it leaves; the writes are done."""
        left, later = [], []
        for datagram in datagrams:
            left.append(self._one(datagram, later))
        for address, value in later:  # bits
            byte = self.memory[address >> 3] & ~(1 << (address & 7))
            self.memory[address >> 3] = byte | value << (address & 7)
        return left

    def _one(self, d: Datagram, later: list[tuple[int, int]]) -> tuple[bytes, int, int]:
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
            base = 8 * d.logical
            for fmmu in self.fmmus:
                for logical, physical in fmmu.bits():
                    n = logical - base
                    if not 0 <= n < 8 * len(out):
                        continue
                    if reads and fmmu.read:
                        out[n >> 3] = out[n >> 3] & ~(1 << (n & 7)) | self.bit(physical) << (n & 7)
                        did_read = True
                    if writes and fmmu.write:
                        later.append((physical, d.data[n >> 3] >> (n & 7) & 1))
                        did_write = True
        else:
            for n in range(len(out)):
                address = d.offset + n
                if address >= MEMORY_END:
                    continue
                if reads:
                    held = self.memory[address]
                    out[n] = out[n] | held if d.command in (7, 9) else held
                    did_read = True
                if writes and address >= MEMORY:
                    later += [(8 * address + k, d.data[n] >> k & 1) for k in range(8)]
                    did_write = True
        both = d.command in (3, 6, 9, 12)
        counter = d.counter + did_read + did_write * (2 if both else 1)
        return bytes(out), position, counter & 0xFFFF


def register_memory() -> Slave:
    """A slave's memory behind reset, as the register map states it."""
    slave = Slave()
    for register in esc_regmap.REGISTERS:
        for place in range(register.count):
            value = (register.reset or 0).to_bytes(register.width, "little")
            slave.memory[register.at(place) : register.at(place) + register.width] = value
    return slave


def random_fmmus(random: Random, memory: tuple[int, int] = (0x1100, 0x1800)) -> list[Fmmu]:
    """Eight FMMUs over a few logical bytes; those that write map memory of their own each."""
    found = []
    size = (memory[1] - memory[0]) // 8
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
                physical=memory[0] + n * size + random.randrange(size // 2),
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
