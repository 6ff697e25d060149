# SPDX-License-Identifier: Apache-2.0
"""Slave controllers in a line (or ring), Verilated: frames, application ports, clocks.

The master's port 0 is at the first slave, its port 1 after the last one, if the ring is closed.
Frames are bytes without preamble; a good check sequence is appended unless it is given.
"""

from __future__ import annotations

import binascii
import ctypes
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from sim.bus.gen import esc_regmap
from sim.bus.register import ByteRegister
from sim.bus.verilated import HERE, BusModel, load
from sim.rtl.sources import RTL

FOLDERS = (RTL,)  # where the sources are; tests of planted faults put changed copies first
GAP_NIBBLES = 24
SEQUENCE_BYTES = 4
MOST_NIBBLES = 1 << 14
SII_IMAGE = 0x8000
CABLE_PS = 25_000
DISTURBANCES = ("lost", "damaged", "lost back")
SETTLE_NS = 60_000  # after reset, until registers have their values and ports are open


@dataclass(frozen=True)
class Returned:
    """A frame that came back to the master.

    data: its bytes without check sequence; good: that was right, and the nibbles even.
    began, ended: first nibble of the preamble and after the last nibble, ps.
    """

    data: bytes
    sequence: bytes
    good: bool
    nibbles: int
    began: int
    ended: int


def check_sequence(data: bytes) -> bytes:
    """Check sequence of Ethernet (IEEE 802.3, CRC-32) as it is in a frame."""
    return binascii.crc32(data).to_bytes(SEQUENCE_BYTES, "little")


def library() -> ctypes.CDLL:
    """The Verilated line as a shared library. Raises BuildError."""
    longs = [f"bus_{name}" for name in ("now", "time", "clocks", "count", "arrived")]
    return load("ethercat_slave", HERE / "slave_harness.cpp", longs, FOLDERS)


class Line(BusModel):
    """`len(ppm)` slaves, clocks that many parts per million fast; cables of `cable_ps` each."""

    prefix = "bus"
    new = (ctypes.c_uint, ctypes.POINTER(ctypes.c_double), ctypes.c_uint64, ctypes.c_int)

    def __init__(
        self, ppm: Sequence[float] = (0.0,), cable_ps: int = CABLE_PS, closed: bool = False
    ) -> None:
        values = (ctypes.c_double * len(ppm))(*ppm)
        super().__init__(library(), len(ppm), values, cable_ps, closed)
        self.slaves = len(ppm)
        self.run(SETTLE_NS)

    def __enter__(self) -> Line:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def cable(self, place: int, plugged: bool) -> None:
        """Plug or pull the cable before slave `place`; the last is that back to the master."""
        self._call("cable", place, int(plugged))

    def length(self, place: int, ps: int) -> None:
        """Delay of that cable, while nothing is on its way."""
        self._call("length", place, ctypes.c_uint64(ps))

    def pull(self, *places: int) -> None:
        """Pull these cables and plug all others, while `served` runs in another thread."""
        self._call("pull", sum(1 << place for place in places))

    def disturb(self, kind: str, frames: int) -> None:
        """The next frames that `served` carries are lost, damaged (before the slaves) or lost on
        their way back: one of DISTURBANCES."""
        self._call("disturb", DISTURBANCES.index(kind), frames)

    def disturbed(self, kind: str) -> int:
        """How many of them are still to come."""
        return self._call("disturbed", DISTURBANCES.index(kind))

    def arrived(self, slave: int) -> int:
        """When the last frame's first nibble came to port 0 of a slave, ps."""
        return self._call("arrived", slave)

    def send(
        self,
        data: bytes,
        sequence: bytes | None = None,
        port: int = 0,
        error_at: int = -1,
        gap: int = GAP_NIBBLES,
        drop: int = 0,
    ) -> None:
        """Put a frame on the wire: `drop` nibbles of its end are missing, one has RX_ER."""
        whole = data + (check_sequence(data) if sequence is None else sequence)
        nibbles = bytes(n for byte in whole for n in (byte & 15, byte >> 4))
        nibbles = nibbles[: len(nibbles) - drop]
        self._call("send", port, nibbles, len(nibbles), error_at, gap)

    def receive(self, port: int = 0) -> Returned | None:
        """The oldest frame that has come back."""
        room = ctypes.create_string_buffer(MOST_NIBBLES)
        times = (ctypes.c_uint64 * 2)()
        count = self._call("receive", port, room, MOST_NIBBLES, times)
        if count < 0:
            return None
        nibbles = room.raw[:count]
        whole = bytes(a | b << 4 for a, b in zip(nibbles[::2], nibbles[1::2], strict=False))
        data, sequence = whole[:-SEQUENCE_BYTES], whole[-SEQUENCE_BYTES:]
        good = count % 2 == 0 and sequence == check_sequence(data)
        return Returned(data, sequence, good, count, times[0], times[1])

    def exchange(
        self, data: bytes, port: int = 0, limit_ns: int = 400_000, **options
    ) -> Returned | None:
        """Send a frame and wait for it; None if it does not come back within `limit_ns`."""
        self.send(data, port=port, **options)
        for _ in range(0, limit_ns, 1000):
            self.run(1000)
            if found := self.receive(port):
                self.run(4000)  # its writes come into force
                return found
        return None

    def pass_by(self, data: bytes, ns: int) -> None:
        """Send a frame and let so much time pass; nobody looks at what comes back."""
        self.send(data)
        self.run(ns)
        while self.receive():
            pass

    def read(
        self, register: ByteRegister | int, place: int = 0, slave: int = 0, width: int = 0
    ) -> int:
        """What the application reads, by one access a word."""
        address, width = self._span(register, place, width)
        data = bytearray()
        while len(data) < width:
            at = address + len(data)
            count = min(4 - at % 4, width - len(data))
            word = self._access(slave, False, at, count, 0) >> 8 * (at % 4)
            data += (word & (1 << 8 * count) - 1).to_bytes(count, "little")
        return int.from_bytes(data, "little")

    def write(
        self,
        register: ByteRegister | int,
        value: int,
        place: int = 0,
        slave: int = 0,
        width: int = 0,
    ) -> None:
        """Write as the application, by one access a word."""
        address, width = self._span(register, place, width)
        data = value.to_bytes(width, "little")
        done = 0
        while done < width:
            at = address + done
            count = min(4 - at % 4, width - done)
            word = int.from_bytes(data[done : done + count], "little") << 8 * (at % 4)
            self._access(slave, True, at, count, word)
            done += count

    def order(self, address: int, value: int, width: int) -> None:
        """A write of the first slave's application, of at most a word, without a pause after the
        access before; it is done when time passes."""
        word = ctypes.c_uint32(value << 8 * (address % 4))
        self._call("order", 0, address & ~3, (1 << width) - 1 << address % 4, word)

    @staticmethod
    def _span(register: ByteRegister | int, place: int, width: int) -> tuple[int, int]:
        if isinstance(register, ByteRegister):
            return register.at(place), width or register.width
        return register, width or 1

    def _access(self, slave: int, write: bool, address: int, count: int, word: int) -> int:
        data = ctypes.c_uint32(word)
        enable = (1 << count) - 1 << address % 4
        if not self._call("access", slave, int(write), address & ~3, enable, ctypes.byref(data)):
            raise TimeoutError(
                f"the application's access at {address:#06x} was not answered in 1 ms"
            )
        return data.value

    def load_sii(self, image: bytes, slave: int = 0) -> None:
        """Fill the SII image and let the controller load it."""
        for at in range(0, len(image), 4):
            word = image[at : at + 4]
            self.write(SII_IMAGE + at, int.from_bytes(word, "little"), slave=slave, width=len(word))
        reload = esc_regmap.SII_CONTROL.word(command=4)
        self.write(esc_regmap.SII_CONTROL, reload, slave=slave)

    def copy(self, outputs: tuple[int, int], inputs: tuple[int, int], slave: int = 0) -> None:
        """Copy outputs to inputs (address, bytes), zeros after, whenever the interrupt asks."""
        self._call("copy", slave, *outputs, *inputs)

    def time(self, slave: int = 0) -> int:
        """System time of a slave, ns."""
        return self._call("time", slave)

    def clocks(self, slave: int = 0) -> int:
        """Clock cycles of a slave so far."""
        return self._call("clocks", slave)

    def sync(self, slave: int = 0) -> int:
        """SYNC0 and SYNC1 in bits 0 and 1."""
        return self._call("sync", slave)

    def latch(self, levels: int, slave: int = 0) -> None:
        """Latch inputs 0 and 1 in bits 0 and 1, until the next call."""
        self._call("latch", slave, levels)

    def in_reset(self, slave: int = 0) -> bool:
        """Whether a slave and its application are reset."""
        return bool(self._call("in_reset", slave))

    @contextmanager
    def served(self, *taps: int) -> Iterator[None]:
        """As Verilated has it: the line's first port and, of a closed ring, its second one."""
        with super().served(*taps, *[-1] * (2 - len(taps))):
            yield

    @property
    def carried(self) -> tuple[int, int]:
        """Frames that `served` sent and returned."""
        return self._call("count", 0), self._call("count", 1)
