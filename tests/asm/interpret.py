# SPDX-License-Identifier: Apache-2.0
"""Interpreter of programs before and after scheduling, with uninterpreted operations.

An operation's result is a digest of its mnemonic and operand values, so two runs agree exactly if
their data flow agrees. Loads, stores and branches act as such.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import accumulate

from asip_asm.ir import Operation, Output, Program, Register

STEPS = 5000
Watch = Callable[[int, dict, list], None]


@dataclass
class Result:
    """What a run leaves behind: outputs, states, exports, the program's own data words."""

    outputs: dict[int, int] = field(default_factory=dict)
    states: dict[str, int] = field(default_factory=dict)
    exports: dict[str, int] = field(default_factory=dict)
    data: list[int] = field(default_factory=list)


def digest(*parts: object) -> int:
    return zlib.crc32(repr(parts).encode())


def run_written(program: Program, values: dict | None = None) -> Result:
    """Run the operations in the order written, on symbols. Braced bundles are not supported.

    `values` gets the last value of every symbol.
    """
    groups = [[[op] for op in region.operations] for region in program.regions]
    first = {state.first: digest("state", state.name) for state in program.states}
    values = {} if values is None else values
    values |= _run(program, groups, first, len(program.data))
    result = values.pop("result")
    for state in program.states:
        result.states[state.name] = values[state.first if state.last is None else state.last]
    for export in program.exports:
        result.exports[export.name] = _read(values, export.value)
    return result


def run_bundles(program: Program, words: int, watch: Watch | None = None) -> Result:
    """Run the bundles on physical registers; `words` data words belong to the program itself.

    `watch` is called before each bundle with its address, the registers and the data words, and
    once behind the last one.
    """
    groups = [
        [[op for op in bundle.slots if op is not None] for bundle in region.bundles]
        for region in program.regions
    ]
    first = {state.register: digest("state", state.name) for state in program.states}
    values = _run(program, groups, first, words, watch)
    result = values.pop("result")
    for state in program.states:
        result.states[state.name] = values[state.register]
    for export in program.exports:
        result.exports[export.name] = _read(values, export.register)
    return result


def _read(registers: dict, source) -> int:
    if isinstance(source, Register) and source.bank in ("zero", "K"):
        return 0 if source.bank == "zero" else digest("K", source.index)
    return registers[source]


def _path(program: Program) -> dict[str, int]:
    return {label: i for i, region in enumerate(program.regions) for label in region.labels}


def _run(
    program: Program, groups: list, registers: dict, words: int, watch: Watch | None = None
) -> dict:
    registers = dict(registers)
    memory = list(program.data)
    result = Result()
    labels = _path(program)
    starts = list(accumulate((len(group) for group in groups), initial=0))
    region = 0
    for _ in range(STEPS):
        target = None
        for address, group in enumerate(groups[region], starts[region]):
            if watch:
                watch(address, registers, memory)
            writes = []
            for op in group:
                target = _execute(op, registers, memory, words, writes) or target
            for dst, value in writes:
                if isinstance(dst, Output):
                    result.outputs[dst.index] = value
                else:
                    registers[dst] = value
        if program.regions[region].halt:
            if watch:
                watch(starts[-1], registers, memory)
            result.data = memory[:words]
            registers["result"] = result
            return registers
        region = region + 1 if target is None else labels[target]
    raise AssertionError("the program does not halt")


def _execute(op: Operation, registers: dict, memory: list, words: int, writes: list) -> str | None:
    a, b, c = (_read(registers, source) for source in (op.a, op.b, op.c))
    indexed = not (isinstance(op.b, Register) and op.b.bank == "zero")
    address = (b + op.imm) % words if indexed and op.imm is not None else op.imm
    if op.mnemonic == "st":
        memory[address] = a
    elif op.mnemonic == "ld":
        writes.append((op.dst, memory[address]))
    elif op.mnemonic in ("jmp", "bz", "bnz"):
        if op.mnemonic == "jmp" or (op.mnemonic == "bz") == (a % 2 == 0):
            return op.target
    elif op.dst is not None:
        writes.append((op.dst, digest(op.mnemonic, a, b, c)))
    return None


def operations_of(program: Program) -> Iterator[Operation]:
    """All operations in bundles."""
    for region in program.regions:
        for bundle in region.bundles:
            yield from (op for op in bundle.slots if op is not None)
