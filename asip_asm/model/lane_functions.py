# SPDX-License-Identifier: Apache-2.0
"""Functions of each element: operations on a number, and on vectors where the lanes have them."""

from __future__ import annotations

from asip_asm.machine import Machine
from asip_asm.model.expand import LEAST, MAGIC, STEP, expand_functions
from asip_asm.model.graph import Graph, Node
from asip_asm.model.plan import Plan
from asip_asm.model.plan_items import Operand
from asip_asm.model.read import Scalars, read_function
from asip_asm.model.simplify import simplify
from asip_asm.model.sums import SumBuilder

PRODUCTS = {"fmadd": (1, 1), "fnmsub": (-1, 1), "fmsub": (1, -1), "fnmadd": (-1, -1)}
"""Signs of product and addend."""


def core_graph(function: Scalars, machine: Machine) -> Graph:
    """Core operations of a function of one number 'x', output 'y'."""
    real = Graph()
    nodes = read_function(function, real, [[real.add("input", value="x")]])
    real.outputs["y"] = nodes[0][0]
    return SumBuilder(expand_functions(simplify(real)), machine, False).run()


def activate(plan: Plan, function: Scalars, value: str) -> str:
    """Append a function of one number, as the compiler of scalar laws makes it."""
    graph = core_graph(function, plan.machine)
    names: dict[int, Operand] = {}
    for i in graph.used():
        node = graph.nodes[i]
        if node.op == "input":
            names[i] = value
        elif node.op == "const":
            names[i] = node.number
        elif node.op == "int_const":
            names[i] = int(node.number)
        else:
            names[i] = plan.op(node.op, *(names[arg] for arg in node.args))
        if i in graph.functions:
            called, args = graph.functions[i]
            plan.mark(str(names[i]), called, [names[arg] for arg in args])
    return str(names[graph.outputs["y"]])


class LaneFunction:
    """A function as operations in lanes: `usable` unless it has one that no lane has."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.steps: dict[int, tuple[str, tuple[int | float, ...]]] = {}
        self.usable = all(self._step(i) for i in graph.used())
        read = {arg for _, args in self.steps.values() for arg in args if isinstance(arg, int)}
        self.read = read | {graph.outputs["y"]}
        self.steps = {i: step for i, step in self.steps.items() if i in self.read}
        self.usable = self.usable and graph.outputs["y"] in self.steps

    def append(self, plan: Plan, pipe: str, value: str) -> str:
        """Append the function of a vector; the name of its result."""
        names: dict[int, str] = {}

        def operand(arg: int | float) -> Operand:
            if isinstance(arg, float):
                return arg
            return names.get(arg, value)

        for i, (name, args) in self.steps.items():
            names[i] = plan.vector(name, *(operand(arg) for arg in args), pipe=pipe)
        for i, name in names.items():
            if i in self.graph.functions:
                called, given = self.graph.functions[i]
                plan.mark(name, called, [operand(self._argument(arg)) for arg in given])
        return names[self.graph.outputs["y"]]

    def _argument(self, i: int) -> int | float:
        value = self.graph.constant(i)
        return i if value is None else value

    def _step(self, i: int) -> bool:
        """Note the lanes' operation of a node. False if there is none."""
        node = self.graph.nodes[i]
        args = [self._argument(arg) for arg in node.args]
        found: tuple[str, tuple[int | float, ...]] | None = None
        if node.op in ("input", "const"):
            return True
        if node.op in PRODUCTS:
            found = self._product(*PRODUCTS[node.op], args[0], args[1], args[2])
        elif node.op == "fmul":
            found = self._product(1, 1, args[0], args[1], 0.0)
        elif node.op == "fadd":
            found = self._sum(args[0], args[1])
        elif node.op == "fsub" and isinstance(args[1], float):
            found = self._product(1, 1, args[0], 1.0, -args[1])
        elif node.op == "fsat" and [*map(self.graph.constant, node.args[1:])] == [LEAST, 0.0]:
            found = "vbelow", (args[0], 1.0)
        elif node.op == "fmax" and self.graph.constant(node.args[1]) == 0.0:
            found = "vabove", (args[0], 1.0, 0.0)
        elif node.op == "fmax" and self.graph.constant(node.args[0]) == 0.0:
            found = "vabove", (args[1], 1.0, 0.0)
        elif node.op == "selgt" and node.args[0] == node.args[1] and self._below(node):
            found = "vabove", (args[0], 1.0, args[2])
        elif node.op == "f2i":
            return self._exponent(i) is not None  # read by vscale alone, or `_product` fails
        if found is None:
            return False
        self.steps[i] = found
        return True

    def _below(self, node: Node) -> bool:
        """Whether the other choice of a selection is 0 where its number is positive."""
        i = node.args[2]
        other = self.graph.nodes[i]
        if other.op == "fmul":
            i = next((arg for arg in other.args if self.graph.constant(arg) is None), i)
        return self.graph.functions.get(i) == ("expm1_below", node.args[:1])

    def _exponent(self, i: int | float) -> int | None:
        """The sum MAGIC + n whose power 2^n node i is; None for other nodes."""
        if isinstance(i, float) or self.graph.nodes[i].op != "f2i":
            return None
        bits = self.graph.nodes[self.graph.nodes[i].args[0]]
        if bits.op != "fmadd":
            return None
        constants = [self.graph.constant(arg) for arg in bits.args[1:]]
        return bits.args[0] if constants == [STEP, (127 - MAGIC) * STEP] else None

    def _product(
        self, sign: int, addend: int, a: int | float, b: int | float, c: int | float
    ) -> tuple[str, tuple[int | float, ...]] | None:
        if isinstance(a, float):
            a, b = b, a
        if sign < 0:
            if not isinstance(b, float):
                return None
            b = -b
        if addend < 0:
            if not isinstance(c, float):
                return None
            c = -c
        for one, other in ((a, b), (b, a)):
            exponent = self._exponent(one)
            if exponent is not None:
                return "vscale", (other, exponent, c)
        if self._exponent(c) is not None:
            return None
        return "vmadd", (a, b, c)

    def _sum(self, a: int | float, b: int | float) -> tuple[str, tuple[int | float, ...]] | None:
        """a + b; a positive part joins its sum."""
        for one, other in ((a, b), (b, a)):
            if isinstance(one, int) and self.steps.get(one, ("",))[0] == "vabove":
                argument, _, nothing = self.steps[one][1]
                if isinstance(nothing, float) and nothing == 0.0:
                    return "vabove", (argument, 1.0, other)
        return self._product(1, 1, a, 1.0, b)
