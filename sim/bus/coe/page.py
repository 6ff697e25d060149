# SPDX-License-Identifier: Apache-2.0
"""docs/ethercat_dictionary.md: every object of the device on the bus."""

from __future__ import annotations

from sim.bus.coe.c_tables import ORIGIN
from sim.bus.coe.dictionary import AXIS_STEP, TYPES, Device, Entry, Object

INTRODUCTION = """\
# Object dictionary of the device on the bus

What a master reads and writes by SDO, and what it may map into process data; what the objects do:
[the application](ethercat_application.md). One source,
`nios_sw/ethercat/dictionary.toml`, gives this page, the C tables, the ESI file
`nios_sw/ethercat/gen/microtick.xml` and the SII image `nios_sw/ethercat/gen/sii.hex`; `make gen`
writes them.

`preop`: written in PREOP only. `rx`, `tx`: may be mapped, from the master or to it. `stored`:
1010 saves it. An increment
(inc) is a length or an angle: object 2011."""


def page(device: Device) -> str:
    lines = [f"<!-- {ORIGIN} -->", INTRODUCTION, "", "## The device's own", ""]
    lines += objects(device.own)
    lines += [
        "",
        "## Each axis",
        "",
        f"Index on the first axis; axis n, 2 to {device.device['axes']}, has it at"
        f" + {AXIS_STEP:X}h (n − 1).",
        "",
        *objects(device.of_axis),
        "",
        "## Process data after reset",
        "",
    ]
    for direction, text in (("rx", "From the master, SM2"), ("tx", "To the master, SM3")):
        lines += [f"{text}: {device.bytes(direction)} bytes.", ""]
        rows = []
        for at, pdo, one, entry in device.places(direction):
            name = one.name if one.kind == "var" else entry.name
            place = f"{one.index:04X}:{entry.subindex:02X}"
            rows.append([str(at), f"{pdo.index:04X}", place, name])
        lines += table(["byte", "PDO", "object", ""], rows) + [""]
    lines += ["## Texts of the diagnosis history", ""]
    texts = enumerate(device.diagnosis, start=1)
    lines += table(["text", "kind", ""], [[str(n), one.kind, one.text] for n, one in texts]) + [""]
    return "\n".join(lines)


def objects(found: list[Object]) -> list[str]:
    rows = []
    for one in found:
        if one.kind != "var":
            rows.append([f"{one.index:04X}", "", f"**{one.name}**", "", "", "", "", one.doc])
        for entry in one.entries:
            if one.kind != "var" and entry.subindex == 0:
                continue
            rows.append(
                [
                    f"{one.index:04X}" if one.kind == "var" else "",
                    f"{entry.subindex:02X}",
                    entry.name,
                    TYPES[entry.type].name,
                    entry.access
                    + (f" {entry.pdo}" if entry.pdo else "")
                    + " stored" * entry.stored,
                    default(entry, one),
                    bounds(entry),
                    " ".join(filter(None, [f"[{entry.unit}]" if entry.unit else "", entry.doc]))
                    or (one.doc if one.kind == "var" else ""),
                ]
            )
    head = ["index", "sub", "name", "type", "access", "default", "allowed", ""]
    return table(head, rows)


def default(entry: Entry, one: Object) -> str:
    if entry.type in ("string", "f32"):
        return str(entry.default or "")
    value = int(entry.default)
    return f"{value:X}h" if one.special or value > 99999 and entry.access == "const" else str(value)


def bounds(entry: Entry) -> str:
    if entry.values:
        return ", ".join(map(str, entry.values))
    return f"{entry.limits[0]}..{entry.limits[1]}" if entry.limits else ""


def table(head: list[str], rows: list[list[str]]) -> list[str]:
    lines = ["| " + " | ".join(head) + " |", "| " + " | ".join("---" for _ in head) + " |"]
    return lines + ["| " + " | ".join(row) + " |" for row in rows]
