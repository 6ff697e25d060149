# SPDX-License-Identifier: Apache-2.0
"""The application of the device on the bus, compiled for this machine, with doubles of the slave
controller and of the flash in place of the hardware: what a master does to registers and memory,
without frames.

`Host` is one device. Its machine is ideal: an axis with power is where its set-point says, unless a
test holds it (`held`) or moves it (`positions`).
"""

from __future__ import annotations

import ctypes as ct
import hashlib
import os
import struct
import subprocess
import tempfile
from pathlib import Path
from typing import Self

from asip_asm.project import BUILD, ROOT
from sim.bus.coe.dictionary import Device, load
from sim.bus.gen.esc_regmap import AL_CONTROL, AL_STATUS, AL_STATUS_CODE, SM_START
from tests.ethercat import managers

APPLICATION = ROOT / "nios_sw/ethercat"  # tests of planted faults put a changed copy in its place
HERE = Path(__file__).parent
FLAGS = ("-std=c11", "-Wall", "-Wextra", "-Werror", "-g", "-O1", "-ffp-contract=off")
INIT, PREOP, BOOT, SAFEOP, OP = 1, 2, 3, 4, 8
ERROR = AL_STATUS.word(error=1)  # in AL_CONTROL: acknowledged
AXES = 5
DEVICE: Device = load()
# Of each direction: offset in the process data, format, object and subindex.
PLACES = {
    side: [
        (at, struct.Struct(entry.format), (one.index, entry.subindex))
        for at, _, one, entry in DEVICE.places(side)
    ]
    for side in ("rx", "tx")
}
BYTES = {side: DEVICE.bytes(side) for side in PLACES}


def sources() -> list[Path]:
    """The application without what only the Nios II system has."""
    found = [*APPLICATION.glob("*.c"), *APPLICATION.glob("gen/*.c"), *HERE.glob("*_double.c")]
    return sorted(path for path in found if not path.stem.endswith("_nios"))


def build(name: str, *options: str, extra: tuple[Path, ...] = ()) -> Path:
    """Compile once for each content of the sources."""
    files = [*sources(), *extra]
    headers = [*APPLICATION.glob("*.h"), *APPLICATION.glob("gen/*.h"), *HERE.glob("*.h")]
    content = b"".join(p.read_bytes() for p in [*files, *sorted(headers)]) + str(options).encode()
    place = BUILD / "ethercat" / f"{name}-{hashlib.sha256(content).hexdigest()[:16]}"
    if not place.exists():
        place.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=place.parent) as folder:
            made = Path(folder, name)
            includes = (f"-I{path}" for path in (ROOT / "nios_sw/include", APPLICATION, HERE))
            command = ["gcc", *FLAGS, *options, *includes, *map(str, files), "-o", made, "-lm"]
            subprocess.run(command, check=True)
            os.replace(made, place)
    return place


def device_library(cycle_ns: int = 100_000) -> Path:
    """The application as a shared library; undefined behaviour ends the program."""
    checks = ("-fsanitize-undefined-trap-on-error", "-fsanitize=undefined")
    return build("device.so", "-shared", "-fPIC", *checks, f"-DCYCLE_100NS={cycle_ns // 100}")


class AxisFeedback(ct.Structure):
    _fields_ = [
        ("position", ct.c_int32),
        ("torque", ct.c_int16),
        ("fault", ct.c_uint16),
        ("index_position", ct.c_int32),
        ("index_count", ct.c_uint16),
        ("switches", ct.c_uint16),
    ]


class Feedback(ct.Structure):
    _fields_ = [
        ("axis", AxisFeedback * AXES),
        ("pose", ct.c_float * AXES),
        ("digital_inputs", ct.c_uint8),
        ("edge_age", ct.c_uint16 * 2),
    ]


class AxisCommand(ct.Structure):
    _fields_ = [
        ("position", ct.c_int32),
        ("fraction", ct.c_float),
        ("velocity", ct.c_float),
        ("acceleration", ct.c_float),
        ("torque", ct.c_int16),
        ("power", ct.c_bool),
        ("torque_only", ct.c_bool),
    ]


class Command(ct.Structure):
    _fields_ = [
        ("axis", AxisCommand * AXES),
        ("digital_outputs", ct.c_uint8),
        ("setting_number", ct.c_uint32),
        ("setting_index", ct.c_uint16),
        ("setting_subindex", ct.c_uint8),
        ("setting_value", ct.c_float),
    ]


class AbortedError(Exception):
    """The server refused; `code` is the abort code."""

    def __init__(self, code: int) -> None:
        self.code = code
        super().__init__(f"abort {code:08X}")


class Host:
    """One device after power on. A library has one device: use one at a time."""

    PATIENCE = 50  # rounds of the background until an answer comes
    CYCLE_NS = 100_000  # of the control

    def __init__(self) -> None:
        self.library = ct.CDLL(str(device_library(self.CYCLE_NS)))
        self.library.double_read.restype = self.library.double_write.restype = ct.c_bool
        self.feedback, self.command = Feedback(), Command()
        self.held: set[int] = set()
        self.counter = 0
        self.library.flash_double_clear()
        self.power_on()

    def power_on(self) -> None:
        """All but the flash begins again."""
        self.library.double_reset()
        self.library.flash_double_power_on()
        self.library.application_start()

    # ---------------------------------------------------------------- the master's accesses
    def read(self, address: int, count: int) -> bytes | None:
        """Bytes, None where the access does not count."""
        data = ct.create_string_buffer(count)
        return data.raw if self.library.double_read(address, data, count) else None

    def write(self, address: int, data: bytes) -> bool:
        return self.library.double_write(address, bytes(data), len(data))

    def word(self, address: int) -> int:
        return int.from_bytes(self.read(address, 2), "little")

    def manager(self, n: int, start: int, length: int, control: int, enable: int = 1) -> None:
        self.write(SM_START.at(n), managers.registers(start, length, control, enable))

    # ---------------------------------------------------------------- time
    def cycle(self, count: int = 1) -> None:
        """Control cycles, with some passes of the background after each."""
        for _ in range(count):
            self.library.double_time(self.CYCLE_NS)
            self.library.application_cycle(ct.byref(self.feedback), ct.byref(self.command))
            for n, axis in enumerate(self.command.axis):
                if axis.power and not axis.torque_only and n not in self.held:
                    self.feedback.axis[n].position = axis.position
            self.background()

    def background(self) -> None:
        """Some passes of it."""
        for _ in range(3):
            self.library.application_background()

    # ---------------------------------------------------------------- states
    @property
    def status(self) -> tuple[int, int]:
        """AL_STATUS and AL_STATUS_CODE."""
        return self.word(AL_STATUS.address), self.word(AL_STATUS_CODE.address)

    def ask(self, state: int) -> tuple[int, int]:
        self.write(AL_CONTROL.address, struct.pack("<H", state))
        self.background()
        return self.status

    def mailboxes(self) -> None:
        self.manager(0, 0x1000, 256, managers.BOX_OUT)
        self.manager(1, 0x1100, 256, managers.BOX_IN)

    def to_preop(self) -> Self:
        self.mailboxes()
        assert self.ask(PREOP) == (PREOP, 0)
        return self

    def process_managers(self, outputs: int = 0) -> None:
        self.manager(2, 0x1200, outputs or DEVICE.bytes("rx"), managers.OUTPUTS)
        self.manager(3, 0x1800, DEVICE.bytes("tx"), managers.INPUTS)

    def to_safeop(self) -> Self:
        self.to_preop()
        self.process_managers()
        assert self.ask(SAFEOP) == (SAFEOP, 0)
        return self

    def to_op(self) -> Self:
        self.to_safeop()
        self.outputs()
        self.cycle()
        assert self.ask(OP) == (OP, 0)
        return self

    def to_boot(self) -> Self:
        self.mailboxes()
        assert self.ask(BOOT) == (BOOT, 0)
        return self

    # ---------------------------------------------------------------- process data
    def outputs(self, values: dict[tuple[int, int], int] | None = None) -> None:
        """Write SM2 as mapped after reset; what is not in `values` is 0."""
        values, data = values or {}, bytearray(BYTES["rx"])
        for at, number, key in PLACES["rx"]:
            number.pack_into(data, at, values.get(key, 0))
        self.write(0x1200, data)

    def inputs(self) -> dict[tuple[int, int], int]:
        """SM3 as mapped after reset."""
        data = self.read(0x1800, BYTES["tx"])
        return {key: number.unpack_from(data, at)[0] for at, number, key in PLACES["tx"]}

    # ---------------------------------------------------------------- mailbox
    def send(self, data: bytes, kind: int = 3, counter: int | None = None) -> bool:
        """A message into SM0; whether the mailbox took it."""
        if counter is None:
            self.counter = counter = self.counter % 7 + 1
        head = struct.pack("<HHBB", len(data), 0, 0, kind | counter << 4)
        return self.write(0x1000, (head + data).ljust(256, b"\0"))

    def receive(self) -> tuple[int, bytes] | None:
        """Type and data of the message in SM1."""
        data = self.read(0x1100, 256)
        if data is None:
            return None
        size, _, _, kind = struct.unpack_from("<HHBB", data)
        return kind & 0xF, data[6 : 6 + size]

    def coe(self, service: int, data: bytes) -> bytes:
        """A request and its answer after the CoE header; emergencies are put aside."""
        assert self.send(struct.pack("<H", service << 12) + data)
        for _ in range(self.PATIENCE):
            self.background()
            if not (message := self.receive()):
                continue
            kind, answer = message
            self.background()
            assert kind == 3, (kind, answer)
            if answer[1] >> 4 != 1:
                return answer[2:]
        raise AssertionError("no answer")

    def sdo(self, request: bytes) -> bytes:
        answer = self.coe(2, request)
        if answer[0] == 0x80:
            raise AbortedError(struct.unpack_from("<I", answer, 4)[0])
        return answer

    def upload(self, index: int, subindex: int = 0, complete: bool = False) -> bytes:
        command = 0x50 if complete else 0x40
        answer = self.sdo(struct.pack("<BHB4x", command, index, subindex))
        assert struct.unpack_from("<HB", answer, 1) == (index, subindex)
        if answer[0] & 2:
            return answer[4 : 8 - (answer[0] >> 2 & 3)]
        total = struct.unpack_from("<I", answer, 4)[0]
        data, toggle = answer[8:], 0
        while len(data) < total:
            answer = self.sdo(struct.pack("<B7x", 0x60 | toggle))
            assert answer[0] & 0xF0 == toggle
            part = answer[1:]
            if len(answer) == 8:
                part = part[: 7 - (answer[0] >> 1 & 7)]
            data += part
            toggle ^= 0x10
            assert bool(answer[0] & 1) == (len(data) == total)
        assert len(data) == total
        return data

    def download(
        self, index: int, subindex: int, data: bytes, complete: bool = False, segment: int = 0
    ) -> None:
        """Expedited up to 4 bytes; more than the mailbox holds, or `segment`, in segments."""
        ca = 0x10 if complete else 0
        if len(data) <= 4 and not complete:
            command = 0x23 | (4 - len(data)) << 2
            answer = self.sdo(struct.pack("<BHB", command, index, subindex) + data.ljust(4, b"\0"))
            assert answer[0] == 0x60
            return
        room = 240 if not segment else 0
        head = struct.pack("<BHBI", 0x21 | ca, index, subindex, len(data))
        assert self.sdo(head + data[:room])[0] == 0x60
        at, toggle, size = room, 0, segment or 247
        while at < len(data):
            part = data[at : at + size]
            at += len(part)
            command = toggle | (at >= len(data)) | (7 - len(part) << 1 if len(part) < 7 else 0)
            answer = self.sdo(bytes([command]) + part.ljust(7, b"\0"))
            assert answer[0] == 0x20 | toggle
            toggle ^= 0x10

    def put(self, index: int, subindex: int, value: float) -> None:
        """Write a number of the entry's type."""
        entry = DEVICE.object(index).entry(subindex)
        self.download(index, subindex, struct.pack(entry.format, value))

    def get(self, index: int, subindex: int = 0) -> float:
        entry = DEVICE.object(index).entry(subindex)
        return struct.unpack(entry.format, self.upload(index, subindex))[0]


class Short(Host):
    """A device built for a control cycle of 62.5 us."""

    CYCLE_NS = 62_500
