# SPDX-License-Identifier: Apache-2.0
"""What a source says and can hardly mean: warnings, each with a code, and two errors.

The codes are those of `WARNINGS`. A warning that is meant is switched off in place by a comment
`-Wno-<code>: reason` on its line, or by the option of the same name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from asip_asm.blocks import Step
from asip_asm.diagnostics import Reporter, counted
from asip_asm.expression import float_value
from asip_asm.ir import ZERO, Program, Register, Virtual
from asip_asm.source import Declaration, RawOperation, Source

WARNINGS = {
    "unused-input": "an input that nothing reads",
    "unused-constant": "a constant or parameter of the main file that nothing reads",
    "unused-state": "a state that nothing reads, writes or exports",
    "unused-stream": "a block of a stream that nothing reads or seeks",
    "unused-result": "a result that nothing reads",
    "data-bounds": "an address outside of the block of data memory that it names",
    "type": "a float read as an integer, or the reverse",
    "division-by-zero": "a division by the constant 0",
    "invalid-argument": "a constant argument for which the result is NaN",
}
SINE_LIMIT = 256.0  # rad


def lint(source: Source, program: Program, steps: Sequence[Step], reporter: Reporter) -> None:
    """Add warnings and errors of a resolved program without errors to the reporter."""
    words = {("K", c.index): c.bits for c in program.constants}
    types = _Types(source, steps)
    _unused_declarations(source, steps, reporter)
    _unused_results(program, steps, reporter)
    blocks = _data_blocks(source)
    for step in steps:
        _constant_operands(step, words, reporter)
        types.check(step, reporter)
        operand = step.raw.operands.get("address")
        if operand is not None and operand.text in blocks and operand.index is None:
            start, end = blocks[operand.text]
            if not start <= operand.value < end:
                reporter.warn(
                    "data-bounds",
                    operand.place,
                    f"address {operand.value:g} is outside of '{operand.text}', which has "
                    f"{counted(end - start, 'word')} from {start}",
                )


def _unused_declarations(source: Source, steps: Sequence[Step], reporter: Reporter) -> None:
    used = source.used | {name for name, _, _ in source.exports}
    used |= {name for step in steps for name in step.reads.values()}
    written = {operand.text for step in steps if (operand := step.raw.operands.get("dst"))}
    for declaration in source.names.values():
        name, kind, place = declaration.name, declaration.kind, declaration.place
        if name in used or (kind == "state" and name in written):
            continue
        in_main = place.line.file == source.main_file and not place.line.expansions
        if kind in ("input", "state", "stream"):
            reporter.warn(f"unused-{kind}", place, f"{kind} '{name}' is never read")
        elif kind == "constant" and in_main and declaration.pin is None:
            reporter.warn("unused-constant", place, f"constant '{name}' is never read")


def _unused_results(program: Program, steps: Sequence[Step], reporter: Reporter) -> None:
    used: set[object] = {export.value for export in program.exports}
    used |= {place for state in program.states for place in (state.first, state.last)}
    for step in steps:
        used |= {step.operation.a, step.operation.b, step.operation.c}
    for step in steps:
        dst = step.operation.dst
        if isinstance(dst, Virtual) and dst not in used:
            place = step.raw.operands["dst"].place
            reporter.warn(
                "unused-result",
                place,
                f"nothing reads this value of '{dst.name}'",
                "export it, or leave the operation out",
            )


def _data_blocks(source: Source) -> dict[str, tuple[int, int]]:
    """First address and end of each named block of data memory."""
    named = source.of_kind("data")
    starts = [int(d.value or 0) for d in named]
    ends = [*starts[1:], len(source.data)]
    return {d.name: (start, end) for d, start, end in zip(named, starts, ends, strict=False)}


def _constant_operands(
    step: Step, words: Mapping[tuple[str, int], int | None], reporter: Reporter
) -> None:
    """Results that constant operands alone decide, and nobody can want."""
    operation, operands = step.operation, step.raw.operands

    def value(kind: str) -> float | None:
        register = getattr(operation, kind)
        if register == ZERO:
            return 0.0
        if not isinstance(register, Register):
            return None
        bits = words.get((register.bank, register.index))
        return None if bits is None else float_value(bits)

    name, a, b, c = operation.mnemonic, value("a"), value("b"), value("c")
    if name == "fsat" and b is not None and c is not None and b > c:
        reporter.add(
            operands["b"].place,
            f"fsat saturates to {b:g}..{c:g}: the lower bound is above the upper",
            "fsat dst, a, lower, upper",
        )
    elif name == "fdiv" and b == 0.0:
        reporter.warn(
            "division-by-zero",
            operands["b"].place,
            "division by 0: the result is infinite or NaN",
        )
    elif name in ("fsin", "fcos") and a is not None and abs(a) > SINE_LIMIT:
        reporter.warn(
            "invalid-argument",
            operands["a"].place,
            f"{name} of {a:g} rad is NaN: arguments lie in -256..256 rad",
            "take whole turns out first",
        )
    elif name == "fsqrt" and a is not None and a < 0.0:
        reporter.warn(
            "invalid-argument", operands["a"].place, f"square root of {a:g}: the result is NaN"
        )


class _Types:
    """Types of symbolic values, as far as the operations that write them determine them."""

    def __init__(self, source: Source, steps: Sequence[Step]) -> None:
        self.source = source
        self.known: dict[object, set[str]] = {}
        self.writer: dict[object, RawOperation] = {}
        for step in steps:
            dst, record = step.operation.dst, step.raw.record
            if not isinstance(dst, Virtual):
                continue
            wrote = record.type_of("dst")
            found = {wrote}
            if wrote == "any":
                moved = [k for k in record.sources if record.type_of(k) == "any"]
                found = set().union(*(self.of(step, k) for k in moved)) if moved else {"any"}
            self.known.setdefault(dst, set()).update(found or {"any"})
            self.writer.setdefault(dst, step.raw)

    def of(self, step: Step, kind: str) -> set[str]:
        """Types that an operand may have; 'any' where nothing determines it."""
        declaration = self._declaration(step, kind)
        if declaration is not None:
            return {declaration.type}
        return self.known.get(getattr(step.operation, kind), {"any"})

    def _declaration(self, step: Step, kind: str) -> Declaration | None:
        operand = step.raw.operands.get(kind)
        found = self.source.names.get(operand.text) if operand is not None else None
        return found if found and found.kind in ("input", "constant", "state") else None

    def check(self, step: Step, reporter: Reporter) -> None:
        """Symbolic operands whose type is certain and not the one that the operation reads."""
        record = step.raw.record
        for kind, name in step.reads.items():
            wanted, found = record.type_of(kind), self.of(step, kind)
            if wanted == "any" or len(found) > 1 or found <= {wanted, "any"}:
                continue
            writer = self.writer.get(getattr(step.operation, kind))
            (type_name,) = found
            by = f" ({writer.record.name} writes it)" if writer else ""
            place = step.raw.read_as(kind).place
            if kind not in step.raw.operands:
                reporter.add(
                    place,
                    f"'{name}' is a float{by}, an index is an int32",
                    "convert it with f2i or f2it",
                )
            else:
                reporter.warn(
                    "type",
                    place,
                    f"'{name}' is of type {type_name}{by}, {record.name} reads type {wanted}",
                    "convert with i2f" if wanted == "float" else "convert with f2i or f2it",
                )
