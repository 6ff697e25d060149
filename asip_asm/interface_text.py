# SPDX-License-Identifier: Apache-2.0
"""Texts made of an interface record: declarations of the assembler, C, Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

from asip_asm.signals import Interface, Number, Signal

C_TYPES = {"float": "float", "int": "int32_t"}


def assembly(interface: Interface) -> Iterator[tuple[Path, int, str]]:
    """Declarations for the assembler except the parameter file's, each with file and line."""
    for signal in interface.of_kind("parameter"):
        yield _at(signal, f".param {signal.name} = {_number(signal.initial)}")
    for name, (value, file, line) in interface.constants.items():
        yield file, line, f".const {name} = {_number(value)}"
    for signal in interface.signals:
        kind = " : int" if signal.type == "int" else ""
        match signal.kind:
            case "input":
                yield _at(signal, f".input {signal.name}{kind}")
            case "output":
                yield _at(signal, f".output {signal.name}, safe = {_number(signal.safe)}")
            case "state":
                yield _at(signal, f".state {signal.name}{kind} = {_number(signal.initial)}")
            case "export":
                yield _at(signal, f".export {signal.name}")


def c_struct(interface: Interface, kind: str, name: str) -> str:
    """C structure of the inputs or outputs, 32 bits each, in order; vectors are arrays."""
    lines = [f"struct {name} {{"]
    for vector, group in groupby(interface.of_kind(kind), lambda signal: signal.vector):
        signals = list(group)
        units = ", ".join(dict.fromkeys(signal.unit for signal in signals))
        types = {signal.type for signal in signals}
        if vector and len(types) == 1:
            meanings = dict.fromkeys(signal.meaning for signal in signals)
            comment = f"/* {'; '.join(meanings)} [{units}] */"
            lines.append(f"  {C_TYPES[types.pop()]} {vector}[{len(signals)}]; {comment}")
            continue
        for signal in signals:
            comment = f"/* {signal.meaning} [{signal.unit}] */"
            lines.append(f"  {C_TYPES[signal.type]} {signal.name}; {comment}")
    return "\n".join([*lines, "};", ""])


def markdown(interface: Interface) -> list[str]:
    """Tables of the inputs, outputs, states and exports; limits and values as they are written."""
    lines: list[str] = []
    for kind, value in (
        ("input", "scale"),
        ("output", "safe"),
        ("state", "initial"),
        ("export", ""),
    ):
        signals = interface.of_kind(kind)
        if not signals:
            continue
        head = ["word" if kind in ("input", "output") else "", "name", "type", "unit", "limits"]
        head += [value, "meaning"]
        lines += ["", f"## {kind.capitalize()}s", "", _row(head), _row(["---"] * len(head))]
        for index, s in enumerate(signals):
            limits = " .. ".join(f"`{limit}`" for limit in s.limits or ())
            number = getattr(s, value, None) if value else None
            cells = [str(index) if head[0] else "", f"`{s.name}`", s.type, s.unit, limits]
            lines.append(_row([*cells, "" if number is None else f"`{number}`", s.meaning]))
    return lines


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _at(signal: Signal, text: str) -> tuple[Path, int, str]:
    return signal.file, signal.line, text


def _number(number: Number) -> str:
    return number if isinstance(number, str) else repr(number)
