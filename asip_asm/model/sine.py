# SPDX-License-Identifier: Apache-2.0
"""Sines and cosines on the multiply-add pipes, for angles whose range is known.

The angle is taken in turns, t = c X + o. For an encoder X is the count and c, turns per count,
mostly a power of two: then t has no rounding error, where the angle in radians that the sine unit
gets has one. The angle is folded into w, at most a quarter turn, with sin(2 pi w) = w P(w^2):

                    |t| to 1/4    to 1/2           to 3/4             to 1
    sine            t             sgn(t)/2 - t     sgn(t)/2 - t       t - sgn(t)
    cosine          1/4 - |t|     1/4 - |t|        |t| - 3/4          |t| - 3/4

There are two ways to do so. One takes minima, maxima and saturations, and a few multiply-adds. The
other is one multiply-add of a factor and a number that comparisons choose: it leaves the pipes free
but takes longer. Columns beyond the largest angle cost nothing. Beyond a turn f = t - round(t) is
folded so. All steps are exact, except the cosine's where its slope is small. `SINE` is what
scripts/sine_polynomial.py derives.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from asip_asm.model.functions import LARGEST_TURNS, TURN
from asip_asm.model.graph import Graph, Node, Rewriter
from asip_asm.model.law import Law

SINE = (6.2831854820251465, -41.34176254272461, 81.60829162597656, -76.71895599365234,
        40.80321502685547)  # fmt: skip
QUARTER, THREE_QUARTERS = 0.25, 0.75
Range = tuple[float, float]
NOWHERE: Range = (-math.inf, math.inf)


@dataclass(frozen=True)
class Angle:
    """An angle in turns, scale * node + offset, at most `limit` in size (inf: not known)."""

    node: int
    scale: float
    offset: float
    limit: float

    @property
    def known(self) -> bool:
        """Whether a polynomial can take it."""
        return self.limit <= LARGEST_TURNS


def ranges_of(graph: Graph, law: Law) -> dict[int, Range]:
    """Smallest and largest value of every node that is used, from the limits of the law's inputs,
    which its record states; infinite where nothing limits it.
    """
    limits: dict[str, Range] = {}
    for port in law.of_kind("input"):
        if port.limits is not None:
            ends = [(limit - port.offset) / port.scale for limit in port.limits]
            limits[port.name] = (min(ends), max(ends))
    found: dict[int, Range] = {}
    for i in graph.used():
        node = graph.nodes[i]
        low, high = _range(node, [found[arg] for arg in node.args], limits)
        found[i] = (low, high) if low <= high else NOWHERE  # not a number: 0 times infinity
    return found


def _range(node: Node, args: Sequence[Range], limits: Mapping[str, Range]) -> Range:
    if node.op == "const":
        return node.number, node.number
    if node.op in ("input", "int_input"):
        return limits.get(str(node.value), NOWHERE)
    if node.op == "i2f":
        return args[0]
    if node.op == "neg":
        return -args[0][1], -args[0][0]
    if node.op == "add":
        return args[0][0] + args[1][0], args[0][1] + args[1][1]
    if node.op == "sub":
        return args[0][0] - args[1][1], args[0][1] - args[1][0]
    if node.op == "mul":
        ends = [a * b for a in args[0] for b in args[1]]
        return NOWHERE if any(map(math.isnan, ends)) else (min(ends), max(ends))
    if node.op == "sat":
        return max(args[0][0], args[1][0]), min(args[0][1], args[2][1])
    return NOWHERE


def angle_of(graph: Graph, index: int, limit: float) -> Angle:
    """The node, radians, at most `limit` turns, as scaled and moved multiple of another one."""
    scale, offset = 1 / TURN, 0.0
    while True:
        node = graph.nodes[index]
        values = [graph.constant(arg) for arg in node.args]
        if node.op == "neg":
            index, scale = node.args[0], -scale
            continue
        k = values.index(None) if values.count(None) == 1 else 0
        value = values[1 - k] if len(values) == 2 else None
        if node.op in ("mul", "add") and value is not None and values[k] is None:
            index = node.args[k]
            if node.op == "mul":
                scale *= value
            else:
                offset += scale * value
        else:
            return Angle(index, scale, offset, limit)


def angles(graph: Graph, law: Law) -> dict[int, Angle]:
    """Angles of the sines and cosines of a graph, by their nodes, those of known range."""
    ranges = ranges_of(graph, law)
    found = {
        i: angle_of(graph, node.args[0], max(map(abs, ranges[node.args[0]])) / TURN)
        for i, node in graph.operations()
        if node.op in ("sin", "cos")
    }
    return {i: angle for i, angle in found.items() if angle.known}


def replace_sines(graph: Graph, chosen: Mapping[int, Angle], by_choices: bool = True) -> Graph:
    """The graph with polynomials for the chosen sines and cosines; by_choices: angles are folded by
    comparisons.
    """
    return _Pipes(graph, chosen, by_choices).run()


class _Pipes(Rewriter):
    def __init__(self, old: Graph, chosen: Mapping[int, Angle], by_choices: bool) -> None:
        super().__init__(old)
        self.chosen = chosen
        self.by_choices = by_choices

    def visit(self, index: int, node: Node, args: Sequence[int]) -> int:
        if index not in self.chosen:
            return super().visit(index, node, args)
        angle = self.chosen[index]
        new, scale = self.new, self._scale(angle)
        marked = [self.map[angle.node], scale]
        if angle.offset:
            marked.append(new.const(angle.offset))
        x, c, limit = self._reduced(angle, *marked)
        w = (self._cosine if node.op == "cos" else self._sine)(x, c, limit)
        square = new.add("fmul", w, w)
        p = new.const(SINE[-1])
        for value in reversed(SINE[:-1]):
            p = new.add("fmadd", p, square, new.const(value))
        result = new.add("fmul", p, w)
        new.functions[result] = (f"{node.op}_turns", tuple(marked))
        return result

    def _scale(self, angle: Angle) -> int:
        """Constant: turns per unit of the node; a power of two where rounding hid it."""
        near = 2.0 ** round(math.log2(abs(angle.scale)))
        same = math.isclose(abs(angle.scale), near, rel_tol=1e-15)
        return self.new.const(math.copysign(near, angle.scale) if same else angle.scale)

    def _sine(self, x: int, c: float, limit: float) -> int:
        """The quarter turn that has the sine of c x, at most `limit` turns."""
        if limit <= QUARTER:
            return x if c == 1 else self.new.add("fmul", x, self.new.const(c))
        return (self._chosen_sine if self.by_choices else self._saturated_sine)(x, c, limit)

    def _saturated_sine(self, x: int, c: float, limit: float) -> int:
        """2 (sat(x, quarter) - sat(x, three quarters)) c + c x."""
        new = self.new
        t = x if c == 1 else new.add("fmul", x, new.const(c))
        near = self._saturated(x, QUARTER / abs(c))
        if limit <= THREE_QUARTERS:
            return new.add("fmsub", near, new.const(2 * c), t)
        fold = new.add("fsub", near, self._saturated(x, THREE_QUARTERS / abs(c)))
        return new.add("fmadd", fold, new.const(2 * c), t)

    def _chosen_sine(self, x: int, c: float, limit: float) -> int:
        new = self.new
        size = new.add("fabs", x)
        near = new.add("flt", new.const(QUARTER / abs(c)), size)
        factor, number = new.const(-c), self._signed(x, math.copysign(0.5, c))
        if limit > THREE_QUARTERS:
            far = new.add("flt", new.const(THREE_QUARTERS / abs(c)), size)
            factor = new.add("sel", far, new.const(c), factor)
            number = new.add("sel", far, self._signed(x, math.copysign(1.0, -c)), number)
        factor = new.add("sel", near, factor, new.const(c))
        number = new.add("sel", near, number, new.const(0.0))
        return new.add("fmadd", x, factor, number)

    def _cosine(self, x: int, c: float, limit: float) -> int:
        """The quarter turn whose sine is the cosine of c x, at most `limit` turns."""
        new = self.new
        size, c = new.add("fabs", x), abs(c)
        if limit > 0.5 and self.by_choices:
            far = new.add("flt", new.const(0.5 / c), size)
            factor = new.add("sel", far, new.const(c), new.const(-c))
            number = new.add("sel", far, new.const(-THREE_QUARTERS), new.const(QUARTER))
            return new.add("fmadd", size, factor, number)
        near = new.add("fnmsub", size, new.const(c), new.const(QUARTER))
        if limit <= 0.5:
            return near
        far = new.add("fmsub", size, new.const(c), new.const(THREE_QUARTERS))
        return new.add("fmax", near, far)

    def _saturated(self, x: int, limit: float) -> int:
        return self.new.add("fsat", x, self.new.const(-limit), self.new.const(limit))

    def _signed(self, x: int, value: float) -> int:
        """The value with the sign of x."""
        return self.new.add("selge", x, self.new.const(value), self.new.const(-value))

    def _reduced(
        self, angle: Angle, x: int, scale: int, offset: int | None = None
    ) -> tuple[int, float, float]:
        """A node and a factor, whose product is the angle in turns, modulo a turn if it can be
        beyond a turn; the largest size of the product.
        """
        new, c = self.new, self.new.nodes[scale].number
        if offset is not None:
            x, c = new.add("fmadd", x, scale, offset), 1.0
        if angle.limit <= 1:
            return x, c, angle.limit
        t = x if c == 1 else new.add("fmul", x, scale)
        turns = new.add("i2f", new.add("f2i", t))
        return new.add("fmsub", x, new.const(c), turns), 1.0, 0.5
