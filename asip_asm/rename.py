# SPDX-License-Identifier: Apache-2.0
"""Renaming: every symbolic name becomes the values of the IR, and blocks become its regions."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

from asip_asm.blocks import Block, Step
from asip_asm.diagnostics import Reporter, SourceError
from asip_asm.flow import live_after
from asip_asm.ir import Bundle, Operation, Program, Region, Register, State, Virtual
from asip_asm.operands import Operands
from asip_asm.source import where


def rename(program: Program, blocks: list[Block], operands: Operands, reporter: Reporter) -> None:
    """Set the program's regions, and the values of its states and exports."""
    _Renamer(program, blocks, operands, reporter).rename()


@dataclass
class _Renamer:
    program: Program
    blocks: list[Block]
    operands: Operands
    reporter: Reporter

    def rename(self) -> None:
        several = len(self.blocks) > 1
        live = self._live_out() if several else [set()]
        counter: dict[str, int] = defaultdict(int)
        shared: dict[str, list[Step]] = defaultdict(list)
        current: dict[str, Virtual] = {}
        for block, live_out in zip(self.blocks, live, strict=True):
            last = {s.write: s for s in block.steps() if s.write in live_out}
            current = {}
            if not several:
                current = {state.name: state.first for state in self.program.states}
            for group in block.groups:
                for step in group:
                    for kind, name in step.reads.items():
                        setattr(step.operation, kind, current.get(name, Virtual(name, -1)))
                for step in group:
                    if step.write is None:
                        continue
                    if last.get(step.write) is step:
                        value = Virtual(step.write, -1)
                        shared[step.write].append(step)
                    else:
                        counter[step.write] += 1
                        value = Virtual(step.write, counter[step.write])
                    step.operation.dst = current[step.write] = value
            self.program.regions.append(self._region(block))
        for state in self.program.states:
            if several:
                if state.name in self.operands.written:
                    state.first = state.last = Virtual(state.name, -1)
            elif current.get(state.name, state.first) != state.first:
                state.last = current[state.name]
            self._check_pin(state, shared)
        known = self._keep_unwritten_states() if several else current
        for export in self.program.exports:
            if isinstance(export.value, Virtual):
                other = Virtual(export.name, -1 if several else 0)
                export.value = known.get(export.name, other)
        for name, steps in shared.items():
            self._check_one_kind(name, steps)

    def _keep_unwritten_states(self) -> dict[str, Virtual]:
        """States that nothing writes keep the symbol of their first value; these symbols."""
        unwritten = {
            s.name: s.first for s in self.program.states if s.name not in self.operands.written
        }
        for block in self.blocks:
            for step in block.steps():
                for kind, name in step.reads.items():
                    if name in unwritten:
                        setattr(step.operation, kind, unwritten[name])
        return unwritten

    def _kind(self, step: Step) -> str:
        return "fma" if self.operands.isa.units[step.raw.record.unit].bank == "pipe" else "aux"

    def _check_one_kind(self, name: str, steps: list[Step]) -> None:
        kinds = [self._kind(step) for step in steps]
        for step, kind in zip(steps, kinds, strict=True):
            if kind != kinds[0]:
                self.reporter.add(
                    step.raw.operands["dst"].place,
                    f"'{name}' keeps its value from one part of the program to another, but "
                    f"{step.raw.record.name} writes another bank than {steps[0].raw.record.name} "
                    f"in {where(steps[0].place)}",
                    f"insert mov: write another name and mov it to '{name}'",
                )
                return

    def _check_pin(self, state: State, shared: dict[str, list[Step]]) -> None:
        if state.pin is None or state.last is None:
            return
        steps = shared.get(state.name) or [
            step
            for block in self.blocks
            for step in block.steps()
            if step.operation.dst == state.last
        ]
        for step in steps:
            if state.pin not in self.operands.result_banks(step.raw.record.name):
                self.reporter.add(
                    step.raw.operands["dst"].place,
                    f"state '{state.name}' is pinned to bank {state.pin}, "
                    f"{step.raw.record.name} cannot write there",
                    "pin another bank, or insert mov"
                    if state.pin == "C"
                    else "pin C, or write it with a multiply-add operation",
                )

    def _region(self, block: Block) -> Region:
        region = Region(labels=block.labels, halt=block.halt, ends=block.ends)
        if not block.braces:
            region.operations = [step.operation for step in block.steps()]
            return region
        region.bundles = []
        for group in block.groups:
            try:
                region.bundles.append(Bundle(self._slots(group)))
            except SourceError as error:
                self.reporter.take(error.diagnostic)
        if region.bundles:
            region.bundles[-1].halt = block.halt
        return region

    def _slots(self, group: list[Step]) -> list[Operation | None]:
        """Slot of every operation of a bundle: named registers first, then in the order written."""
        configuration = self.operands.configuration
        slots: list[Operation | None] = [None] * len(configuration.slots)
        steps = [step for step in group if step.operation.mnemonic != "nop"]
        steps.sort(key=lambda step: not isinstance(step.operation.dst, Register))
        for step in steps:
            if step.operation.dst in [op.dst for op in slots if op is not None and op.dst]:
                continue
            unit = self.operands.isa.units[step.raw.record.unit]
            choices = [
                slot
                for slot in range(len(slots))
                if configuration.allows(slot, unit)
                and step.operation.pipe in (None, slot)
                and not (
                    isinstance(step.operation.dst, Register)
                    and configuration.result_bank(slot, unit) != step.operation.dst.bank
                )
            ]
            free = [slot for slot in choices if slots[slot] is None]
            if not free:
                taken = [f"{op.mnemonic} takes slot {i}" for i in choices if (op := slots[i])]
                kind = "multiply-add" if unit.bank == "pipe" else "auxiliary"
                raise SourceError(
                    step.place,
                    f"no slot left for {step.raw.record.name}: configuration "
                    f"'{configuration.name}' has slots {', '.join(configuration.slots)}; "
                    + ", ".join(taken),
                    f"put this {kind} operation into another bundle",
                )
            slots[free[0]] = step.operation
        return slots

    def _live_out(self) -> list[set[str]]:
        """Names whose value a later block, the host or the next run reads, by block."""
        blocks = self.blocks
        kept = {export.name for export in self.program.exports if isinstance(export.value, Virtual)}
        kept |= {state.name for state in self.program.states}
        exposed: list[set[str]] = []
        written: list[set[str]] = []
        for block in blocks:
            reads: set[str] = set()
            writes: set[str] = set()
            for group in block.groups:
                reads.update(n for s in group for n in s.reads.values() if n not in writes)
                writes.update(s.write for s in group if s.write)
            exposed.append(reads)
            written.append(writes)
        at_end = [kept if block.halt else set() for block in blocks]
        return live_after([block.follow for block in blocks], exposed, written, at_end)
