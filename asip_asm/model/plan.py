# SPDX-License-Identifier: Apache-2.0
"""Programs of loops and streams: a plan, its text, and the graph of what it computes.

A plan holds operations and loops in the order of their meaning. Constants of matrices are `Words`:
arrays indexed by the counters of the loops around them. `Plan.finish` chooses the pipe of each
operation that takes such a word and the order within each straight part. Then it runs the plan
once, symbolically: that lays out both streams in the order of use and gives the graph of core
operations, one node for each operation of the run, which interpreter, bounds and proofs take.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from asip_asm.assembly_text import quoted
from asip_asm.dependence import build_graph, edges_around
from asip_asm.ir import ZERO, Operation, Virtual
from asip_asm.machine import Machine, load_machine
from asip_asm.model.emit import literal
from asip_asm.model.graph import Graph
from asip_asm.model.plan_items import PIPES, Item, Loop, Op, Operand, Rewind, Words
from asip_asm.model.plan_run import VECTOR, Run
from asip_asm.model.read import ModelError
from asip_asm.search import Problem, build_problem, search

EFFORT = 40
"""Schedules tried for the order of a part."""
NEGLIGIBLE = 2.0**-40
"""An entry of a matrix below this share of the largest one of its row is a zero."""
WAIT = 8
"""Cycles for an operation of the run, of which the watchdog never sees more."""
COLUMNS = 8
"""Words of a stream in a line of text."""


class Plan:
    """A program under construction. inputs: names in bank K; outputs: name and safe value; spaces:
    words by block of data memory.
    """

    def __init__(
        self, title: str, inputs: Sequence[str], outputs: Mapping[str, float], machine: Machine
    ) -> None:
        self.title, self.inputs, self.outputs = title, list(inputs), dict(outputs)
        self.machine = machine
        self.spaces: dict[str, int] = {}
        self.marks: dict[str, tuple[str, Sequence[Operand]]] = {}
        self.items: list[Item] = []
        self._open = [self.items]
        self._unsettled: list[tuple[str, tuple[Operand, ...], str]] = []
        self._count = 0
        self.graph = Graph()
        self.streams: dict[str, list[float]] = {pipe: [] for pipe in PIPES}
        self.step_words = 1
        self.reorder = False  # also parts whose pipes are chosen
        self.steps = 0

    # ------------------------------------------------------------------ making
    def op(self, name: str, *args: Operand, to: str = "") -> str:
        """Append an operation; the name of its result."""
        if not to:
            self._count += 1
            to = f"t{self._count}"
        self._open[-1].append(Op(name, to, args))
        return to

    def vector(self, name: str, *args: Operand, pipe: str, to: str = "", lane: int = 0) -> str:
        """Append an operation on vectors of a pipe, or `vout`; the name of its result. All words of
        the streams are vectors then.
        """
        self.step_words = 1 + self.machine.build.lanes
        to = self.op(name, *args, to=to)
        made = self._open[-1][-1]
        assert isinstance(made, Op)
        made.pipe, made.lane = pipe, lane
        return to

    def load(self, block: str, offset: int, index: str = "", to: str = "") -> str:
        self._count += 1
        to = to or f"{block}{self._count}"
        self._open[-1].append(Op("ld", to, (index,) if index else (), block, offset))
        return to

    def store(self, value: str, block: str, offset: int, index: str = "") -> None:
        args = (value, index) if index else (value,)
        self._open[-1].append(Op("st", "", args, block, offset))

    def mark(self, result: str, function: str, arguments: Sequence[Operand]) -> None:
        """State that `result` approximates a function, as `asip_asm.model.functions` has it."""
        self.marks[result] = (function, arguments)

    def rewind(self) -> None:
        self._open[-1].append(Rewind())

    @contextlib.contextmanager
    def loop(self, name: str, count: int) -> Iterator[None]:
        made = Loop(name, count, [])
        self._open[-1].append(made)
        self._open.append(made.body)
        yield
        self._open.pop()

    def product(
        self,
        matrix: Words,
        x: Sequence[str],
        start: Sequence[str] = (),
        into: Sequence[str] = (),
        parts: int = 1,
    ) -> list[str]:
        """start + matrix * x, a name of `start` empty where a sum begins at zero. The last two axes
        of the matrix are rows and columns; what is zero in every iteration is left out. Each sum is
        made of `parts` sums, to be ready earlier. into: names that take the results, of x too:
        they are written by `settle`, after all that reads them.
        """
        values = matrix.values
        size = np.abs(values).reshape(-1, *values.shape[-2:]).max(axis=0)
        filled = size > NEGLIGIBLE * size.max(axis=1, keepdims=True)
        results = []
        for i, row in enumerate(filled):
            to = into[i] if into else ""
            terms = sorted(np.flatnonzero(row).tolist(), key=lambda j: (to != "" and x[j] == to, j))
            last = terms.pop() if terms and to and x[terms[-1]] == to and parts == 1 else None
            sums = [start[i]] if start and start[i] else []
            made: list[str] = []
            for part in range(parts):
                total = sums.pop() if sums else ""
                for j in terms[part::parts]:
                    word = Words(values[..., i, j], matrix.axes)
                    total = self.op(
                        *(("fmadd", word, x[j], total) if total else ("fmul", word, x[j]))
                    )
                made += [total] if total else []
            while len(made) > 1:
                made = [*made[2:], self.op("fadd", made[0], made[1])]
            rest = made[0] if made else 0.0
            if last is not None:
                word = Words(values[..., i, last], matrix.axes)
                self._unsettled.append(("fmadd" if made else "fmul", (word, to, *made), to))
            elif to:
                self._unsettled.append(("fsub", (rest, 0.0), to))
            elif not made:
                made = [self.op("fsub", 0.0, 0.0)]
            results.append(to or made[0])
        return results

    def settle(self) -> None:
        """Write the results of products that go to names."""
        for name, args, to in self._unsettled:
            self.op(name, *args, to=to)
        self._unsettled.clear()

    # ------------------------------------------------------------------ finishing
    def finish(self) -> None:
        """Order, pipes, streams and graph. Raises ModelError for what the core has no room for."""
        shared = self._shared()
        pins: dict[str, str] = {}
        words = dict.fromkeys(PIPES, 0)
        self.items = self._ordered(self.items, shared, pins, words, 1)
        Run(self).run()
        room = self.machine.build.stream_words
        for pipe, found in self.streams.items():
            if len(found) > room * self.step_words:
                raise ModelError(
                    f"{self.title}: {len(found)} constants in the stream of pipe {pipe}, "
                    f"configuration {self.machine.configuration} has {room}; take fewer or smaller "
                    "matrices, or a configuration with longer streams"
                )
        used, data = sum(self.spaces.values()), self.machine.data_words
        if used > data:
            raise ModelError(f"{self.title}: {used} words of data memory, the core has {data}")

    def _parts(self, items: Sequence[Item]) -> Iterator[list[Op]]:
        part: list[Op] = []
        for item in items:
            if isinstance(item, Op):
                part.append(item)
            elif isinstance(item, Loop):
                yield part
                part = []
                yield from self._parts(item.body)
        yield part

    def _shared(self) -> set[str]:
        """Names whose value passes from part to part, or around a loop."""
        seen: set[str] = set()
        shared: set[str] = set()
        for part in self._parts(self.items):
            written: set[str] = set()
            here: set[str] = set()
            for op in part:
                shared.update(name for name in op.reads() if name not in written)
                here.update(op.reads(), [op.dst])
                written.add(op.dst)
            shared |= here & seen
            seen |= here
        return shared - {"", *self.inputs}

    def _ordered(
        self, items: Sequence[Item], shared: set[str], pins: dict[str, str],
        words: dict[str, int], times: int, looped: bool = False,
    ) -> list[Item]:  # fmt: skip
        result: list[Item] = []
        part: list[Op] = []
        for item in [*items, None]:
            if isinstance(item, Op):
                part.append(item)
                continue
            whole = looped and len(part) == len(items)
            result += self._order(part, shared, pins, words, times, whole)
            part = []
            if isinstance(item, Loop):
                inner = times * item.count
                body = self._ordered(item.body, shared, pins, words, inner, True)
                result.append(Loop(item.name, item.count, body))
            elif item is not None:
                result.append(item)
        return result

    def _order(
        self, part: list[Op], shared: set[str], pins: dict[str, str], words: dict[str, int],
        times: int, whole: bool,
    ) -> list[Op]:  # fmt: skip
        """The part as a trial schedule issues it, each word of a stream taken in the pipe where the
        schedule has its operation. whole: the part is the body of a loop.
        """
        if not any(op.words for op in part):
            return part
        if not self.reorder and all(op.words is None or op.pipe for op in part):
            return part
        machine = self.machine
        fma = [self._is_fma(op) for op in part]
        for op, pipe in zip(part, fma, strict=True):
            if pipe and op.dst in shared and op.dst not in pins:
                held = list(pins.values())
                pins[op.dst] = op.pipe or min(PIPES, key=held.count)
        fixed = [
            op.pipe or pins.get(op.dst) if pipe else None
            for op, pipe in zip(part, fma, strict=True)
        ]
        operations = [_operation(op) for op in part]
        graph = build_graph(operations, machine)
        around = edges_around(operations, machine) if whole else None
        slots = [None if pin is None else PIPES.index(pin) for pin in fixed]
        problem: Problem = build_problem(graph, machine, slots, around=around)
        issued = search(problem, EFFORT)
        taken = {(issued[i], pin) for i, pin in enumerate(fixed) if pin}
        order = sorted(range(len(part)), key=lambda i: (issued[i], i))
        for i in order:
            op, pin = part[i], fixed[i]
            if fma[i] and pin is None:
                free = [pipe for pipe in PIPES if (issued[i], pipe) not in taken]
                pin = min(free, key=lambda pipe: words[pipe])
                taken.add((issued[i], pin))
            if op.words is not None and pin is not None:
                op.pipe = pin
                words[pin] += times
        return [part[i] for i in order]

    # ------------------------------------------------------------------ account
    def account(self, cycles: int) -> list[str]:
        """Where the cycles go: the slots used, and the work of each straight part, for people."""
        parts = list(self._work(self.items, (), 1))
        used = [sum(times * counts[k] for _, times, counts in parts) for k in range(3)]
        lines = [
            f"multiply-add slots used: {50 * used[0] / cycles:.0f} %, "
            f"{self.share(cycles):.0f} % with products of matrices; "
            f"auxiliary slot: {100 * used[2] / cycles:.0f} %"
        ]
        for path, times, (fma, words, aux) in parts:
            least = max(-(-fma // 2), aux)
            lines.append(
                f"  {'/'.join(path) or 'once':<18} {times:5} x {fma:4} multiply-adds, {words:4} of "
                f"them products, {aux:4} others: {times * least} cycles or more"
            )
        return lines

    def share(self, cycles: int) -> float:
        """Multiply-add slots that products with matrices take, in percent."""
        return 50 * sum(times * c[1] for _, times, c in self._work(self.items, (), 1)) / cycles

    def bundles(self) -> int:
        """Bundles that the operations take at least."""
        counts = (found for _, _, found in self._work(self.items, (), 1))
        return sum(max(-(-fma // 2), aux) for fma, _, aux in counts)

    def _work(
        self, items: Sequence[Item], path: tuple[str, ...], times: int
    ) -> Iterator[tuple[tuple[str, ...], int, tuple[int, int, int]]]:
        part: list[Op] = []
        for item in [*items, None]:
            if isinstance(item, Op):
                part.append(item)
            elif not isinstance(item, Rewind):
                if part:
                    fma = sum(self._is_fma(op) for op in part)
                    words = sum(op.words is not None for op in part)
                    yield path, times, (fma, words, len(part) - fma)
                part = []
                if item is not None:
                    yield from self._work(item.body, (*path, item.name), times * item.count)

    def _is_fma(self, op: Op) -> bool:
        return self.machine.unit(Operation(op.name)).bank == "pipe"

    # ------------------------------------------------------------------ text
    def text(self) -> str:
        """Linear assembly of a finished plan."""
        rows = [f".program {quoted(self.title)}", f".config {self.machine.configuration}"]
        rows += [f".watchdog {WAIT * self.steps}", ""]
        rows += [f".input {name}" for name in self.inputs]
        rows += [f".output {name}, safe = {literal(safe)}" for name, safe in self.outputs.items()]
        rows += [f".space {name}, {count}" for name, count in self.spaces.items()]
        for pipe, found in self.streams.items():
            for k in range(0, len(found), COLUMNS):
                name = f"w{pipe}, pin {pipe} = " if k == 0 else ""
                kind = ".stream" if self.step_words == 1 else ".vectors"
                values = ", ".join(literal(value) for value in found[k : k + COLUMNS])
                rows.append(f"{kind} {name}{values}")
        rows.append("")
        rows += self._lines(self.items, 1)
        return "\n".join([*rows, "        halt", ""])

    def _lines(self, items: Sequence[Item], depth: int) -> Iterator[str]:
        indent = " " * (4 + 4 * depth)
        for item in items:
            if isinstance(item, Loop):
                yield f"{indent}loop    {item.count}" + f"    ; {item.name}"
                yield from self._lines(item.body, depth + 1)
                yield f"{indent}endloop"
            elif isinstance(item, Rewind):
                for pipe in PIPES:
                    if self.streams[pipe]:
                        yield f"{indent}seek    w{pipe}+{item.places[pipe]}"
            else:
                yield f"{indent}{item.name:<8}{', '.join(_operands(item))}"


def _operands(op: Op) -> Iterator[str]:
    if op.dst:
        yield op.dst
    if op.block:
        index = op.args[1:] if op.name == "st" else op.args
        if op.name == "st":
            yield str(op.args[0])
        yield f"{op.block}+{op.offset}" + (f"[{index[0]}]" if index else "")
        return
    for arg in op.args:
        if isinstance(arg, Words):
            yield f"w{op.pipe}+"
        elif op.name in VECTOR and arg == 0.0:
            yield "zero"
        else:
            text = literal(arg) if isinstance(arg, float) else str(arg)
            yield f"({text})" if text.startswith("-") else text
    if op.name == "vout":
        yield str(op.lane)


def _operation(op: Op) -> Operation:
    """For the scheduler, without the order of the streams."""
    sources = [Virtual(arg, -1) if isinstance(arg, str) else ZERO for arg in op.args]
    made = Operation(op.name, Virtual(op.dst, -1) if op.dst else None)
    if op.block:
        made.imm = op.offset
        if op.name == "ld":
            sources = [ZERO, *sources]
    for name, source in zip("abc", sources, strict=False):
        setattr(made, name, source)
    return made


def stream_machine(configuration: str) -> Machine:
    """The machine of a configuration that has streams. Raises ModelError for others."""
    machine = load_machine(configuration)
    if not machine.build.stream_words:
        raise ModelError(f"configuration {configuration} has no streams; take --config stream")
    return machine
