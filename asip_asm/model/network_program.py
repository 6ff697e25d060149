# SPDX-License-Identifier: Apache-2.0
"""Program of a network of dense layers: loops over rows and columns, weights from the streams.

A layer is computed in blocks of rows. Their sums are in registers; a loop over the columns loads a
number of the layer's input once and multiplies it with a column of the block, two rows a cycle.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from asip_asm.isa import default_isa
from asip_asm.machine import Machine
from asip_asm.model.compiler import SINES, Compiled, Options
from asip_asm.model.expand import expand_functions
from asip_asm.model.graph import Graph
from asip_asm.model.law import Law
from asip_asm.model.onnx_layers import Layer, Network
from asip_asm.model.plan import Operand, Plan, Words, compiled
from asip_asm.model.read import ModelError, Scalars, read_function
from asip_asm.model.simplify import simplify
from asip_asm.model.sums import SumBuilder

BLOCKS = (64, 32, 16)
"""Rows of a block, of which the shortest program that fits is taken."""


ROOM = 0.9
"""Share of the program memory that the least bundles of a plan may take: schedules have gaps."""


def compile_network(law: Law, options: Options, machine: Machine) -> Compiled:
    """The program with the largest blocks that fit. Raises ModelError."""
    network = law.function.network  # type: ignore[union-attr]
    if options.reassociate or options.reciprocal or options.sine != SINES[0]:
        raise ModelError(
            f"{law.title}: a network on streams has no other sums, quotients or sines; leave out "
            "--reassociate, --reciprocal and --sine, or take --config fast"
        )
    room = ROOM * default_isa().program_bundles
    for rows in BLOCKS:
        plan = network_plan(law, network, machine, rows)
        if plan.bundles() <= room or rows == BLOCKS[-1]:
            break
    return compiled(plan, law)


def network_plan(law: Law, network: Network, machine: Machine, rows: int) -> Plan:
    """The finished plan with at most `rows` rows in a block. Raises ModelError."""
    return _Maker(law, network, machine, rows).make()


class _Maker:
    def __init__(self, law: Law, network: Network, machine: Machine, rows: int) -> None:
        self.law, self.network, self.rows = law, network, rows
        odd = [p for p in law.ports if p.kind not in ("input", "output") or p.type != "float"]
        if odd:
            raise ModelError(
                f"{law.title}: '{odd[0].name}' is a {odd[0].kind} of type {odd[0].type}; a network "
                "on streams has inputs and outputs of floats alone: take --config fast"
            )
        inputs = [port.name for port in law.of_kind("input")]
        outputs = {port.name: port.safe for port in law.of_kind("output")}
        self.plan = Plan(law.title, inputs, outputs, machine)
        # Issue distance of dependent multiply-adds, in rows of both pipes.
        self.hidden = 2 * (machine.units["fma"].ranks + 1)

    def make(self) -> Plan:
        plan, network = self.plan, self.network
        (_, ports), = self.law.matched("argument", [network.argument])
        (_, results), = self.law.matched("result", [network.result])
        layers = network.layers
        blocks = [_Block(layer, self.rows, self.hidden) for layer in layers]
        for number, block in enumerate(blocks):
            # Loads of the last round go beyond the last column.
            size = block.columns + block.unroll
            if number:
                size = max(size, blocks[number - 1].rows * blocks[number - 1].count)
            plan.spaces[f"layer{number}"] = size
        last = blocks[-1].rows * blocks[-1].count
        if blocks[-1].count > 1:
            plan.spaces[f"layer{len(layers)}"] = last
        used, room = sum(plan.spaces.values()), plan.machine.data_words
        if used > room:
            raise ModelError(f"{self.law.title}: the numbers of all layers take {used} words of data "
                             f"memory, the core has {room}; take fewer neurons")  # fmt: skip
        for k, port in enumerate(ports):
            plan.store(port.name, "layer0", k)
        plan.rewind()
        values: list[str] = []
        for number, (layer, block) in enumerate(zip(layers, blocks, strict=True)):
            values = self.layer(number, layer, block, number + 1 == len(layers))
        if not values:
            values = [plan.load(f"layer{len(layers)}", k) for k in range(len(results))]
        for port, value in zip(results, values, strict=False):
            if port.limits is None:
                plan.op("mov", value, to=port.name)
            else:
                plan.op("fsat", value, *map(float, port.limits), to=port.name)
        plan.finish()
        return plan

    def layer(self, number: int, layer: Layer, block: _Block, last: bool) -> list[str]:
        """Append a layer; its results in registers, where it is the last one in one block."""
        plan = self.plan
        if block.count == 1:
            values = self.block(number, layer, block, ())
            if last:
                return values
            for r, value in enumerate(values):
                plan.store(value, f"layer{number + 1}", r)
            return []
        axis = f"block{number}"
        plan.op("iadd", 0, 0, to="row")
        with plan.loop(axis, block.count):
            for r, value in enumerate(self.block(number, layer, block, (axis,))):
                plan.store(value, f"layer{number + 1}", r, "row")
            plan.op("iadd", "row", block.rows, to="row")
        return []

    def block(self, number: int, layer: Layer, block: _Block, axes: tuple[str, ...]) -> list[str]:
        plan, unroll, source = self.plan, block.unroll, f"layer{number}"
        lanes = range(block.rows)
        sums = [[f"sum{r}_{s}" for s in range(block.sums)] for r in lanes]
        for r in lanes:
            bias = block.bias[:, r] if axes else block.bias[0, r]
            plan.op("fadd", Words(np.asarray(bias), axes), 0.0, to=sums[r][0])
            for name in sums[r][1:]:
                plan.op("fadd", 0.0, 0.0, to=name)
        column = f"column{number}"
        plan.op("iadd", 0, 0, to="at")
        for u in range(unroll):
            plan.load(source, u, "at", to=f"x{u}_in")
        with plan.loop(column, block.columns // unroll):
            for u in range(unroll):
                words = block.weights[:, u] if axes else block.weights[0, u]
                for r in lanes:
                    name = sums[r][u % block.sums]
                    word = Words(words[..., r], (*axes, column))
                    plan.op("fmadd", word, f"x{u}_in", name, to=name)
                plan.load(source, unroll + u, "at", to=f"x{u}_in")
            plan.op("iadd", "at", unroll, to="at")
        results = []
        for parts in sums:
            left = list(parts)
            while len(left) > 1:
                left = [*left[2:], plan.op("fadd", left[0], left[1])]
            results.append(left[0])
        if layer.activation is None:
            return results
        return [activate(plan, layer.activation, value) for value in results]


class _Block:
    """Rows of a block and their number; columns, a multiple of those in a round of the loop
    (`unroll`); sums of a row. weights: (blocks, unroll, rounds, rows); bias: (blocks, rows).
    """

    def __init__(self, layer: Layer, most: int, hidden: int) -> None:
        rows, columns = layer.shape
        self.count = -(-rows // most)
        self.rows = -(-rows // self.count)
        self.sums = 1
        while self.sums * self.rows < hidden:
            self.sums *= 2
        self.unroll = max(2, self.sums)
        rounds = -(-columns // self.unroll)
        self.columns = rounds * self.unroll
        whole = np.zeros((self.count * self.rows, self.columns))
        whole[:rows, :columns] = layer.weights
        parts = whole.reshape(self.count, self.rows, rounds, self.unroll)
        self.weights = parts.transpose(0, 3, 2, 1)
        bias = np.zeros(self.count * self.rows)
        bias[:rows] = layer.bias
        self.bias = bias.reshape(self.count, self.rows)


def activate(plan: Plan, function: Scalars, value: str) -> str:
    """Append a function of one number, as the compiler of scalar laws makes it."""
    real = Graph()
    nodes = read_function(function, real, [[real.add("input", value="x")]])
    real.outputs["y"] = nodes[0][0]
    graph = SumBuilder(expand_functions(simplify(real)), plan.machine, False).run()
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
