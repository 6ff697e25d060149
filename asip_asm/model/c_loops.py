# SPDX-License-Identifier: Apache-2.0
"""C of a program of loops and streams: its operations in their order, loops as loops, the words of
the streams as tables.

A vector is an array of its lanes. Data memory that a tick reads before it is written is an array of
the states; other blocks are local. Names of values are those of the plan with a prefix, so that no
signal's name can meet them.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from asip_asm.model.c_helpers import FORMS
from asip_asm.model.emit import INT_OPERANDS, literal
from asip_asm.model.graph import INT_KINDS, binary32
from asip_asm.model.plan import Plan
from asip_asm.model.plan_items import PIPES, Item, Loop, Op, Operand, Rewind, Vectors, Words
from asip_asm.model.plan_run import VECTOR

LANE = {
    "vfmul": "{0} * {1}",
    "vfmadd": "fmadd_({0}, {1}, {2})",
    "vmadd": "fmadd_({0}, {1}, {2})",
    "vscale": "fmadd_({0}, power_({1}), {2})",
    "vbelow": "fsat_({0}, -32.0f, 0.0f) * {1}",
    "vabove": "fmadd_(above_({0}), {1}, {2})",
}
"""What a lane computes, in C."""
HELPERS_OF = {name: re.findall(r"(\w+)_\(", form) for name, form in LANE.items()}
CHOOSE = frozenset({"sel", "selge", "selgt", "mov"})
"""Operations whose result is of the type of their last operand."""
COLUMNS = 8
"""Words of a table in a line."""


def kept_blocks(plan: Plan) -> dict[str, int]:
    """Size [words] of each block of data memory whose content lasts from tick to tick."""
    kept = {name.rpartition("_")[0] for name in plan.graph.next_states}
    return {block: words for block, words in plan.spaces.items() if block in kept}


class LoopBody:
    """Text of a plan in C. sources: expression of each input. `used`: helpers that it calls."""

    def __init__(self, plan: Plan, sources: dict[str, str]) -> None:
        self.plan, self.sources = plan, sources
        self.used: set[str] = set()
        self.width = plan.step_words
        self.lanes = 1 + plan.machine.build.lanes
        self.kept = kept_blocks(plan)
        self.loops = 0
        self.vectors: set[str] = set()
        self.integers: set[str] = set()
        ops = list(_operations(plan.items))
        self.read = _read(ops, plan.outputs)
        self.touched = {op.block for op, _ in ops if op.name == "st" or op.dst in self.read}
        for op, _ in ops:
            if op.name in VECTOR - {"vout"}:
                self.vectors.add(op.dst)
            elif op.name in INT_KINDS or (op.name in CHOOSE and self._is_int(op.args[-1])):
                self.integers.add(op.dst)
        writes = Counter(op.dst for op, _ in ops)
        seen: dict[str, int] = {}
        shared = {name for name, count in writes.items() if count > 1} | set(plan.outputs)
        for op, place in ops:
            shared.update(name for name in op.reads() if seen.get(name, place) != place)
            seen.setdefault(op.dst, place)
        self.shared = shared & set(writes) & self.read
        self.body = list(self._items(plan.items, 1))

    def output(self, name: str) -> str:
        """Expression of an output."""
        return self._read(name, False)

    def tables(self) -> list[str]:
        """The words of the streams."""
        lines = []
        for pipe in PIPES:
            words = self.plan.streams[pipe]
            if words:
                texts = [_number(word) for word in words]
                lines.append(f"static const float stream_{pipe}[{len(words)}] = {{")
                for k in range(0, len(texts), COLUMNS):
                    lines.append(f"    {', '.join(texts[k : k + COLUMNS])},")
                lines += ["};", ""]
        return lines

    def declarations(self) -> list[str]:
        """Values that pass from part to part, places in the streams, local blocks."""
        lines = [
            f"  float {block}[{words}] = {{0}};"
            for block, words in self._local()
        ]  # fmt: skip
        lines += [f"  int32_t at_{pipe} = 0;" for pipe in PIPES if self.plan.streams[pipe]]
        for name in sorted(self.shared):
            if name in self.vectors:
                lines.append(f"  float v_{name}[{self.lanes}] = {{0}};")
            else:
                lines.append(f"  {self._type(name)} v_{name} = 0;")
        return lines

    def _local(self) -> Iterator[tuple[str, int]]:
        for block, words in self.plan.spaces.items():
            if block not in self.kept and block in self.touched:
                yield f"local_{block}", words

    # ------------------------------------------------------------------ operations
    def _items(self, items: Sequence[Item], depth: int) -> Iterator[str]:
        indent = "  " * depth
        for item in items:
            if isinstance(item, Loop):
                self.loops += 1
                k = f"k{self.loops}"
                head = f"for (int32_t {k} = 0; {k} < {item.count}; ++{k})"
                yield f"{indent}{head} {{ /* {item.name} */"
                yield from self._items(item.body, depth + 1)
                yield f"{indent}}}"
            elif isinstance(item, Rewind):
                for pipe in PIPES:
                    if self.plan.streams[pipe]:
                        yield f"{indent}at_{pipe} = {self.width * item.places[pipe]};"
            else:
                for line in self._op(item):
                    yield indent + line

    def _op(self, op: Op) -> Iterator[str]:
        if op.dst and op.dst not in self.read:
            pass  # a lane that no row fills
        elif op.block:
            place = self._address(op)
            if op.name == "st":
                yield f"{place} = {self._read(str(op.args[0]), False)};"
            else:
                yield self._assigned(op.dst, place)
        elif op.name in VECTOR - {"vout"}:
            self.used.update(HELPERS_OF[op.name])
            form = LANE[op.name].format(*(self._lane(op, arg) for arg in op.args))
            if op.dst not in self.shared:
                yield f"float v_{op.dst}[{self.lanes}];"
            yield f"for (int32_t n = 0; n < {self.lanes}; ++n) v_{op.dst}[n] = {form};"
        else:
            yield self._assigned(op.dst, self._expression(op))
        if op.words is not None:
            yield f"at_{op.pipe} += {self.width};"

    def _assigned(self, name: str, value: str) -> str:
        kind = "" if name in self.shared else f"const {self._type(name)} "
        return f"{kind}v_{name} = {value};"

    def _expression(self, op: Op) -> str:
        if op.name == "vout":
            return f"{self._operand(op, op.args[0], False)} + v_{op.args[1]}[{op.lane}]"
        whole = op.dst in self.integers
        if op.name == "mov":
            return self._operand(op, op.args[0], whole)
        args = [
            self._operand(op, arg, whole if op.name in CHOOSE and k else op.name in INT_OPERANDS)
            for k, arg in enumerate(op.args)
        ]
        if op.name in FORMS:
            return FORMS[op.name].format(*args)
        self.used.add(op.name)
        return f"{op.name}_({', '.join(args)})"

    def _address(self, op: Op) -> str:
        index = op.args[1:] if op.name == "st" else op.args
        block = f"next.{op.block}" if op.block in self.kept else f"local_{op.block}"
        terms = [self._read(str(arg), True) for arg in index]
        return f"{block}[{' + '.join([*terms, str(op.offset)])}]"

    def _lane(self, op: Op, arg: Operand) -> str:
        if isinstance(arg, Vectors):
            return f"stream_{op.pipe}[at_{op.pipe} + n]"
        if isinstance(arg, str) and arg in self.vectors:
            return f"v_{arg}[n]"
        return self._operand(op, arg, False)

    def _operand(self, op: Op, arg: Operand, whole: bool) -> str:
        if isinstance(arg, Words):
            return f"stream_{op.pipe}[at_{op.pipe}]"
        if isinstance(arg, str):
            return self._read(arg, whole)
        if isinstance(arg, int) and whole:
            return f"({arg})" if arg < 0 else str(arg)
        return _number(float(arg))

    def _read(self, name: str, whole: bool) -> str:
        text = self.sources.get(name) or f"v_{name}"
        if (name in self.integers) == whole:
            return text
        helper = "bits" if whole else "number"
        self.used.add(helper)
        return f"{helper}_({text})"

    def _is_int(self, arg: Operand) -> bool:
        return arg in self.integers if isinstance(arg, str) else isinstance(arg, int) and arg != 0

    def _type(self, name: str) -> str:
        return "int32_t" if name in self.integers else "float"


def _read(ops: Sequence[tuple[Op, int]], outputs: Iterable[str]) -> set[str]:
    """Values that reach an output or a store."""
    found = set(outputs)
    while True:
        size = len(found)
        for op, _ in ops:
            if op.name == "st" or op.dst in found:
                found.update(op.reads())
        if len(found) == size:
            return found


def _operations(items: Sequence[Item], place: int = 0) -> Iterator[tuple[Op, int]]:
    """Operations in order, with a number of the list that they are in."""
    for item in items:
        if isinstance(item, Op):
            yield item, place
        elif isinstance(item, Loop):
            yield from _operations(item.body, id(item))


def _number(value: float) -> str:
    literal(value)  # refuses what is no number
    single = binary32(value)
    text = f"{abs(single)!s}f"
    return f"(-{text})" if single < 0 or str(single).startswith("-") else text
