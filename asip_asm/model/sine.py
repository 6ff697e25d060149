# SPDX-License-Identifier: Apache-2.0
"""Sines and cosines on the multiply-add pipes, for angles whose range is known.

The angle is taken in turns, t = c X + o. For an encoder X is the count and c, turns per count,
mostly a power of two: then t has no rounding error, where the angle in radians that the sine unit
gets has one. Modulo a turn f = t - round(t); f is folded into w, at most a quarter turn, with
sin(2 pi w) = w P(w^2):

    sine    w = 2 sat(f, -1/4, 1/4) - f        cosine    w = 1/4 - |f|

Both steps are exact, but for the cosine's where its slope is small. t or f is shared by the sine
and the cosine of one angle. `SINE` is what scripts/sine_polynomial.py derives.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from asip_asm.model.expand import MAGIC
from asip_asm.model.functions import LARGEST_TURNS, TURN
from asip_asm.model.graph import Graph, Node, Rewriter
from asip_asm.model.law import Law

SINE = (6.2831854820251465, -41.34176254272461, 81.60829162597656, -76.71895599365234,
        40.80321502685547)  # fmt: skip
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
        return float(node.value), float(node.value)
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
        elif node.op in ("mul", "add") and values.count(None) == 1:
            k = values.index(None)
            value = values[1 - k]
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


def replace_sines(graph: Graph, chosen: Mapping[int, Angle]) -> Graph:
    """The graph with polynomials for the chosen sines and cosines."""
    return _Pipes(graph, chosen).run()


class _Pipes(Rewriter):
    def __init__(self, old: Graph, chosen: Mapping[int, Angle]) -> None:
        super().__init__(old)
        self.chosen = chosen

    def visit(self, index: int, node: Node, args: Sequence[int]) -> int:
        if index not in self.chosen:
            return super().visit(index, node, args)
        angle = self.chosen[index]
        new, scale = self.new, self._scale(angle)
        marked = [self.map[angle.node], scale]
        if angle.offset:
            marked.append(new.const(angle.offset))
        f = self._fraction(angle, *marked)
        quarter = new.const(0.25)
        if node.op == "cos":
            w = new.add("fsub", quarter, new.add("fabs", f))
        elif angle.limit <= 0.25:
            w = f
        else:
            near = new.add("fsat", f, new.const(-0.25), quarter)
            w = new.add("fmsub", near, new.const(2.0), f)
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

    def _fraction(self, angle: Angle, x: int, scale: int, offset: int | None = None) -> int:
        """The angle in turns, modulo a turn if it can be beyond half a turn."""
        new = self.new
        magic = new.const(MAGIC)
        if offset is None:
            if angle.limit <= 0.5:
                return new.add("fmul", x, scale)
            turns = new.add("fsub", new.add("fmadd", x, scale, magic), magic)
            return new.add("fmsub", x, scale, turns)
        t = new.add("fmadd", x, scale, offset)
        if angle.limit <= 0.5:
            return t
        return new.add("fsub", t, new.add("fsub", new.add("fadd", t, magic), magic))
