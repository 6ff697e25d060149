# SPDX-License-Identifier: Apache-2.0
"""Sums and products of real numbers become multiply-adds: which of two products is rounded by
itself, and in which order terms are added, is chosen for the critical path.

A sum is a tree of `add`, `sub` and `neg`; its terms are products, which a multiply-add can take in,
and plain values. Without `reassociate` every sum has two terms as the law writes it, and only
products are taken in (one rounding fewer). With it, sums and products that are read once are merged
into the one that reads them, and terms are joined as they arrive: the two earliest first (Huffman's
algorithm with max + latency in place of a sum). Some terms more may start as products of their own,
which costs an operation each: as many as the time allowed for the sum (`deadline`) asks for.
Reassociation changes roundings, not the real value.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from asip_asm.machine import Machine
from asip_asm.model.graph import Graph, Node, Rewriter
from asip_asm.model.simplify import is_test

FMA = {(1, 1): "fmadd", (-1, 1): "fnmsub", (1, -1): "fmsub", (-1, -1): "fnmadd"}
"""Multiply-add by the signs of product and addend."""
DIRECT = {"sign": "fsgn"} | {
    name: f"f{name}" for name in "div sqrt sin cos abs min max sat lt le eq".split()
}
"""Real operations that the core has."""


@dataclass(frozen=True)
class Term:
    """Signed product of two nodes, or one node (b is None), of the new graph."""

    sign: int
    a: int
    b: int | None
    shared: bool = False


class SumBuilder(Rewriter):
    """Maps real arithmetic to core operations, in the form with the shortest critical path.

    deadlines: cycle at which the value of a node of the old graph must be ready, for nodes that may
    be later than they could be. arrival: after `run`, the earliest cycle of every node of the new
    graph.
    """

    def __init__(
        self,
        old: Graph,
        machine: Machine,
        reassociate: bool,
        deadlines: Mapping[int, float] | None = None,
    ) -> None:
        super().__init__(old)
        self.machine = machine
        self.reassociate = reassociate
        self.deadlines = deadlines or {}
        self.arrival: list[int] = []
        self.uses = old.uses()
        self.inside = self._inside()

    def _inside(self) -> list[bool]:
        """Whether a node is part of the sums or the product that read it, and has no value of its
        own.
        """
        old = self.old
        readers: list[list[str]] = [[] for _ in old.nodes]
        roots = set(old.roots())
        result = [False] * len(old.nodes)
        for i in reversed(old.used()):
            node, ops = old.nodes[i], readers[i]
            in_sum = all(op in ("add", "sub", "neg") for op in ops)
            if i in roots:
                pass
            elif node.op == "neg":
                result[i] = all(op in ("add", "sub", "neg", "mul") for op in ops)
            elif node.op == "mul":
                # A product read by several sums is taken into each: none waits for it.
                result[i] = in_sum or (self.reassociate and ops == ["mul"])
            elif node.op in ("add", "sub"):
                result[i] = self.reassociate and len(ops) == 1 and in_sum
            seen = ops if node.op == "neg" and result[i] else [node.op]
            for arg in node.args:
                readers[arg] += seen
        return result

    # ------------------------------------------------------------------ nodes
    def latency(self, op: str) -> int:
        """Cycles from the issue of a core operation to the issue of its reader."""
        return self.machine.units[self.machine.unit_names[op]].ranks + 1

    def time(self, index: int) -> int:
        """Earliest cycle at which a reader of the new node can issue."""
        while len(self.arrival) <= index:
            node = self.new.nodes[len(self.arrival)]
            ready = max((self.arrival[arg] for arg in node.args), default=0)
            self.arrival.append(ready + self.latency(node.op) if node.args else 0)
        return self.arrival[index]

    def visit(self, index: int, node: Node, args: Sequence[int]) -> int:
        if node.op in ("add", "sub", "neg", "mul"):
            return -1 if self.inside[index] else self._sum(index)
        if -1 in args:
            raise AssertionError(f"{node.op} reads a term of a sum")
        if node.op in DIRECT:
            return self.new.add(DIRECT[node.op], *args)
        rule = getattr(self, f"_{node.op}", None)
        return rule(*args) if rule else super().visit(index, node, args)

    def _not(self, a: int) -> int:
        if is_test(self.new, a):
            return self.new.add("fsub", self.new.const(1.0), a)
        return self.new.add("feq", a, self.new.const(0.0))

    def _test(self, index: int) -> int:
        if is_test(self.new, index):
            return index
        return self.new.add("sel", index, self.new.const(1.0), self.new.const(0.0))

    def _and(self, a: int, b: int) -> int:
        return self.new.add("fmin", self._test(a), self._test(b))

    def _or(self, a: int, b: int) -> int:
        return self.new.add("fmax", self._test(a), self._test(b))

    def _select(self, test: int, a: int, b: int) -> int:
        node = self.new.nodes[test]
        if node.op in ("flt", "fle") and self.new.constant(node.args[0]) == 0:
            return self.new.add("selgt" if node.op == "flt" else "selge", node.args[1], a, b)
        return self.new.add("sel", test, a, b)

    def _copysign(self, a: int, b: int) -> int:
        """A zero counts as positive, whatever its sign."""
        size = self.new.add("fabs", a)
        return self.new.add("selge", b, size, self.new.add("fneg", size))

    # ------------------------------------------------------------------ sums
    def _sum(self, index: int) -> int:
        """Value of a sum or product that is read as a whole."""
        terms = self._terms(index, 1)
        deadline = self.deadlines.get(index, 0.0)
        products = sum(term.b is not None for term in terms)
        least = int(products == len(terms))
        chosen, best = least, self._join(terms, least, dry=True)
        for starts in range(least + 1, products + 1 if self.reassociate else least):
            if best <= deadline:
                break
            time = self._join(terms, starts, dry=True)
            if time < best:
                chosen, best = starts, time
        return self._join(terms, chosen)

    def _terms(self, index: int, sign: int) -> list[Term]:
        """Terms of the sum at a node, from left to right; a sum may have thousands of them."""
        found: list[Term] = []
        left = [(index, sign)]
        while left:
            i, sign = left.pop()
            node = self.old.nodes[i]
            if node.op == "mul":
                found.append(Term(*self._product(i, sign), self.uses[i] > 1))
            elif i != index and not self.inside[i]:
                found.append(Term(sign, self.map[i], None))
            elif node.op == "neg":
                left.append((node.args[0], -sign))
            else:
                second = -sign if node.op == "sub" else sign
                left += [(node.args[1], second), (node.args[0], sign)]
        return found

    def _product(self, index: int, sign: int) -> tuple[int, int, int]:
        """Sign and the two factors, of which the later is joined last."""
        sign, factors = self._factors(index, sign)
        factors = self._fold(factors) if self.reassociate else factors
        heap = [(self.time(factor), factor) for factor in factors]
        heapq.heapify(heap)
        while len(heap) > 2:
            (_, a), (_, b) = heapq.heappop(heap), heapq.heappop(heap)
            c = self.new.add("fmul", *sorted((a, b)))
            heapq.heappush(heap, (self.time(c), c))
        a, b = sorted(factor for _, factor in heap)
        return sign, a, b

    def _factors(self, index: int, sign: int) -> tuple[int, list[int]]:
        """Sign and factors of the product at a node, from left to right."""
        factors: list[int] = []
        left = [index]
        while left:
            i = left.pop()
            node = self.old.nodes[i]
            if node.op == "neg" and self.inside[i]:
                sign = -sign
                left.append(node.args[0])
            elif node.op == "mul" and (i == index or self.inside[i]):
                left += reversed(node.args)
            else:
                factors.append(self.map[i])
        return sign, factors

    def _fold(self, factors: Sequence[int]) -> list[int]:
        """Factors with their constants multiplied, in double precision."""
        constants = [self.new.constant(factor) for factor in factors]
        others = [f for f, value in zip(factors, constants, strict=True) if value is None]
        numbers = [value for value in constants if value is not None]
        if len(numbers) < 2 or not others:
            return list(factors)
        return [*others, self.new.const(math.prod(numbers))]

    def _join(self, terms: Sequence[Term], starts: int, dry: bool = False) -> int:
        """Add the terms, `starts` of the products rounded by themselves first; the node, or when
        `dry` only the cycle at which it is ready.
        """
        lone = sorted(
            (t for t in terms if t.b is not None), key=lambda t: (not t.shared, self._when(t))
        )
        chosen = {id(term) for term in lone[:starts]}
        values: list[tuple[int, int, int, int]] = []  # time, order, sign, node
        products: list[tuple[int, int, Term]] = []
        for order, term in enumerate(terms):
            if term.b is None:
                values.append((self._when(term), order, term.sign, term.a))
            elif id(term) in chosen:
                last = len(terms) == 1
                op = "fmul" if term.sign > 0 or not last else "fnmul"
                sign = 1 if last else term.sign
                node = 0 if dry else self.new.add(op, term.a, term.b)
                values.append((self._when(term) + self.latency("fmul"), order, sign, node))
            else:
                products.append((self._when(term), order, term))
        heapq.heapify(values)
        heapq.heapify(products)
        order = len(terms)
        while products or len(values) > 1:
            time, _, sign, node = heapq.heappop(values)
            if products and (not values or products[0][0] <= values[0][0]):
                other, _, term = heapq.heappop(products)
                done = max(time, other) + self.latency("fmadd")
                made = 0
                if not dry:
                    factors = (term.a,) if term.b is None else (term.a, term.b)
                    made = self.new.add(FMA[term.sign, sign], *factors, node)
                sign = 1
            else:
                other, _, second, right = heapq.heappop(values)
                done = max(time, other) + self.latency("fadd")
                last = not products and not values
                made, sign = (0, 1) if dry else self._add(sign, node, second, right, last)
            heapq.heappush(values, (done, order, sign, made))
            order += 1
        time, _, sign, node = values[0]
        if dry:
            return time
        return node if sign > 0 else self.new.add("fneg", node)

    def _when(self, term: Term) -> int:
        time = self.time(term.a)
        return time if term.b is None else max(time, self.time(term.b))

    def _add(self, sign: int, a: int, second: int, b: int, last: bool) -> tuple[int, int]:
        """Sign and node of the sum of two signed values; `last`: the sign must be positive."""
        if sign == second == -1 and last:
            return self.new.add("fnmadd", *sorted((a, self.new.const(1.0))), b), 1
        if sign == second:
            return self.new.add("fadd", *sorted((a, b))), sign
        return (self.new.add("fsub", a, b) if sign > 0 else self.new.add("fsub", b, a)), 1
