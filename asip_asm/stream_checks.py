# SPDX-License-Identifier: Apache-2.0
"""Checks of streams: at each read the next word is known, and it is one of the block named."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from asip_asm.blocks import Block, Step
from asip_asm.dependence import stream_place
from asip_asm.diagnostics import Reporter
from asip_asm.ir import StreamBlock
from asip_asm.isa import STREAM_BITS, STREAM_PINS
from asip_asm.loops import Loop
from asip_asm.source import Operand, Source, stream_words

Places = tuple[int | None, ...]
"""Address of the next word of each pipe's stream; None before any seek of it."""

UNKNOWN = -1
"""Address of a stream that is not the same on every path."""


def check_streams(
    source: Source, blocks: Sequence[Block], loops: Sequence[Loop], reporter: Reporter
) -> None:
    """Report reads of a stream that runs out, or whose next word is not certain.

    A loop counts as one block: nothing enters or leaves it elsewhere, and its rounds are known.
    """
    if not any(stream_place(step.operation) is not None for b in blocks for step in b.steps()):
        return
    checks = _Checks(source.streams, blocks, loops, reporter)
    nowhere: Places = (None,) * len(STREAM_PINS)
    before: list[Places | None] = [nowhere, *(None for _ in blocks[1:])]
    pending = [0]
    while pending:
        i = pending.pop()
        last, after = checks.through(i, before[i] or nowhere)
        for j in blocks[last].follow:
            if j <= last and any(loop.first == j and loop.last == last for loop in loops):
                continue
            joined = _joined(before[j], after)
            if joined != before[j]:
                before[j] = joined
                pending.append(j)
    for i, places in enumerate(before):
        if places is not None:
            checks.through(i, places, report=True)


def _joined(one: Places | None, other: Places) -> Places:
    """What is certain after paths that come together."""
    if one is None:
        return other
    return tuple(a if a == b else UNKNOWN for a, b in zip(one, other, strict=True))


@dataclass
class _Checks:
    streams: list[StreamBlock]
    blocks: Sequence[Block]
    loops: Sequence[Loop]
    reporter: Reporter
    reported: set[Step] = field(default_factory=set)

    def through(
        self, i: int, before: Places, report: bool = False, inside: Sequence[Loop] = ()
    ) -> tuple[int, Places]:
        """The last block and the places after block i, or after the loop that begins with it."""
        loop = max(
            (each for each in self.loops if each.first == i and each not in inside),
            key=lambda each: each.last,
            default=None,
        )
        if loop is None:
            return i, self.after(self.blocks[i], before, report)
        # Words are taken from blocks, which have no gaps: the first and the last round are enough.
        places = self._round(loop, before, report, inside)
        if loop.rounds > 1:
            # After a seek all rounds begin at the same word, without one each begins as far on.
            again = self._round(loop, places, False, inside)
            places = tuple(
                place
                if place is None or then is None
                else place + (loop.rounds - 2) * (then - place)
                for place, then in zip(places, again, strict=True)
            )
            places = self._round(loop, places, report, inside)
        return loop.last, places

    def _round(self, loop: Loop, before: Places, report: bool, inside: Sequence[Loop]) -> Places:
        i, places = loop.first, before
        while i <= loop.last:
            last, places = self.through(i, places, report, (*inside, loop))
            i = last + 1
        return places

    def after(self, block: Block, before: Places, report: bool = False) -> Places:
        """Places after a block that begins with these."""
        places = list(before)
        silent: set[int] = set()
        for group in block.groups:
            reads = {pipe: step for step in group if (pipe := step.operation.stream) is not None}
            for pipe, step in reads.items():
                place = places[pipe]
                if report and pipe not in silent and (found := self._problem(step, pipe, place)):
                    if step not in self.reported:
                        self.reporter.add(_operand(step).place, *found)
                    self.reported.add(step)
                    silent.add(pipe)  # One report is enough until the next seek.
                places[pipe] = place + 1 if place is not None and place >= 0 else place
            for step in group:
                if step.operation.mnemonic == "seek":
                    pipe, address = divmod(step.operation.imm or 0, 1 << STREAM_BITS)
                    places[pipe] = address
                    silent.discard(pipe)
        return tuple(places)

    def _problem(self, step: Step, pipe: int, place: int | None) -> tuple[str, str] | None:
        """What is wrong with a read at this place, and the cure."""
        name, pin = _operand(step).text, STREAM_PINS[pipe]
        cure = f"seek {name} before it"
        if place is None:
            return f"the stream of pipe {pin} is at no place when '{name}+' takes a word", cure
        if place == UNKNOWN:
            return f"which word '{name}+' takes is not the same on every path", cure
        block = next((b for b in self.streams if b.name == name), None)
        first = block.address if block else 0
        words = len(block.words) if block else stream_words(self.streams, pin)
        if first <= place < first + words:
            return None
        if place == first + words:
            return f"'{name}' has no word left of its {words}", f"{cure}, or add words"
        owner = next(
            (
                b.name
                for b in self.streams
                if b.pin == pin and b.address <= place < b.address + len(b.words)
            ),
            None,
        )
        at = f"is at a word of '{owner}'" if owner else "has run out"
        return f"the stream of pipe {pin} {at} when '{name}+' takes a word", cure


def _operand(step: Step) -> Operand:
    """Operand of a step that takes a word of a stream."""
    return next(o for o in step.raw.operands.values() if o.kind == "stream")
