# SPDX-License-Identifier: Apache-2.0
"""Listing and symbol table of a program image."""

from __future__ import annotations

from asip_asm.assembly_text import note
from asip_asm.diagnostics import counted
from asip_asm.disassemble import decode_bundle
from asip_asm.expression import literal_name
from asip_asm.image import Image, SourceEntry
from asip_asm.isa import default_isa
from asip_asm.loops import back_edges
from asip_asm.machine import load_machine


def listing(image: Image) -> str:
    """Bundles with address, issue cycle, words and source, and the operations of each equation.

    The issue cycle is that of a run in which no branch is taken and loops have one round.
    """
    isa = default_isa()
    machine = load_machine(image.configuration)
    bundles = [decode_bundle(int(word, 16), image.configuration, isa) for word in image.bundles]
    issues = machine.issue_cycles(bundles)
    turns = back_edges(bundles)
    labels: dict[int, list[str]] = {}
    for name, address in image.labels.items():
        labels.setdefault(address, []).append(name)
    rows = [
        f"; {note(image.title) or 'untitled'}",
        f"; configuration {image.configuration}, {counted(len(bundles), 'bundle')}"
        + (f", {image.cycles} cycles" if image.cycles is not None else ", with branches"),
        "; address  cycle  bundle",
    ]
    for address, (word, bundle, entries) in enumerate(
        zip(image.bundles, bundles, image.sources, strict=True)
    ):
        rows += [f"{label}:" for label in labels.get(address, [])]
        end = "  halt" if bundle.halt else "".join("  endloop" for _ in turns.get(address, []))
        rows.append(f"     {address:04x}  {issues[address].cycle:5d}  {word}{end}")
        rows += [f"{' ' * 18}{_source(entry)}" for entry in entries]
    return "\n".join(rows) + "\n"


def _source(entry: SourceEntry) -> str:
    equation = f"  ({entry.equation})" if entry.equation else ""
    return f"{entry.slot}: {entry.text:40s} ; {entry.file}:{entry.line}{equation}"


def symbols(image: Image) -> str:
    """Symbol table: kind, place, name, value."""
    rows = [("input", f"k{i.index}", i.name, i.type) for i in image.inputs]
    rows += [
        (
            "constant",
            f"k{c.index}",
            c.name,
            f"{c.type} {c.bits} {literal_name(int(c.bits, 16), c.type)}",
        )
        for c in image.constants
    ]
    rows += [("output", f"o{o.index}", o.name, f"safe {o.safe}") for o in image.outputs]
    rows += [("state", s.register, s.name, f"{s.type} {s.bits}") for s in image.states]
    rows += [("export", e.register, e.name, "") for e in image.exports]
    rows += [
        ("stream", f"{s.pin}{s.address:04x}", s.name, counted(len(s.words), "word"))
        for s in image.streams
    ]
    rows += [("data", f"{address:04x}", name, "") for name, address in image.data_names.items()]
    rows += [("label", f"{address:04x}", name, "") for name, address in image.labels.items()]
    return "".join(
        f"{k:9s}{place:6s}{name:24s}{value}".rstrip() + "\n" for k, place, name, value in rows
    )
