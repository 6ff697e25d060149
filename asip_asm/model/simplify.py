# SPDX-License-Identifier: Apache-2.0
"""Constant folding and algebra that leaves every binary32 result as it is.

Constants are folded in double precision and rounded once where the program uses them, which is
never less exact than folding in binary32. The identities hold for all finite numbers up to the sign
of a zero: x + 0, x * 1, x * 0, double negation, signs drawn out of products, quotients and odd
functions, division by a power of two, the two halves of a CasADi `if_else`, saturation from min and
max. Equal operations meet because a `Graph` holds each once and commutative arguments are ordered.
"""

from __future__ import annotations

import math
import operator
from collections import Counter
from collections.abc import Callable, Sequence

from asip_asm.model.graph import TESTS, Graph, Node, Rewriter

COMMUTATIVE = frozenset({"add", "mul", "min", "max", "eq", "and", "or"})
ODD = frozenset({"sin", "tan", "asin", "atan", "sinh", "tanh", "asinh", "atanh", "erf", "sign"})
EVEN = frozenset({"cos", "cosh", "abs"})
FOLDED: dict[str, Callable[..., float]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
    "abs": abs,
    "min": min,
    "max": max,
    "fmod": math.fmod,
    "remainder": math.remainder,
    "copysign": math.copysign,
    "pow": math.pow,
    "lt": lambda a, b: float(a < b),
    "le": lambda a, b: float(a <= b),
    "eq": lambda a, b: float(a == b),
    "not": lambda a: float(not a),
    "and": lambda a, b: float(bool(a) and bool(b)),
    "or": lambda a, b: float(bool(a) or bool(b)),
    "sign": lambda a: math.copysign(1.0, a) if a else 0.0,
    "floor": lambda a: float(math.floor(a)),
    "ceil": lambda a: float(math.ceil(a)),
}
FOLDED |= {
    name: getattr(math, name)
    for name in (
        "sqrt sin cos tan asin acos atan atan2 exp log sinh cosh tanh asinh acosh atanh erf "
        "log1p expm1 hypot"
    ).split()
}


def simplify(graph: Graph) -> Graph:
    """The graph with constants folded and identities applied."""
    return _Simplifier(graph).run()


class _Simplifier(Rewriter):
    def visit(self, index: int, node: Node, args: Sequence[int]) -> int:
        return self.make(node.op, args) if node.args else super().visit(index, node, args)

    def make(self, op: str, args: Sequence[int]) -> int:
        """Operation in its simplest form."""
        values = [self.new.constant(arg) for arg in args]
        if op in FOLDED and None not in values:
            try:
                return self.new.const(FOLDED[op](*values))
            except (ArithmeticError, ValueError):
                pass  # the program shall do what the law states
        rule = getattr(self, f"_{op}", None)
        found = rule(*args) if rule else None
        if found is not None:
            return found
        if op in COMMUTATIVE:
            args = sorted(args)
        if op in ODD and self._is(args[0], "neg"):
            return self.make("neg", [self.make(op, [self._arg(args[0])])])
        if op in EVEN and self._is(args[0], "neg"):
            return self.make(op, [self._arg(args[0])])
        return self.new.add(op, *args)

    def _is(self, index: int, op: str) -> bool:
        return self.new.nodes[index].op == op

    def _arg(self, index: int) -> int:
        return self.new.nodes[index].args[0]

    # ------------------------------------------------------------------ one rule per operation
    def _add(self, a: int, b: int) -> int | None:
        if self.new.constant(a) == 0:
            return b
        if self.new.constant(b) == 0:
            return a
        if self._is(b, "neg"):
            return self.make("sub", [a, self._arg(b)])
        if self._is(a, "neg"):
            return self.make("sub", [b, self._arg(a)])
        return self._if_else(a, b) or self._if_else(b, a)

    def _if_else(self, a: int, b: int) -> int | None:
        """select(c, x, 0) + select(not c, y, 0), as CasADi writes if_else."""
        if not (self._is(a, "select") and self._is(b, "select")):
            return None
        c, x, zero = self.new.nodes[a].args
        d, zero_of_b, y = self.new.nodes[b].args
        both = self.new.constant(zero) == 0 and self.new.constant(zero_of_b) == 0
        return self.new.add("select", c, x, y) if c == d and both else None

    def _sub(self, a: int, b: int) -> int | None:
        if a == b:
            return self.new.const(0.0)
        if self.new.constant(a) == 0:
            return self.make("neg", [b])
        if self.new.constant(b) == 0:
            return a
        if self._is(b, "neg"):
            return self.make("add", [a, self._arg(b)])
        if self._is(a, "neg"):
            return self.make("neg", [self.make("add", [self._arg(a), b])])
        return None

    def _mul(self, *args: int) -> int | None:
        for a, b in (args, args[::-1]):
            value = self.new.constant(a)
            if value == 0:
                return self.new.const(0.0)
            if value == 1:
                return b
            if value is not None and value < 0:
                return self.make("neg", [self.make("mul", [self.new.const(-value), b])])
            if self._is(a, "neg"):
                return self.make("neg", [self.make("mul", [self._arg(a), b])])
        return None

    def _div(self, a: int, b: int) -> int | None:
        if self._is(a, "neg"):
            return self.make("neg", [self.make("div", [self._arg(a), b])])
        if self._is(b, "neg"):
            return self.make("neg", [self.make("div", [a, self._arg(b)])])
        if self.new.constant(a) == 0:
            return a
        value = self.new.constant(b)
        if value is not None and value != 0 and abs(math.frexp(value)[0]) == 0.5:
            return self.make("mul", [a, self.new.const(1.0 / value)])
        return None

    def _neg(self, a: int) -> int | None:
        if self._is(a, "neg"):
            return self._arg(a)
        if self._is(a, "sub"):
            return self.make("sub", self.new.nodes[a].args[::-1])
        return None

    def _not(self, a: int) -> int | None:
        return self._arg(a) if self._is(a, "not") and is_test(self.new, self._arg(a)) else None

    def _select(self, test: int, a: int, b: int) -> int | None:
        if a == b:
            return a
        value = self.new.constant(test)
        if value is not None:
            return a if value else b
        if self._is(test, "not"):
            return self.make("select", [self._arg(test), b, a])
        return None

    def _min(self, *args: int) -> int | None:
        return self._saturation(args, "max")

    def _max(self, *args: int) -> int | None:
        return self._saturation(args, "min")

    def _saturation(self, args: Sequence[int], inner: str) -> int | None:
        """min(max(x, low), high) or max(min(x, high), low) with constants low <= high."""
        for a, b in (args, args[::-1]):
            outer = self.new.constant(b)
            if outer is None or not self._is(a, inner):
                continue
            for x, other in (self.new.nodes[a].args, self.new.nodes[a].args[::-1]):
                bound = self.new.constant(other)
                if bound is None:
                    continue
                low, high = (other, b) if inner == "max" else (b, other)
                least, most = self.new.constant(low), self.new.constant(high)
                if least is not None and most is not None and least <= most:
                    return self.new.add("sat", x, low, high)
        return None


def is_test(graph: Graph, index: int) -> bool:
    """Whether the node's value is 0 or 1."""
    node = graph.nodes[index]
    return node.op in TESTS or node.op in ("flt", "fle", "feq")


def share_divisors(graph: Graph) -> Graph:
    """One reciprocal for all quotients of a divisor that occurs at least twice, and products with
    1/c for quotients by a constant c.

    Rounds twice where a division rounds once: the result is off by at most 1.5 instead of 0.5 ulp.
    """
    count = Counter(node.args[1] for _, node in graph.operations() if node.op == "div")
    return _Reciprocals(graph, count).run()


class _Reciprocals(Rewriter):
    def __init__(self, old: Graph, count: dict[int, int]) -> None:
        super().__init__(old)
        self.count = count

    def visit(self, index: int, node: Node, args: Sequence[int]) -> int:
        if node.op == "div":
            value = self.new.constant(args[1])
            if value is not None and value != 0:
                return self.new.add("mul", args[0], self.new.const(1.0 / value))
            if self.count[node.args[1]] > 1:
                one = self.new.const(1.0)
                inverse = self.new.add("div", one, args[1])
                return self.new.add("mul", args[0], inverse) if args[0] != one else inverse
        return super().visit(index, node, args)
