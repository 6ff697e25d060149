# SPDX-License-Identifier: Apache-2.0
"""The device on the bus from its one source, nios_sw/ethercat/dictionary.toml.

`load` gives every object of the device, those of an axis once for each axis, and the process data
that a master maps by itself. A finding in the file is a DictionaryError with the place in its text.
Types and object codes: CiA 301; mapping objects and sync managers: ETG.1000.6.
"""

from __future__ import annotations

import builtins
import re
import struct
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from asip_asm.project import ROOT

SOURCE = ROOT / "nios_sw/ethercat/dictionary.toml"
AXIS_FIRST, AXIS_STEP = 0x6000, 0x800
RX_MAP, TX_MAP, MAP_STEP = 0x1600, 0x1A00, 0x10
MAP_ENTRIES = 10  # of one PDO


class DictionaryError(ValueError):
    """The source does not describe a device; the text says where and why."""


@dataclass(frozen=True)
class Type:
    """A data type: code of CiA 301, name in an ESI file, bits, format of struct."""

    code: int
    name: str
    bits: int
    format: str
    c: str


TYPES = {
    "bool": Type(0x01, "BOOL", 1, "B", "uint8_t"),
    "i8": Type(0x02, "SINT", 8, "b", "int8_t"),
    "i16": Type(0x03, "INT", 16, "h", "int16_t"),
    "i32": Type(0x04, "DINT", 32, "i", "int32_t"),
    "u8": Type(0x05, "USINT", 8, "B", "uint8_t"),
    "u16": Type(0x06, "UINT", 16, "H", "uint16_t"),
    "u32": Type(0x07, "UDINT", 32, "I", "uint32_t"),
    "f32": Type(0x08, "REAL", 32, "f", "float"),
    "string": Type(0x09, "STRING", 0, "s", "char"),
    "octets": Type(0x0A, "OCTET_STRING", 0, "s", "uint8_t"),
}
ACCESS = ("ro", "rw", "const", "preop")
FIELD = re.compile(r"[A-Za-z_]\w*(\[\d+\]|\.[A-Za-z_]\w*)?", re.ASCII)
KINDS = {"var": 7, "array": 8, "record": 9}


@dataclass(frozen=True)
class Entry:
    """One subindex. limits, values: what a write may bring; field: its name in C, in `struct
    objects` or `struct axis_objects`."""

    subindex: int
    name: str
    type: str
    access: str
    field: str = ""
    default: Any = 0
    limits: tuple[float, float] | None = None
    values: tuple[int, ...] = ()
    pdo: str = ""
    unit: str = ""
    doc: str = ""
    bytes: int = 0
    stored: bool = False  # by object 1010

    @property
    def bits(self) -> int:
        return 1 if self.type == "bool" else 8 * self.bytes

    @property
    def format(self) -> str:
        """Of struct, for a value as it is in memory."""
        return "<" + TYPES[self.type].format

    def data(self) -> builtins.bytes:
        """The default as it is in memory."""
        if self.type == "string":
            return str(self.default or "").encode()
        if self.type == "octets":
            return bytes(self.bytes)
        return struct.pack(self.format, self.default)


@dataclass(frozen=True)
class Object:
    """An index. axis: 0 to 4, None for the device's own; special: `assign`, `map` or empty."""

    index: int
    name: str
    kind: str
    entries: tuple[Entry, ...]
    doc: str = ""
    axis: int | None = None
    special: str = ""

    def entry(self, subindex: int) -> Entry:
        return next(e for e in self.entries if e.subindex == subindex)


@dataclass(frozen=True)
class Pdo:
    """A process data object as it is after reset: (index, subindex, bits), index 0 for padding."""

    index: int
    name: str
    direction: str
    entries: tuple[tuple[int, int, int], ...]

    @property
    def bytes(self) -> int:
        return sum(bits for _, _, bits in self.entries) // 8


DIAGNOSIS_KINDS = ("info", "warning", "error")


@dataclass(frozen=True)
class Text:
    """A text of the diagnosis history: name in C, kind (DIAGNOSIS_KINDS), text with `%x` or `%d`
    for two parameters."""

    name: str
    kind: str
    text: str


@dataclass(frozen=True)
class Device:
    """All of the device. `objects` by rising index."""

    device: dict[str, Any]
    mailbox: dict[str, int]
    process_data: dict[str, int]
    objects: tuple[Object, ...]
    pdos: tuple[Pdo, ...]
    diagnosis: tuple[Text, ...]

    @property
    def own(self) -> list[Object]:
        """Objects of the device itself."""
        return [o for o in self.objects if o.axis is None]

    @property
    def of_axis(self) -> list[Object]:
        """Objects of the first axis; each axis has such."""
        return [o for o in self.objects if o.axis == 0]

    def object(self, index: int) -> Object:
        return next(o for o in self.objects if o.index == index)

    def direction(self, direction: str) -> tuple[Pdo, ...]:
        """PDOs `rx` (from the master) or `tx`."""
        return tuple(p for p in self.pdos if p.direction == direction)

    def bytes(self, direction: str) -> int:
        """Process data of one direction after reset [byte]."""
        return sum(p.bytes for p in self.direction(direction))

    def places(self, direction: str) -> Iterator[tuple[int, Pdo, Object, Entry]]:
        """What is mapped after reset except for padding: its first byte in the process data, its
        PDO, the object and its entry."""
        at = 0
        for pdo in self.direction(direction):
            for index, subindex, bits in pdo.entries:
                if index:
                    one = self.object(index)
                    yield at, pdo, one, one.entry(subindex)
                at += bits // 8


def load(path: Path = SOURCE) -> Device:
    """Read the source. Raises DictionaryError."""
    try:
        return _Reader(tomllib.loads(path.read_text(encoding="utf-8"))).device()
    except (tomllib.TOMLDecodeError, DictionaryError) as error:
        raise DictionaryError(f"{path}: {error}") from None
    except KeyError as error:
        raise DictionaryError(f"{path}: no {error}") from None


class _Reader:
    def __init__(self, document: dict[str, Any]) -> None:
        unknown = set(document) - {
            *("device", "mailbox", "process_data", "pdo", "device_pdo", "object", "axis_object"),
            "diagnosis",
        }
        if unknown:
            raise DictionaryError(f"unknown table {', '.join(sorted(unknown))}")
        self.document = document
        self.head = document["device"]
        self.axes = self.head["axes"]

    def device(self) -> Device:
        own = [self.object(record) for record in self.document["object"]]
        axis = [self.object(record) for record in self.document["axis_object"]]
        for one in axis:
            if not AXIS_FIRST <= one.index < AXIS_FIRST + AXIS_STEP:
                raise DictionaryError(f"object {one.index:04X}: no place of axis 0")
        pdos = self.pdos(own, axis)
        own += [self.mapping(pdo) for pdo in pdos]
        own = [self.assigned(o, pdos) if o.special == "assign" else o for o in own]
        every = own + [
            replace(o, index=o.index + AXIS_STEP * n, axis=n)
            for n in range(self.axes)
            for o in axis
        ]
        every.sort(key=lambda o: o.index)
        for before, after in zip(every, every[1:], strict=False):
            if before.index == after.index:
                raise DictionaryError(f"object {after.index:04X} appears twice")
        self.check_cycle(every)
        mailbox, process_data = self.document["mailbox"], self.document["process_data"]
        texts = tuple(self.text(record) for record in self.document["diagnosis"])
        return Device(self.head, mailbox, process_data, tuple(every), tuple(pdos), texts)

    def check_cycle(self, objects: list[Object]) -> None:
        """Whether `cycle_us` divides a millisecond, and 1C32:05 and 1C33:05 state it."""
        tenths = round(10 * self.head["cycle_us"])
        if tenths != 10 * self.head["cycle_us"] or tenths < 1 or 10_000 % tenths:
            raise DictionaryError(
                f"cycle_us = {self.head['cycle_us']}: a millisecond has to be a whole number of "
                "cycles, and a cycle a whole number of 0.1 us; write 62.5, 100, 125, 250 or 500"
            )
        for one in objects:
            if one.index in (0x1C32, 0x1C33) and one.entry(5).default != 100 * tenths:
                raise DictionaryError(
                    f"object {one.index:04X}:05 has default = {one.entry(5).default}, but cycle_us "
                    f"makes it {100 * tenths} ns"
                )

    def text(self, record: dict[str, Any]) -> Text:
        found = Text(**record)
        if found.kind not in DIAGNOSIS_KINDS:
            raise DictionaryError(
                f"diagnosis {found.name}: kind {found.kind!r}, not of {', '.join(DIAGNOSIS_KINDS)}"
            )
        return found

    def object(self, record: dict[str, Any]) -> Object:
        place = f"object {record['index']:04X}"
        rest = dict(record)
        index, name, doc = rest.pop("index"), rest.pop("name"), rest.pop("doc", "")
        if "assign" in rest:
            return Object(index, name, "array", (), doc, special="assign")
        if "array" in rest:
            entries = self.array(dict(rest["array"]), place)
            return Object(index, name, "array", counted(entries), doc)
        if "record" in rest:
            fields = enumerate(rest["record"], start=1)
            entries = [self.entry(dict(entry), at, place) for at, entry in fields]
            entries += self.messages(rest.get("messages"), len(entries), place)
            return Object(index, name, "record", counted(entries), doc)
        return Object(index, name, "var", (self.entry({**rest, "name": name}, 0, place),), doc)

    def messages(self, rest: dict[str, Any] | None, before: int, place: str) -> list[Entry]:
        """Octet strings after the other entries of a record."""
        if not rest:
            return []
        found = []
        for n in range(rest["count"]):
            name, field = f"{rest['name']} {n + 1}", f"{rest['field']}[{n}]"
            entry = {"name": name, "field": field, "bytes": rest["bytes"]}
            entry |= {"type": "octets", "access": "ro"}
            found.append(self.entry(entry, before + n + 1, place))
        return found

    def array(self, rest: dict[str, Any], place: str) -> list[Entry]:
        count, element, base = rest.pop("count"), rest.pop("element"), rest.pop("field")
        defaults = rest.pop("defaults", [rest.pop("default", 0)] * count)
        if len(defaults) != count:
            raise DictionaryError(f"{place}: {len(defaults)} defaults for {count} elements")
        return [
            self.entry(
                {**rest, "name": f"{element} {n + 1}", "field": f"{base}[{n}]", "default": value},
                n + 1,
                place,
            )
            for n, value in enumerate(defaults)
        ]

    def entry(self, rest: dict[str, Any], subindex: int, place: str) -> Entry:
        subindex = rest.pop("subindex", subindex)
        place = f"{place}:{subindex:02X}"
        known = set(Entry.__dataclass_fields__)
        if set(rest) - known:
            raise DictionaryError(f"{place}: unknown key {', '.join(sorted(set(rest) - known))}")
        if rest.get("type") not in TYPES:
            raise DictionaryError(f"{place}: type {rest.get('type')!r}, not of {', '.join(TYPES)}")
        if rest.get("access") not in ACCESS:
            raise DictionaryError(
                f"{place}: access {rest.get('access')!r}, not of {', '.join(ACCESS)}"
            )
        if rest.get("pdo", "") not in ("", "rx", "tx"):
            raise DictionaryError(f"{place}: pdo {rest['pdo']!r}, not rx or tx")
        if rest.get("pdo") == "rx" and rest["access"] != "rw":
            raise DictionaryError(f"{place}: the master maps it as output but may not write it")
        if rest.get("stored") and (rest["access"] != "rw" or rest["type"] == "string"):
            raise DictionaryError(f"{place}: stored, but not a number that the master may write")
        default = rest.get("default", 0)
        if isinstance(default, str) and default.startswith("@"):
            rest["default"] = default = self.head[default[1:]]
        for key in ("limits", "values"):
            if key in rest:
                rest[key] = tuple(rest[key])
        if rest["type"] == "string":
            rest.setdefault("bytes", len(str(default or "")))
        elif rest["type"] != "octets":
            rest["bytes"] = (TYPES[rest["type"]].bits + 7) // 8
        found = Entry(subindex=subindex, **rest)
        if not found.field and found.type != "string":
            raise DictionaryError(f"{place}: no field")
        if found.field and not FIELD.fullmatch(found.field):
            raise DictionaryError(
                f"{place}: field {found.field!r} is no C name, name[number] or name.name"
            )
        check_default(found, place)
        return found

    def pdos(self, own: list[Object], axis: list[Object]) -> list[Pdo]:
        """Those of the axes, then the device's own; first rx, then tx."""
        found = []
        for record in self.document["pdo"]:
            for n in range(self.axes):
                entries = mapped(record, axis, AXIS_STEP * n)
                index, name = record["index"] + MAP_STEP * n, f"{record['name']} {n + 1}"
                found.append(Pdo(index, name, direction_of(record), entries))
        for record in self.document["device_pdo"]:
            entries = mapped(record, own, 0)
            found.append(Pdo(record["index"], record["name"], direction_of(record), entries))
        found.sort(key=lambda p: p.index)
        for direction, limit in (("rx", "outputs"), ("tx", "inputs")):
            total = sum(p.bytes for p in found if p.direction == direction)
            if total > self.document["process_data"]["bytes"]:
                raise DictionaryError(f"{total} bytes of {limit} do not fit the process data")
            for number, pdo in enumerate(p for p in found if p.direction == direction):
                first = RX_MAP if direction == "rx" else TX_MAP
                if pdo.index != first + MAP_STEP * number:
                    raise DictionaryError(f"PDO {pdo.index:04X}: not in steps of {MAP_STEP:X}")
        return found

    def mapping(self, pdo: Pdo) -> Object:
        side, first = (0, RX_MAP) if pdo.direction == "rx" else (1, TX_MAP)
        base = f"map[{side}][{(pdo.index - first) // MAP_STEP}]"
        values = [index << 16 | sub << 8 | bits for index, sub, bits in pdo.entries]
        room = values + [0] * (MAP_ENTRIES - len(values))
        entries = listed("Entry", "u32", base, "entry", room, len(values))
        return Object(pdo.index, pdo.name, "record", entries, "mapping", special="map")

    def assigned(self, found: Object, pdos: list[Pdo]) -> Object:
        side, direction = (0, "rx") if found.index == 0x1C12 else (1, "tx")
        mine = [p.index for p in pdos if p.direction == direction]
        entries = listed("PDO", "u16", f"assign[{side}]", "pdo", mine, len(mine))
        return replace(found, entries=entries)


def listed(
    name: str, kind: str, base: str, field: str, values: list[int], count: int
) -> tuple[Entry, ...]:
    """Entries that a master writes in PREOP, after subindex 0, which says how many count."""
    size = TYPES[kind].bits // 8
    first = Entry(0, "Number of entries", "u8", "preop", f"{base}.count", count, bytes=1)
    rest = (
        Entry(n + 1, f"{name} {n + 1}", kind, "preop", f"{base}.{field}[{n}]", value, bytes=size)
        for n, value in enumerate(values)
    )
    return (first, *rest)


def counted(entries: list[Entry]) -> tuple[Entry, ...]:
    """The entries after subindex 0, which is the highest subindex."""
    last = entries[-1].subindex
    return (Entry(0, "Number of entries", "u8", "const", "", last, bytes=1), *entries)


def direction_of(record: dict[str, Any]) -> str:
    return "rx" if record["index"] < TX_MAP else "tx"


def mapped(record: dict[str, Any], objects: list[Object], shift: int) -> tuple:
    """Entries of a PDO by the C names of its objects; an empty name is a byte of padding."""
    fields = {e.field: (o, e) for o in objects for e in o.entries if e.field}
    found = []
    for name in record["objects"]:
        if not name:
            found.append((0, 0, 8))
            continue
        if name not in fields:
            raise DictionaryError(f"PDO {record['index']:04X}: no object {name!r}")
        one, entry = fields[name]
        if entry.pdo != direction_of(record):
            raise DictionaryError(f"PDO {record['index']:04X}: {name!r} is not to be mapped there")
        found.append((one.index + shift, entry.subindex, entry.bits))
    if len(found) > MAP_ENTRIES:
        raise DictionaryError(f"PDO {record['index']:04X}: more than {MAP_ENTRIES} entries")
    return tuple(found)


def check_default(entry: Entry, place: str) -> None:
    try:
        entry.data()
    except struct.error as error:
        raise DictionaryError(f"{place}: default {entry.default!r}: {error}") from None
    if entry.values and entry.default not in entry.values:
        raise DictionaryError(f"{place}: default {entry.default!r} is not of its values")
    if entry.limits and not entry.limits[0] <= entry.default <= entry.limits[1]:
        raise DictionaryError(f"{place}: default {entry.default!r} is beyond its limits")
