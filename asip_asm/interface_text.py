# SPDX-License-Identifier: Apache-2.0
"""Texts made of an interface record: declarations of the assembler, C, Markdown."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from asip_asm.signals import Interface, Number, Signal


def assembly(interface: Interface) -> Iterator[tuple[Path, int, str]]:
    """Declarations for the assembler but for the parameter file's, each with file and line."""
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


def _at(signal: Signal, text: str) -> tuple[Path, int, str]:
    return signal.file, signal.line, text


def _number(number: Number) -> str:
    return number if isinstance(number, str) else repr(number)
