# SPDX-License-Identifier: Apache-2.0
"""Checks of the data flow: names read before they are written, exports, outputs written once."""

from __future__ import annotations

from dataclasses import dataclass

from asip_asm.blocks import Block, Step
from asip_asm.diagnostics import Place, Reporter, SourceError, closest
from asip_asm.flow import certain_before, possible_before
from asip_asm.ir import Export, Output, Program, Register, Virtual
from asip_asm.loops import Loop
from asip_asm.operands import Operands
from asip_asm.source import NOUNS, Source, physical_register, where


def check_flow(
    source: Source,
    program: Program,
    blocks: list[Block],
    loops: list[Loop],
    operands: Operands,
    reporter: Reporter,
) -> None:
    """Report what is wrong on any path; adds the exports to the program."""
    checks = _Checks(source, program, blocks, loops, operands, reporter)
    checks.check_reads()
    checks.check_outputs()


@dataclass
class _Checks:
    source: Source
    program: Program
    blocks: list[Block]
    loops: list[Loop]
    operands: Operands
    reporter: Reporter

    def __post_init__(self) -> None:
        self.written = self.operands.written
        self.follow = [block.follow for block in self.blocks]

    def check_reads(self) -> None:
        """Every read of a name must see a write on every path from the start."""
        states = {state.name for state in self.program.states} | self.source.doubtful
        everything = set(self.written) | states
        blocks = self.blocks
        writes = [{s.write for s in b.steps() if s.write} for b in blocks]
        before = certain_before(self.follow, writes, states, everything)
        for block, known in zip(blocks, before, strict=True):
            seen = set(known)
            for group in block.groups:
                for step in group:
                    for kind, name in step.reads.items():
                        if name not in seen:
                            self._report_read(step, kind, name)
                            seen.add(name)
                seen.update(step.write for step in group if step.write)
        ends = [
            known | written
            for block, known, written in zip(blocks, before, writes, strict=True)
            if block.halt
        ]
        self._resolve_exports(set.intersection(*ends) if ends else everything)

    def _report_read(self, step: Step, kind: str, name: str) -> None:
        operand = step.raw.read_as(kind)
        first = self.written.get(name)
        if first is not None:
            problem = "is read before it is written"
            if len(self.blocks) > 1:
                problem = "is not written on every path before it is read"
            self.reporter.add(
                operand.place,
                f"'{name}' {problem}",
                f"its first write is in {where(first)}",
            )
        elif name in self.source.names:
            self.reporter.add(operand.place, f"'{name}' is read but never written")
        else:
            known = [*self.source.names, *self.written]
            self.reporter.add(
                operand.place,
                f"unknown name '{name}'",
                closest(name, known) or "it is neither declared nor written",
            )

    def _resolve_exports(self, at_end: set[str]) -> None:
        for name, place, register in self.source.exports:
            try:
                self._export(name, place, register, at_end)
            except SourceError as error:
                self.reporter.take(error.diagnostic)

    def _export(self, name: str, place: Place, register: str | None, at_end: set[str]) -> None:
        declaration = self.source.names.get(name)
        value: Register | None
        if register is not None:
            value = physical_register(register)
            if value is None or value.bank == "zero":
                raise SourceError(
                    place, f"'{register}' is no physical register", "a0.., b0.., c0.. or k0.."
                )
        else:
            value = physical_register(name)
        if value is None and declaration is not None:
            if declaration.kind == "input":
                value = Register("K", int(declaration.value or 0))
            elif declaration.kind == "state" and isinstance(declaration.pin, Register):
                value = declaration.pin
            elif declaration.kind not in ("state", "register"):
                raise SourceError(
                    place,
                    f"'{name}' is {NOUNS[declaration.kind]} and cannot be exported",
                    "registers, states and inputs can",
                )
        if value is not None:
            self.operands.check_exists(value, place)
            self.program.exports.append(Export(name, value))
            return
        if name in self.source.doubtful:
            return
        if name not in self.written and (declaration is None or declaration.kind != "state"):
            raise SourceError(
                place,
                f"'{name}' is exported but never written",
                closest(name, [*self.written, *self.source.names]),
            )
        if name not in at_end:
            raise SourceError(
                place,
                f"'{name}' is exported but not written on every path",
                f"its first write is in {where(self.written[name])}",
            )
        self.program.exports.append(Export(name, Virtual(name, 0)))

    def check_outputs(self) -> None:
        """Every output must be written exactly once on every path."""
        blocks = self.blocks
        everything = set(range(len(self.program.outputs)))
        writes = [
            [(s.operation.dst.index, s) for s in b.steps() if isinstance(s.operation.dst, Output)]
            for b in blocks
        ]
        written = [{index for index, _ in pairs} for pairs in writes]
        names = {o.index: o.name for o in self.program.outputs}
        possible = possible_before(self.follow, written)
        for i, (before, pairs) in enumerate(zip(possible, writes, strict=True)):
            seen = set(before)
            repeated = any(loop.first <= i <= loop.last for loop in self.loops)
            for index, step in pairs:
                if index in seen:
                    self.reporter.add(
                        step.raw.operands["dst"].place,
                        f"output '{names[index]}' is written "
                        + ("in every round of a loop" if repeated else "twice"),
                        "write a register in the loop, and the output once after it"
                        if repeated
                        else "select the value first, then write the output once",
                    )
                seen.add(index)
        certain = certain_before(self.follow, written, set(), everything)
        missing: set[int] = set()
        for block, before, here in zip(blocks, certain, written, strict=True):
            if block.halt:
                missing |= everything - before - here
        ever = set().union(*written)
        for declaration in self.source.of_kind("output"):
            index = int(declaration.value or 0)
            if index in missing and declaration.name not in self.source.doubtful:
                how = " on every path" if index in ever else ""
                self.reporter.add(
                    declaration.place,
                    f"output '{declaration.name}' is not written{how}",
                    f"write it once: mov {declaration.name}, value",
                )
