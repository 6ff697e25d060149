# SPDX-License-Identifier: Apache-2.0
"""Intermediate representation between the assembler's front end, scheduler, allocator and encoder.

The front end produces a `Program` whose operations name virtual registers in single-assignment form
inside each
straight-line region; the scheduler groups them into bundles; the allocator replaces every `Virtual`
by a `Register`; the encoder turns bundles into words.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from asip_asm.diagnostics import Diagnostic


@dataclass(frozen=True)
class Register:
    """Physical register: bank 'zero', 'A', 'B', 'C' or 'K', and index. Bank 'S' is no memory: index
    0 or 1 is the next word of the stream of pipe A or B.
    """

    bank: str
    index: int


@dataclass(frozen=True)
class Virtual:
    """Symbolic register value: the source name and the number of the write that defines it.

    version 0 is the value that a state register holds when a run starts. Versions from 1 on are
    written once in the whole program, and read only in the region that writes them.

    version -1 is the one storage of a name whose value passes from region to region: written any
    number of times, in any region, always by operations of one kind (multiply-add or auxiliary).
    Inside a region all accesses to it keep their order except reads among themselves: a read
    before the region's write gets the old value. One register holds it during the whole program.
    A state of a program with several regions is such a variable: first and last are the same.
    """

    name: str
    version: int


@dataclass(frozen=True)
class Output:
    """Output word as the destination of an auxiliary operation."""

    index: int


ZERO = Register("zero", 0)


def register_name(register: Register) -> str:
    """Name of a register in the assembly language."""
    if register.bank == "S":
        return f"{'AB'[register.index]}+"
    return "zero" if register.bank == "zero" else f"{register.bank.lower()}{register.index}"


@dataclass(frozen=True)
class SourceLine:
    """Place of an operation in the source: file, 1-based line, text, the equation that its comment
    names, and the macro calls that it comes from, innermost first, as 'macro at file:line'.
    """

    file: str
    line: int
    text: str
    equation: str = ""
    expansions: tuple[str, ...] = ()


@dataclass(eq=False)
class Operation:
    """One operation. Unused sources are ZERO; `imm` is the data address of ld and st, the place of
    a seek, the level and rounds of a loop and the lane of vout, `target` the label of a branch.
    `symbols`: the values that were in dst, a, b and c before the allocator replaced them by
    registers. `lanes_of`: pipe of the vector that vout takes a lane of.
    """

    mnemonic: str
    dst: Register | Virtual | Output | None = None
    a: Register | Virtual = ZERO
    b: Register | Virtual = ZERO
    c: Register | Virtual = ZERO
    imm: int | None = None
    target: str | None = None
    source: SourceLine | None = None
    symbols: dict[str, Virtual] = field(default_factory=dict)
    lanes_of: int | None = None

    @property
    def pipe(self) -> int | None:
        """Pipe that it must execute in: that of its stream, or that of the vector it takes a lane
        of; None for any.
        """
        return self.stream if self.stream is not None else self.lanes_of

    @property
    def stream(self) -> int | None:
        """Pipe whose stream it reads; None without one."""
        read = (self.a, self.b, self.c)
        return next((r.index for r in read if isinstance(r, Register) and r.bank == "S"), None)


@dataclass(eq=False)
class Bundle:
    """Operations of one clock cycle by slot (None = nop), whether the run ends here, and the levels
    of the loops whose end mark it has, as bits: it is two before their last bundle.
    """

    slots: list[Operation | None]
    halt: bool = False
    ends: int = 0

    @property
    def operations(self) -> list[Operation]:
        """Those that are there, in the order of their slots."""
        return [op for op in self.slots if op is not None]

    def placed(self) -> Iterator[tuple[int, Operation]]:
        """The operations that exist, each after its slot."""
        return ((slot, op) for slot, op in enumerate(self.slots) if op is not None)


@dataclass(eq=False)
class Region:
    """Straight-line code: entered only at its labels, left only at its end.

    `operations` in program order; `bundles` is set instead where the source wrote braces (a branch
    is then in the last bundle only), and by the scheduler. `halt`: the run ends after this region;
    the last bundle of the region carries it as well. The body of a loop begins after a region whose
    last operation is `loop`; `ends` counts the loops whose bodies end with this one.
    """

    labels: list[str] = field(default_factory=list)
    operations: list[Operation] = field(default_factory=list)
    bundles: list[Bundle] | None = None
    halt: bool = False
    ends: int = 0


@dataclass(eq=False)
class Word:
    """A named word of bank K (constant or input): type 'float' or 'int', bits of a constant."""

    name: str
    index: int
    type: str
    bits: int | None = None


@dataclass(eq=False)
class State:
    """Register that holds its value between runs: `first` is its value at the start, `last` the one
    that it must hold at the end (None: nothing writes it). `pin` is the bank it must live in.
    """

    name: str
    type: str
    bits: int
    first: Virtual
    last: Virtual | None = None
    pin: str | None = None
    register: Register | None = None


@dataclass(eq=False)
class FixedState:
    """State that the source pins to a register; operations name the register itself."""

    name: str
    type: str
    bits: int
    register: Register


@dataclass(eq=False)
class OutputWord:
    """Declared output with its safe value."""

    name: str
    index: int
    safe: int


@dataclass(eq=False)
class StreamBlock:
    """Named words of a pipe's stream: 'A' or 'B', address of the first one, bits; of vectors those
    of the first lane, then of each further one.
    """

    name: str
    pin: str
    address: int
    words: list[int] = field(default_factory=list)
    lanes: list[list[int]] = field(default_factory=list)


@dataclass(eq=False)
class Export:
    """Register that holds its value to the end of the run, for the host to read."""

    name: str
    value: Virtual | Register
    register: Register | None = None


@dataclass(eq=False)
class Program:
    """A whole source file after parsing; `configuration` is one of isa.toml's, `files` are those
    that were read, `parameters` the constants that a host may change between runs, `warnings` what
    the source may not mean.
    """

    title: str = ""
    configuration: str = "fast"
    regions: list[Region] = field(default_factory=list)
    constants: list[Word] = field(default_factory=list)
    parameters: list[str] = field(default_factory=list)
    inputs: list[Word] = field(default_factory=list)
    states: list[State] = field(default_factory=list)
    fixed_states: list[FixedState] = field(default_factory=list)
    outputs: list[OutputWord] = field(default_factory=list)
    exports: list[Export] = field(default_factory=list)
    data: list[int] = field(default_factory=list)
    data_names: dict[str, int] = field(default_factory=dict)
    streams: list[StreamBlock] = field(default_factory=list)
    watchdog: int = 10000
    files: list[Path] = field(default_factory=list)
    warnings: list[Diagnostic] = field(default_factory=list)

    @property
    def bundles(self) -> list[Bundle]:
        """Bundles of all its regions."""
        return [bundle for region in self.regions for bundle in region.bundles or []]

    def placed(self) -> Iterator[tuple[int, int, Operation]]:
        """The operations of its bundles, each after the bundle's address and its slot."""
        for address, bundle in enumerate(self.bundles):
            for slot, op in bundle.placed():
                yield address, slot, op
