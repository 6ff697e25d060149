# SPDX-License-Identifier: Apache-2.0
"""What a source file holds after parsing: declarations, statements, operations as written."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from asip_asm.diagnostics import Place
from asip_asm.ir import Register, SourceLine, StreamBlock
from asip_asm.isa import OperationRecord
from asip_asm.lexer import Cursor, Token

NOUNS = {
    "input": "an input",
    "constant": "a constant",
    "state": "a state",
    "output": "an output",
    "data": "data memory",
    "register": "a symbolic register",
    "stream": "a block of a stream",
}

_PHYSICAL = re.compile(r"([abck])([0-9]+)")
_OUTPUT = re.compile(r"o([0-9]+)")


@dataclass(eq=False)
class Declaration:
    """A declared name. `value` is a constant's value in double precision or an address in data
    memory or a stream; `bits` a constant's, state's or safe value's bits; `pin` the bank or
    register it is pinned to, of a stream the pipe.
    `folded`: an expression took the value, so that a word of bank K is not all there is of it.
    """

    kind: str
    name: str
    place: Place
    type: str = "float"
    value: float | None = None
    bits: int = 0
    pin: str | Register | None = None
    replaceable: bool = False
    folded: bool = False


@dataclass(frozen=True)
class Operand:
    """Operand as written: kind 'name', 'value', 'stream' (its next word), 'place' (where a seek
    goes: the immediate), 'count' (rounds of a loop) or 'address' (value + index register name).
    Text is the name, or the block of data memory or of a stream that an expression names.
    """

    kind: str
    place: Place
    text: str = ""
    value: float = 0.0
    index: Operand | None = None


@dataclass(eq=False)
class RawOperation:
    """Operation as written."""

    record: OperationRecord
    place: Place
    operands: Mapping[str, Operand]
    source: SourceLine

    def read_as(self, field: str) -> Operand:
        """Operand that the operation reads in a field: the index of an address in b."""
        operand = self.operands.get(field) or self.operands["address"].index
        if operand is None:
            raise KeyError(field)
        return operand


@dataclass(eq=False)
class Statement:
    """One step of the program text: label, linear operation, bundle in braces, endloop or halt."""

    kind: str
    place: Place
    label: str = ""
    operations: list[RawOperation] = field(default_factory=list)
    halt: bool = False


@dataclass(eq=False)
class Source:
    """A parsed file. `exports` holds (name, place, register name or None), `placed` the constants
    that the source puts at a word of bank K, unnamed ones too, `doubtful` the names in statements
    that have an error: what is missing about them is no error of its own; `incomplete` states that
    an operation may be missing. `used` are the declared names that anything reads, `main_file` is
    the parsed file as messages show it, `files` are all files that were read.
    """

    title: str = ""
    configuration: tuple[str, Place] | None = None
    watchdog: int = 10000
    names: dict[str, Declaration] = field(default_factory=dict)
    placed: list[Declaration] = field(default_factory=list)
    exports: list[tuple[str, Place, str | None]] = field(default_factory=list)
    data: list[int] = field(default_factory=list)
    streams: list[StreamBlock] = field(default_factory=list)
    statements: list[Statement] = field(default_factory=list)
    doubtful: set[str] = field(default_factory=set)
    used: set[str] = field(default_factory=set)
    main_file: str = ""
    files: list[Path] = field(default_factory=list)
    incomplete: bool = False
    last_place: Place | None = None

    def of_kind(self, kind: str) -> list[Declaration]:
        """Declarations of a kind in order."""
        return [d for d in self.names.values() if d.kind == kind]


def stream_words(blocks: Iterable[StreamBlock], pin: str) -> int:
    """Words of a pipe's stream, all its blocks together."""
    return sum(len(block.words) for block in blocks if block.pin == pin)


def physical_register(name: str) -> Register | None:
    """Register that the name denotes, existing or not; None for any other name."""
    if name == "zero":
        return Register("zero", 0)
    match = _PHYSICAL.fullmatch(name)
    # Longer numbers are of no register, whatever their digits.
    return Register(match.group(1).upper(), int(match.group(2)[:6])) if match else None


def output_index(name: str) -> int | None:
    """Index of an output name `o<n>`; None for any other name."""
    match = _OUTPUT.fullmatch(name)
    return int(match.group(1)[:6]) if match else None


def is_reserved(name: str) -> bool:
    """Whether the language itself gives the name a meaning."""
    return name == "pi" or physical_register(name) is not None or output_index(name) is not None


def span(first: Token, cursor: Cursor) -> Place:
    """Characters from a token to the last one consumed."""
    last = cursor.tokens[max(cursor.position - 1, 0)]
    line, column = first.place.line, first.place.column
    if last.place.line is not line:
        return first.place
    return Place(line, column, max(1, last.end - column))


def where(place: Place) -> str:
    return f"{place.line.file}:{place.line.number}"
