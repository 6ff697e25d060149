# SPDX-License-Identifier: Apache-2.0
"""Interpreter of programs before and after scheduling, with uninterpreted operations.

An operation's result is a digest of its mnemonic and operand values, so two runs agree exactly if
their data flow agrees. Loads, stores and branches act as such.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

from asip_asm.ir import ZERO, Operation, Output, Program, Register

STEPS = 20_000
Watch = Callable[[int, dict, list], None]
Groups = list[list[Operation]]


@dataclass
class Result:
    """What a run leaves: outputs, states, exports, the program's own data words."""

    outputs: dict[int, int] = field(default_factory=dict)
    states: dict[str, int] = field(default_factory=dict)
    exports: dict[str, int] = field(default_factory=dict)
    data: list[int] = field(default_factory=list)


def digest(*parts: object) -> int:
    return zlib.crc32(repr(parts).encode())


def taken(mnemonic: str, value: int) -> bool:
    """Whether a branch that reads the value is taken."""
    return mnemonic == "jmp" or (mnemonic == "bz") == (value % 2 == 0)


def run_written(program: Program, values: dict | None = None) -> Result:
    """Run the operations in the order written, on symbols. Braced bundles are not supported.

    `values` gets the last value of every symbol.
    """
    regions = [[[op] for op in region.operations] for region in program.regions]
    states = {s.name: (s.first, s.first if s.last is None else s.last) for s in program.states}
    exports = {export.name: export.value for export in program.exports}
    values = {} if values is None else values
    return _run_program(program, regions, values, states, exports, len(program.data))


def run_bundles(program: Program, words: int, watch: Watch | None = None) -> Result:
    """Run the bundles on physical registers; `words` data words belong to the program itself.

    `watch` is called before each bundle with its address, the registers and the data words, and
    once after the last one.
    """
    regions = [[bundle.operations for bundle in region.bundles] for region in program.regions]
    states = {state.name: (state.register, state.register) for state in program.states}
    exports = {export.name: export.register for export in program.exports}
    return _run_program(program, regions, {}, states, exports, words, watch)


def _run_program(
    program: Program,
    regions: Sequence[Groups],
    registers: dict,
    states: Mapping[str, tuple],
    exports: Mapping[str, object],
    words: int,
    watch: Watch | None = None,
) -> Result:
    """Run the groups of each region; states and exports: where they are at the start and end."""
    groups: Groups = []
    labels: dict[str, int] = {}
    ends: set[int] = set()
    for region, own in zip(program.regions, regions, strict=True):
        labels |= dict.fromkeys(region.labels, len(groups))
        groups += own
        if region.halt:
            groups += [] if own else [[]]
            ends.add(len(groups) - 1)
    registers |= {first: digest("state", name) for name, (first, _) in states.items()}
    result = run(groups, ends, labels, registers, list(program.data), words, watch)
    result.states = {name: registers[last] for name, (_, last) in states.items()}
    result.exports = {name: read(registers, place) for name, place in exports.items()}
    return result


def read(registers: Mapping, source: object) -> int:
    """Value of a source; a word of bank K that nobody has set has one of its own."""
    if source == ZERO:
        return 0
    if isinstance(source, Register) and source.bank == "K":
        return registers.get(source, digest("K", source.index))
    return registers[source]


def run(
    groups: Groups,
    ends: Collection[int],
    labels: Mapping[str, int],
    registers: dict,
    memory: list[int],
    words: int,
    watch: Watch | None = None,
) -> Result:
    """Run groups of operations that read before any of them writes, from address 0 to one of
    `ends`, and change registers and memory. A branch leads to the address of its label, or that in
    `imm`.
    """
    result = Result()
    address = 0
    for _ in range(STEPS):
        if watch:
            watch(address, registers, memory)
        following = address + 1
        writes = []
        for op in groups[address]:
            if _execute(op, registers, memory, words, writes):
                following = labels.get(op.target, op.imm)
        for dst, value in writes:
            if isinstance(dst, int):
                memory[dst] = value
            elif isinstance(dst, Output):
                assert dst.index not in result.outputs
                result.outputs[dst.index] = value
            else:
                registers[dst] = value
        if address in ends:
            if watch:
                watch(len(groups), registers, memory)
            result.data = memory[:words]
            return result
        address = following
    raise AssertionError("the program does not halt")


def _execute(op: Operation, registers: dict, memory: list, words: int, writes: list) -> bool:
    """Execute an operation except for its write; whether it is a branch that is taken."""
    a, b, c = (read(registers, source) for source in (op.a, op.b, op.c))
    indexed = not (isinstance(op.b, Register) and op.b.bank == "zero")
    address = (b + op.imm) % words if indexed and op.imm is not None else op.imm
    if op.mnemonic == "st":
        writes.append((address, a))
    elif op.mnemonic == "ld":
        writes.append((op.dst, memory[address]))
    elif op.mnemonic in ("jmp", "bz", "bnz"):
        return taken(op.mnemonic, a)
    elif op.dst is not None:
        writes.append((op.dst, digest(op.mnemonic, a, b, c)))
    return False


def operations_of(program: Program) -> list[Operation]:
    """All operations in bundles."""
    return [op for _, _, op in program.placed()]
