# SPDX-License-Identifier: Apache-2.0
"""Commands of GDB's remote serial protocol: what each packet does to the target, and its answer.

Source: Debugging with GDB, appendix "GDB Remote Serial Protocol": Packets, Stop Reply Packets,
General Query Packets. A packet that is not known gets the empty answer, as the protocol asks for.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable

from sim.debug.gdb import monitor
from sim.debug.gdb.description import PC, memory_map, target_xml
from sim.debug.gdb.packets import LARGEST, escape
from sim.debug.gdb.system import NiosSystem
from sim.debug.gdb.target import Stop, Target, TargetError

SIGINT, SIGTRAP, SIGSEGV = 2, 5, 11
OK, BAD, REFUSED, FAULT = b"OK", b"E16", b"E01", b"E0e"  # EINVAL, EPERM, EFAULT
FEATURES = f"PacketSize={LARGEST:x};QStartNoAckMode+;qXfer:features:read+;qXfer:memory-map:read+"
FEATURES += ";swbreak+;hwbreak+;vContSupported+"
EXPEDITED = (27, 28, 31, PC)  # sp, fp, ra, pc


class Session:
    """One debugger. `handle` answers a packet; the attributes say what the server must do then."""

    def __init__(self, system: NiosSystem) -> None:
        self._system = system
        self.running = False  # the program runs; the answer to its packet is its stop
        self.over = False  # detached or killed: the connection ends
        self.killed = False
        self.extended = False
        self.acknowledge = True

    @property
    def _target(self) -> Target:
        return self._system.target

    def handle(self, packet: bytes) -> bytes | None:
        """The answer; None while the program runs."""
        for prefix, act in _COMMANDS:
            if packet.startswith(prefix) and not _longer_name(prefix, packet):
                try:
                    return act(self, packet[len(prefix) :])
                except TargetError:
                    return FAULT
                except (ValueError, struct.error, UnicodeDecodeError):
                    return BAD
        return b""

    def stopped(self, signal: int = SIGTRAP) -> bytes:
        """Stop reply of a halted core. signal: why it stopped, if it did not at a point."""
        stop: Stop = self._target.stop
        signal = signal if stop.reason == "halt" else SIGTRAP
        reply = b"T%02x" % signal
        if stop.reason in ("watch", "rwatch", "awatch"):
            reply += b"%s:%x;" % (stop.reason.encode(), stop.address)
        elif stop.reason in ("swbreak", "hwbreak"):
            reply += b"%s:;" % stop.reason.encode()
        for number in EXPEDITED:
            reply += b"%02x:%s;" % (number, _word(self._target.register(number)))
        return reply

    # ------------------------------------------------------------------ run control
    def _resume(self, step: bool, address: bytes) -> bytes | None:
        if address:
            self._target.set_register(PC, int(address, 16))
        if not self._target.resume(step):
            return self.stopped()
        self.running = True
        return None

    def _v_cont(self, data: bytes) -> bytes | None:
        if data == b"?":
            return b"vCont;c;C;s;S"
        action = data.removeprefix(b";").partition(b";")[0].partition(b":")[0]
        if data[:1] != b";" or action[:1] not in (b"c", b"C", b"s", b"S"):
            return BAD
        return self._resume(action[:1] in b"sS", b"")

    def _detach(self, data: bytes) -> bytes:
        self._target.forget()
        self._target.resume(False)
        self.over = True
        return OK

    def _kill(self, data: bytes) -> bytes | None:
        self.over = self.killed = True
        return OK if data else None  # vKill has an answer, k has none

    def _restart(self, data: bytes) -> bytes | None:
        self._system.reset()
        return None

    def _run(self, data: bytes) -> bytes:
        self._system.reset()
        return self.stopped()

    def _extend(self, data: bytes) -> bytes:
        self.extended = True
        return OK

    # ------------------------------------------------------------------ registers, memory
    def _set_registers(self, data: bytes) -> bytes:
        words = bytes.fromhex(data.decode())
        values = struct.unpack(f"<{len(words) // 4}I", words)
        for number, value in enumerate(values):
            self._target.set_register(number, value)
        return OK

    def _set_register(self, data: bytes) -> bytes:
        number, _, value = data.partition(b"=")
        (word,) = struct.unpack("<I", bytes.fromhex(value.decode()))
        self._target.set_register(int(number, 16), word)
        return OK

    def _read(self, data: bytes) -> bytes:
        address, length = _place(data)
        return self._target.read(address, min(length, LARGEST // 2)).hex().encode()

    def _write(self, data: bytes, binary: bool) -> bytes:
        place, _, content = data.partition(b":")
        content = content if binary else bytes.fromhex(content.decode())
        address, length = _place(place)
        if length != len(content):
            return BAD
        self._target.write(address, content)
        return OK

    def _checksum(self, data: bytes) -> bytes:
        """CRC-32 of a piece of memory, most significant bits first, as GDB computes it."""
        address, length = _place(data)
        content = self._target.read(address, length)
        return b"C%08x" % _reversed(zlib.crc32(content.translate(_MIRRORED)) ^ 0xFFFF_FFFF, 32)

    def _point(self, data: bytes, act: Callable[[int, int, int], None]) -> bytes:
        kind, address, length = data.split(b";")[0].split(b",")
        if kind not in (b"0", b"1", b"2", b"3", b"4"):
            return b""
        act(int(kind), int(address, 16), int(length, 16))
        return OK

    # ------------------------------------------------------------------ queries
    def _no_acknowledge(self, data: bytes) -> bytes:
        self.acknowledge = False
        return OK

    def _features(self, data: bytes) -> bytes:
        name, _, place = data.partition(b":")
        if name != b"target.xml":
            return b"E00"
        return _part(target_xml(self._target.system).encode(), place)

    def _memory_map(self, data: bytes) -> bytes:
        return _part(memory_map(self._target.map).encode(), data.lstrip(b":"))

    def _monitor(self, data: bytes) -> bytes:
        line = bytes.fromhex(data.decode()).decode()
        return monitor.command(self._system, line).encode().hex().encode()


def _reversed(value: int, bits: int) -> int:
    """A number with its bits in the other order."""
    return int(f"{value:0{bits}b}"[::-1], 2)


_MIRRORED = bytes(_reversed(byte, 8) for byte in range(256))


def _longer_name(name: bytes, packet: bytes) -> bool:
    """Whether a packet has another name that only begins with this one, as `qCRC` with `qC`."""
    return len(name) > 1 and name[-1:].isalpha() and packet[len(name) : len(name) + 1].isalpha()


def _word(value: int) -> bytes:
    return struct.pack("<I", value & 0xFFFF_FFFF).hex().encode()


def _place(data: bytes) -> tuple[int, int]:
    address, length = data.split(b",")
    return int(address, 16), int(length, 16)


def _part(document: bytes, place: bytes) -> bytes:
    """The piece that `offset,length` asks for: m, or l with the last one."""
    offset, length = _place(place)
    length = min(length, LARGEST // 2)
    piece = document[offset : offset + length]
    return (b"l" if offset + length >= len(document) else b"m") + escape(piece)


def _fixed(answer: bytes) -> Callable[[Session, bytes], bytes]:
    return lambda session, data: answer


Handler = Callable[[Session, bytes], "bytes | None"]
# By their beginning; a longer one comes before a shorter one that it begins with.
_COMMANDS: tuple[tuple[bytes, Handler], ...] = (
    (b"qSupported", _fixed(FEATURES.encode())),
    (b"QStartNoAckMode", Session._no_acknowledge),
    (b"qXfer:features:read:", Session._features),
    (b"qXfer:memory-map:read:", Session._memory_map),
    (b"qRcmd,", Session._monitor),
    (b"qAttached", _fixed(b"1")),
    (b"qfThreadInfo", _fixed(b"m1")),
    (b"qsThreadInfo", _fixed(b"l")),
    (b"qCRC:", Session._checksum),
    (b"qC", _fixed(b"QC1")),
    (b"vCont", Session._v_cont),
    (b"vKill", Session._kill),
    (b"vRun", Session._run),
    (b"v", _fixed(b"")),
    (b"q", _fixed(b"")),
    (b"?", lambda session, data: session.stopped()),
    (b"!", Session._extend),
    (b"c", lambda session, data: session._resume(False, data)),
    (b"s", lambda session, data: session._resume(True, data)),
    (b"C", lambda session, data: session._resume(False, data.partition(b";")[2])),
    (b"S", lambda session, data: session._resume(True, data.partition(b";")[2])),
    (b"D", Session._detach),
    (b"k", Session._kill),
    (b"R", Session._restart),
    (b"H", _fixed(OK)),
    (b"T", _fixed(OK)),
    (b"g", lambda session, data: b"".join(map(_word, session._target.registers()))),
    (b"G", Session._set_registers),
    (b"p", lambda session, data: _word(session._target.register(int(data, 16)))),
    (b"P", Session._set_register),
    (b"m", Session._read),
    (b"M", lambda session, data: session._write(data, binary=False)),
    (b"X", lambda session, data: session._write(data, binary=True)),
    (b"Z", lambda session, data: session._point(data, session._target.insert)),
    (b"z", lambda session, data: session._point(data, session._target.remove)),
)
