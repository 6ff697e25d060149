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
from asip_asm.model.lane_functions import activate
from asip_asm.model.law import Law
from asip_asm.model.onnx_file import OnnxPolicy
from asip_asm.model.onnx_layers import Layer, Network, dense_layers
from asip_asm.model.options import SINES, Compiled, Options, compiled
from asip_asm.model.plan import Plan
from asip_asm.model.plan_items import Words
from asip_asm.model.read import ModelError

BLOCKS = (32, 16)
"""Rows of a block, of which the shortest program that fits is taken."""


ROOM, SPARE = 0.96, 20
"""Share of the program memory that a plan may take; bundles of a layer with gaps."""


def compile_network(law: Law, options: Options, machine: Machine) -> Compiled:
    """The program with the largest blocks that fit. Raises ModelError."""
    assert isinstance(law.function, OnnxPolicy)
    network = dense_layers(law.function)
    assert isinstance(network, Network)
    if options.reassociate or options.reciprocal or options.sine != SINES[0]:
        raise ModelError(
            f"{law.title}: a network on streams has no other sums, quotients or sines; leave out "
            "--reassociate, --reciprocal and --sine, or take --config fast"
        )
    check_ports(law)
    if machine.build.lanes:
        from asip_asm.model.lane_program import lane_plan

        return compiled(lane_plan(law, network, machine), law)
    return compiled(network_plan(law, network, machine), law)


def check_ports(law: Law) -> None:
    """Raises ModelError unless the signals are inputs and outputs of floats."""
    odd = [p for p in law.ports if p.kind not in ("input", "output") or p.type != "float"]
    if odd:
        raise ModelError(
            f"{law.title}: '{odd[0].name}' is a {odd[0].kind} of type {odd[0].type}; a network "
            "on streams has inputs and outputs of floats alone: take --config fast"
        )


def network_plan(law: Law, network: Network, machine: Machine) -> Plan:
    """The finished plan, its first layers in the largest blocks that fit. Raises ModelError."""
    rows = [BLOCKS[-1]] * len(network.layers)
    for number in range(len(rows)):
        for most in BLOCKS:
            tried = [*rows[:number], most, *rows[number + 1 :]]
            if (
                _Maker(law, network, machine, tried).bundles()
                <= ROOM * default_isa().program_bundles
            ):
                rows = tried
                break
    return _Maker(law, network, machine, rows).make()


class _Maker:
    def __init__(self, law: Law, network: Network, machine: Machine, rows: Sequence[int]) -> None:
        self.law, self.network = law, network
        inputs = [port.name for port in law.of_kind("input")]
        outputs = {port.name: port.safe for port in law.of_kind("output")}
        self.plan = Plan(law.title, inputs, outputs, machine)
        # Issue distance of dependent multiply-adds, in rows of both pipes.
        hidden = 2 * (machine.units["fma"].ranks + 1)
        self.blocks = [
            _Block(layer, most, hidden) for layer, most in zip(network.layers, rows, strict=True)
        ]

    def bundles(self) -> int:
        """Bundles of the program, about: products of a round, bias and functions of each block."""
        count = 0.0
        for layer, block in zip(self.network.layers, self.blocks, strict=True):
            function = Plan("", ["x"], {}, self.plan.machine)
            if layer.activation is not None:
                activate(function, layer.activation, "x")
            work = 2 * function.bundles() if function.items else 1
            count += block.rows * (block.unroll + work + 1) / 2 + SPARE
        return int(count) + len(self.law.of_kind("input")) + len(self.law.of_kind("output"))

    def make(self) -> Plan:
        plan, network = self.plan, self.network
        ((_, ports),) = self.law.matched("argument", [network.argument])
        ((_, results),) = self.law.matched("result", [network.result])
        layers = network.layers
        blocks = self.blocks
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
            raise ModelError(
                f"{self.law.title}: the numbers of all layers take {used} words of data memory, "
                f"the core has {room}; take fewer neurons"
            )
        for k, port in enumerate(ports):
            plan.store(port.name, "layer0", k)
        plan.rewind()
        self.begin(blocks[0], blocks[0].bias[0], ())
        values: list[str] = []
        for number, (layer, block) in enumerate(zip(layers, blocks, strict=True)):
            self.columns_from(number, block)
            values = self.layer(number, layer, blocks)
        if blocks[-1].count > 1:
            values = [plan.load(f"layer{len(layers)}", k) for k in range(len(results))]
        for port, value in zip(results, values, strict=False):
            if port.limits is None:
                plan.op("mov", value, to=port.name)
            else:
                plan.op("fsat", value, *map(float, port.limits), to=port.name)
        plan.finish()
        return plan

    def begin(self, block: _Block, bias: np.ndarray, axes: tuple[str, ...]) -> None:
        """Sums of a block with the bias (..., rows) in them."""
        for r, names in enumerate(block.names):
            self.plan.op("fadd", Words(bias[..., r], axes), 0.0, to=names[0])
            for name in names[1:]:
                self.plan.op("fadd", 0.0, 0.0, to=name)

    def columns_from(self, number: int, block: _Block) -> None:
        """The first numbers of a layer's input."""
        self.plan.op("iadd", 0, 0, to="at")
        for u in range(block.unroll):
            self.plan.load(f"layer{number}", u, "at", to=f"in{u}")

    def layer(self, number: int, layer: Layer, blocks: Sequence[_Block]) -> list[str]:
        """Append a layer whose first sums have begun; its results, if they are in registers. With
        the functions of a block the sums of the next one begin, which fills the pipes.
        """
        plan, block = self.plan, blocks[number]
        after = blocks[number + 1] if number + 1 < len(blocks) else None
        target = f"layer{number + 1}"
        if block.count == 1:
            values = self.block(number, layer, block, ())
            for r, value in enumerate(values if after else ()):
                plan.store(value, target, r)
            if after:
                self.begin(after, after.bias[0], ())
            return values
        follows = after is not None and after.names == block.names
        bias = np.roll(block.bias, -1, axis=0)
        bias[-1] = after.bias[0] if after is not None and follows else 0.0
        axis = f"block{number}"
        plan.op("iadd", 0, 0, to="row")
        with plan.loop(axis, block.count):
            for r, value in enumerate(self.block(number, layer, block, (axis,))):
                plan.store(value, target, r, "row")
            self.begin(block, bias, (axis,))
            plan.op("iadd", "row", block.rows, to="row")
            self.columns_from(number, block)
        if after is not None and not follows:
            self.begin(after, after.bias[0], ())
        return []

    def block(self, number: int, layer: Layer, block: _Block, axes: tuple[str, ...]) -> list[str]:
        """Append the products and functions of a block; its results."""
        plan, unroll, column = self.plan, block.unroll, f"column{number}"
        with plan.loop(column, block.columns // unroll):
            for u in range(unroll):
                words = block.weights[:, u] if axes else block.weights[0, u]
                for r, names in enumerate(block.names):
                    name = names[u % len(names)]
                    word = Words(words[..., r], (*axes, column))
                    plan.op("fmadd", word, f"in{u}", name, to=name)
                # The index moves after the first load: the last load ends the round.
                plan.load(f"layer{number}", u if u else unroll, "at", to=f"in{u}")
                if u == 0:
                    plan.op("iadd", "at", unroll, to="at")
        results = []
        for names in block.names:
            left = list(names)
            while len(left) > 1:
                left = [*left[2:], plan.op("fadd", left[0], left[1])]
            results.append(left[0])
        if layer.activation is None:
            return results
        return [activate(plan, layer.activation, value) for value in results]


class _Block:
    """Rows of a block and their number; columns, a multiple of those in a round of the loop
    (`unroll`); names of the sums of each row. weights: (blocks, unroll, rounds,
    rows); bias: (blocks, rows).
    """

    def __init__(self, layer: Layer, most: int, hidden: int) -> None:
        rows, columns = layer.shape
        self.count = -(-rows // most)
        self.rows = -(-rows // self.count)
        sums = 1
        while sums * self.rows < hidden:
            sums *= 2
        self.names = [[f"sum{r}_{s}" for s in range(sums)] for r in range(self.rows)]
        self.unroll = max(2, sums)
        rounds = -(-columns // self.unroll)
        self.columns = rounds * self.unroll
        whole = np.zeros((self.count * self.rows, self.columns))
        whole[:rows, :columns] = layer.weights
        parts = whole.reshape(self.count, self.rows, rounds, self.unroll)
        self.weights = parts.transpose(0, 3, 2, 1)
        bias = np.zeros(self.count * self.rows)
        bias[:rows] = layer.bias
        self.bias = bias.reshape(self.count, self.rows)
