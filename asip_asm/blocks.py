# SPDX-License-Identifier: Apache-2.0
"""Blocks of a program: code that runs from its first operation to its last, and what follows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from asip_asm.diagnostics import Place, Reporter
from asip_asm.flow import reachable
from asip_asm.ir import Operation
from asip_asm.loops import Loop, immediate, level_and_rounds
from asip_asm.machine import BRANCHES
from asip_asm.source import RawOperation, Source, Statement, where


@dataclass(eq=False)
class Step:
    """Operation with the symbolic names that it still holds: reads by field, and its write."""

    operation: Operation
    raw: RawOperation
    reads: dict[str, str] = field(default_factory=dict)
    write: str | None = None

    @property
    def place(self) -> Place:
        return self.raw.place


@dataclass(eq=False)
class Block:
    """Region in the making. `groups` are the operations that read at the same time: bundles, or one
    each; `follow` the blocks that may run next. `ends` counts the loops whose bodies end with it.
    """

    labels: list[str] = field(default_factory=list)
    groups: list[list[Step]] = field(default_factory=list)
    braces: bool = False
    halt: bool = False
    ends: int = 0
    closed: bool = False
    place: Place | None = None
    follow: list[int] = field(default_factory=list)

    def steps(self) -> Iterator[Step]:
        """Its operations in the order written."""
        for group in self.groups:
            yield from group

    def jumps(self) -> bool:
        """Whether it never goes on to the next block."""
        return any(step.operation.mnemonic == "jmp" for step in self.steps())


def build_blocks(
    source: Source, resolve_step: Callable[[RawOperation], Step], levels: int, reporter: Reporter
) -> tuple[list[Block], list[Loop]]:
    """Connected blocks of the source, and its loops by blocks, as they end; `levels` may be inside
    each other. Code that is never reached and a missing halt are errors.
    """
    builder = _Builder(source, resolve_step, levels, reporter)
    return builder.run(), builder.loops


@dataclass
class _Builder:
    source: Source
    resolve_step: Callable[[RawOperation], Step]
    levels: int
    reporter: Reporter
    blocks: list[Block] = field(default_factory=list)
    open_labels: list[str] = field(default_factory=list)
    loops: list[Loop] = field(default_factory=list)

    def run(self) -> list[Block]:
        self._build()
        self._check_flow()
        self._connect()
        return self.blocks

    def _build(self) -> None:
        labels: list[str] = []
        current: Block | None = None
        last: Place | None = None
        opened: list[tuple[Step, int]] = []  # loops, and the first blocks of their bodies

        def block(statement: Statement, braces: bool) -> Block:
            nonlocal current, labels
            if current is None or current.closed or labels or current.braces != braces:
                current = Block(labels, braces=braces, place=statement.place)
                labels = []
                self.blocks.append(current)
            return current

        for statement in self.source.statements:
            last = statement.place
            if opened and (what := self._leaves_a_loop(statement)):
                self.reporter.add(
                    statement.place,
                    f"{what} inside the loop of {where(opened[-1][0].place)}",
                    "a loop has a fixed number of rounds: choose values with sel, fmin or fsat",
                )
            if statement.kind == "label":
                labels.append(statement.label)
            elif statement.kind == "endloop":
                if not opened:
                    if not self.source.incomplete:
                        self.reporter.add(statement.place, "endloop without a loop", "remove it")
                    continue
                step, first = opened.pop()
                if first == len(self.blocks) or current is None:
                    self.reporter.add(step.place, "the loop has no operation", "remove it")
                    continue
                current.closed = True
                current.ends += 1
                _, rounds = level_and_rounds(step.operation)
                step.operation.imm = immediate(len(opened), rounds)
                self.loops.append(Loop(len(opened), rounds, first, len(self.blocks) - 1))
            elif statement.kind == "halt":
                block(statement, False)
                assert current is not None
                current.halt = current.closed = True
            else:
                steps = [self.resolve_step(raw) for raw in statement.operations]
                target = block(statement, statement.kind == "bundle")
                target.groups.append(steps)
                if statement.kind == "bundle":
                    self._check_bundle(steps, statement)
                if any(step.operation.mnemonic in BRANCHES for step in steps):
                    target.closed = True
                if statement.halt:
                    target.halt = target.closed = True
                for step in steps:
                    if step.operation.mnemonic == "loop" and not statement.halt:
                        self._check_depth(step, len(opened))
                        opened.append((step, len(self.blocks)))
                        target.closed = True
        for step, _ in opened if not self.source.incomplete else ():
            self.reporter.add(step.place, "loop without endloop", "add endloop after its body")
        self.open_labels = labels
        if labels:
            self.reporter.add(
                last, f"label '{labels[-1]}' is before no operation", "add halt after it"
            )
        if not self.blocks and not self.source.incomplete:
            self.reporter.add(self.source.last_place, "the program has no operation", "add halt")

    def _leaves_a_loop(self, statement: Statement) -> str:
        """What of a statement would enter or leave a loop elsewhere; '' for nothing."""
        if statement.kind == "label":
            return f"label '{statement.label}'"
        if statement.kind == "halt" or statement.halt:
            return "halt"
        names = (raw.record.name for raw in statement.operations)
        return next((name for name in names if name in BRANCHES), "")

    def _check_depth(self, step: Step, depth: int) -> None:
        if depth == self.levels > 0:
            self.reporter.add(
                step.place,
                f"a loop inside {depth} others",
                f"the core has {depth} levels of loops: write out the innermost body",
            )

    def _check_bundle(self, steps: list[Step], statement: Statement) -> None:
        destinations: dict[object, Step] = {}
        for step in steps:
            destination = step.operation.dst or step.write
            if destination is not None and destination in destinations:
                operand = step.raw.operands["dst"]
                self.reporter.add(
                    operand.place, f"two operations of one bundle write '{operand.text}'"
                )
            destinations[destination] = step
            if statement.halt and step.operation.mnemonic in (*BRANCHES, "loop"):
                self.reporter.add(
                    step.place, f"{step.operation.mnemonic} in a bundle that ends the run"
                )

    def _check_flow(self) -> None:
        if not self.blocks or self.open_labels or self.source.incomplete:
            return
        if not self.blocks[-1].halt and not self.blocks[-1].jumps():
            self.reporter.add(
                self.source.last_place or self.blocks[-1].place,
                "the program ends without halt",
                "add halt after the last operation",
            )

    def _connect(self) -> None:
        at = {label: i for i, block in enumerate(self.blocks) for label in block.labels}
        for i, block in enumerate(self.blocks):
            if not block.halt and not block.jumps() and i + 1 < len(self.blocks):
                block.follow.append(i + 1)
            block.follow += [loop.first for loop in self.loops if loop.last == i]
            for step in block.steps():
                target = step.operation.target
                if target in at:
                    block.follow.append(at[target])
        reached = reachable([0], lambda i: self.blocks[i].follow) if self.blocks else set()
        for i, block in enumerate(self.blocks):
            if i not in reached and not self.source.incomplete:
                self.reporter.add(
                    block.place,
                    "this is never reached",
                    "the run ends or jumps away before it, and no branch leads to it",
                )
