# SPDX-License-Identifier: Apache-2.0
"""Patterns of a graph that a range of single operations does not show.

A floor is four core operations; `floors` gives its argument. What is left of a number after its
floor is a `Fraction`. A floor that reaches results only as whole turns of an angle is `periodic`:
where a rounding moves it by 1, no sine or cosine changes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from asip_asm.model.graph import Graph

TURN = 2 * math.pi
DEPTH = 5
"""Sums within sums in which terms of one angle are looked for."""
WHOLE = 1e-12
"""Distance from a whole number of turns, from the rounding of a constant in double precision."""
SUMS = {"fmadd": (1, 1), "fnmsub": (-1, 1), "fmsub": (1, -1), "fnmadd": (-1, -1)}


@dataclass(frozen=True)
class Fraction:
    """sign * (t - floor(t + offset)); `number` is the node of t + offset."""

    number: int
    offset: float
    sign: int


@dataclass(frozen=True)
class JointSum:
    """A sum with terms x cos w and y sin w of one angle. pairs: x, y and the nodes of both waves;
    others: products (a, b) or plain terms (a, None); inner: sums inside of it, which round too.
    """

    pairs: tuple[tuple[int, int, int, int], ...]
    others: tuple[tuple[int, int | None], ...]
    inner: tuple[int, ...]

    @property
    def nodes(self) -> set[int]:
        found = {each for pair in self.pairs for each in pair}
        return found | {each for pair in self.others for each in pair if each is not None}


class Structure:
    """floors: argument by node; fractions by node; periodic: floors; waves: angle and whether it is
    a cosine, of nodes that are sines or cosines; joint_sums by node; see above.
    """

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.floors: dict[int, int] = {}
        self.fractions: dict[int, Fraction] = {}
        self.waves: dict[int, tuple[int, bool]] = {}
        self.joint_sums: dict[int, JointSum] = {}
        self._angles: dict[tuple[int, ...], int] = {}
        for i in graph.used():
            self._floor(i)
            self._fraction(i)
            self._wave(i)
            self._joint_sum(i)
        self.periodic = {i for i in self.floors if self._only_turns(i)}

    def _floor(self, i: int) -> None:
        nodes = self.graph.nodes
        if nodes[i].op != "fsub" or i in self.graph.functions:
            return
        whole, test = (nodes[arg] for arg in nodes[i].args)
        if whole.op != "i2f" or test.op != "flt" or nodes[whole.args[0]].op != "f2it":
            return
        number = nodes[whole.args[0]].args[0]
        if test.args == (number, nodes[i].args[0]):
            self.floors[i] = number

    def _fraction(self, i: int) -> None:
        node, nodes = self.graph.nodes[i], self.graph.nodes
        if node.op == "fmsub":
            floor, terms, sign = node.args[2], node.args[:2], 1
        elif node.op == "fnmsub":
            floor, terms, sign = node.args[2], node.args[:2], -1
        elif node.op == "fsub":
            (a, b) = node.args
            floor, terms, sign = (b, (a,), 1) if b in self.floors else (a, (b,), -1)
        else:
            return
        if floor not in self.floors:
            return
        number = self.floors[floor]
        if (number,) == terms:
            self.fractions[i] = Fraction(number, 0.0, sign)
            return
        sum_ = nodes[number]
        if sum_.op not in ("fadd", "fmadd"):
            return
        for k, arg in enumerate(sum_.args):
            offset = self.graph.constant(arg)
            rest = sum_.args[:k] + sum_.args[k + 1 :]
            if offset is not None and rest == terms and (sum_.op == "fadd" or k == 2):
                self.fractions[i] = Fraction(number, offset, sign)

    def _wave(self, i: int) -> None:
        """Angles are equal where they are one node, or one multiple of a node in turns."""
        graph = self.graph
        name, args = graph.functions.get(i, ("", ()))
        if name.endswith("_turns"):
            angle = self._angles.setdefault(args, -1 - len(self._angles))
            self.waves[i] = angle, name.startswith("cos")
        elif not name and graph.nodes[i].op in ("fsin", "fcos"):
            self.waves[i] = graph.nodes[i].args[0], graph.nodes[i].op == "fcos"

    def _joint_sum(self, i: int) -> None:
        if i in self.graph.functions or self.graph.nodes[i].op not in (*SUMS, "fadd", "fsub"):
            return
        products, plain, inner = self._terms(i, DEPTH)
        inner.remove(i)
        pairs, others = [], []
        left: dict[tuple[int, bool], list[tuple[int, int]]] = {}
        for a, b in products:
            factor, other = (a, b) if a in self.waves else (b, a)
            if factor not in self.waves:
                others.append((a, b))
                continue
            angle, cosine = self.waves[factor]
            if left.get((angle, not cosine)):
                partner, wave = left[angle, not cosine].pop()
                pairs.append((partner, other, wave, factor))
            else:
                left.setdefault((angle, cosine), []).append((other, factor))
        if pairs:
            alone = [each for found in left.values() for each in found]
            plain_terms = [(each, None) for each in plain]
            self.joint_sums[i] = JointSum(
                tuple(pairs), (*others, *alone, *plain_terms), tuple(inner)
            )

    def _terms(self, i: int, depth: int) -> tuple[list[tuple[int, int]], list[int], list[int]]:
        """Products, plain terms and sums of the sum at node i."""
        node = self.graph.nodes[i]
        if i in self.graph.functions or depth == 0:
            return [], [i], []
        if node.op in ("fmul", "fnmul"):
            return [(node.args[0], node.args[1])], [], [i]
        if node.op in SUMS:
            products, plain, inner = self._terms(node.args[2], depth - 1)
            return [(node.args[0], node.args[1]), *products], plain, [i, *inner]
        if node.op in ("fadd", "fsub"):
            parts = [self._terms(arg, depth - 1) for arg in node.args]
            products = [product for part in parts for product in part[0]]
            plain = [node for part in parts for node in part[1]]
            return products, plain, [i, *(node for part in parts for node in part[2])]
        return [], [i], []

    def _only_turns(self, floor: int) -> bool:
        """Whether a step of the floor moves angles by whole turns, and nothing else."""
        graph, roots = self.graph, set(self.graph.roots())
        factor: dict[int, float] = {floor: 1.0}
        for i in graph.used():
            if i in graph.functions:
                name, args = graph.functions[i]
                reached = [arg for arg in args if arg in factor]
                if reached and not (
                    name.endswith("_turns")
                    and reached == [args[0]]
                    and _whole(factor[args[0]] * (graph.constant(args[1]) or 0.5))
                ):
                    return False
                continue
            args = graph.nodes[i].args
            if i in factor or not any(arg in factor for arg in args):
                continue
            if graph.nodes[i].op in ("fsin", "fcos"):
                if not _whole(factor[args[0]] / TURN):
                    return False
                continue
            passed = self._passed(i, factor)
            if passed is None or i in roots:
                return False
            factor[i] = passed
        return floor not in roots

    def _passed(self, i: int, factor: dict[int, float]) -> float | None:
        """By how much the node moves where the floor moves by 1; None: not by a constant."""
        node, graph = self.graph.nodes[i], self.graph
        moves = [factor.get(arg, 0.0) for arg in node.args]
        if node.op == "fneg":
            return -moves[0]
        if node.op in ("fadd", "fsub"):
            return moves[0] + (moves[1] if node.op == "fadd" else -moves[1])
        signs = SUMS.get(node.op) or {"fmul": (1, 0), "fnmul": (-1, 0)}.get(node.op)
        if signs is None:
            return None
        a, b = (graph.constant(arg) for arg in node.args[:2])
        if moves[0] and moves[1] or (moves[0] and b is None) or (moves[1] and a is None):
            return None
        product = moves[0] * (b or 0.0) + moves[1] * (a or 0.0)
        return signs[0] * product + (signs[1] * moves[2] if signs[1] else 0.0)


def _whole(turns: float) -> bool:
    return abs(turns - round(turns)) <= WHOLE
