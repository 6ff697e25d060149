# SPDX-License-Identifier: Apache-2.0
"""Program of a network of dense layers in lanes: vectors of rows, weights from the streams.

A vector holds the sums of as many rows as a pipe has lanes. A loop over the columns loads a number
of the layer's input once and multiplies it with a column of a block of vectors, one vector of each
pipe a cycle. The functions of a block are computed in lanes too; then its numbers go to data memory
one by one, while the products of the first columns of what follows begin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asip_asm.machine import Machine
from asip_asm.model.lane_functions import LaneFunction, activate, core_graph
from asip_asm.model.law import Law, Port
from asip_asm.model.onnx_layers import Layer, Network
from asip_asm.model.plan import Plan
from asip_asm.model.plan_items import PIPES, Operand, Vectors
from asip_asm.model.read import ModelError

MOST = 8
"""Vectors of a block in a pipe: as many registers as a function of them all leaves."""
FEW = 4
"""Up to so many vectors of a layer both pipes have all of them, each for half of the columns."""
LOADS = 4
"""Columns of a round, or more: the index of the loads moves once a round."""


def lane_plan(law: Law, network: Network, machine: Machine) -> Plan:
    """The finished plan. Raises ModelError."""
    inputs = [port.name for port in law.of_kind("input")]
    outputs = {port.name: port.safe for port in law.of_kind("output")}
    plan = Plan(law.title, inputs, outputs, machine)
    _Maker(law, network, plan).make()
    plan.finish()
    return plan


@dataclass(frozen=True)
class _Block:
    """Vectors of a layer in blocks. count: blocks; width: vectors of a block in each pipe; parts:
    sums of a row in each pipe; split: whether a pipe has half of the columns; unroll: columns of a
    round. weights: (blocks, pipes, width, lanes, columns); bias: (blocks, pipes, width, lanes).
    """

    rows: int
    count: int
    width: int
    parts: int
    split: bool
    unroll: int
    weights: NDArray[np.float64]
    bias: NDArray[np.float64]

    @property
    def columns(self) -> int:
        return self.weights.shape[-1]

    @property
    def rounds(self) -> int:
        return self.columns // self.unroll

    @property
    def cycles(self) -> int:
        """Of the products of a round."""
        return self.unroll * self.width // (2 if self.split else 1)

    @property
    def stored(self) -> int:
        """Words of the results of all its vectors."""
        pipes, width, lanes = self.bias.shape[1:]
        return self.count * width * lanes * (1 if self.split else pipes)

    def sums(self, pipe: int, vector: int) -> list[str]:
        return [f"s{PIPES[pipe]}{vector}_{part}" for part in range(self.parts)]


def _blocks(layer: Layer, machine: Machine) -> _Block:
    rows, columns = layer.shape
    lanes, pipes = 1 + machine.build.lanes, len(PIPES)
    distance = machine.units["lanes"].ranks + 1
    vectors = -(-rows // lanes)
    split = vectors <= FEW
    share = vectors if split else -(-vectors // pipes)
    count = -(-share // MOST)
    width = -(-share // count)
    best = None
    for parts in range(1, 1 + distance):
        unroll = parts * (pipes if split else 1)
        unroll *= -(-LOADS // unroll)
        used = unroll // (parts * (pipes if split else 1)) * max(distance, parts * width)
        cost = -(-columns // unroll) * used + (parts - 1) * width
        if best is None or cost < best[0]:
            best = cost, parts, unroll
    assert best is not None
    _, parts, unroll = best
    padded = -(-columns // unroll) * unroll
    height = count * width * lanes * (1 if split else pipes)
    whole, first = np.zeros((height, padded)), np.zeros(height)
    whole[:rows, :columns], first[:rows] = layer.weights, layer.bias
    if split:
        weights = np.stack([whole.reshape(count, width, lanes, padded)] * pipes, axis=1)
        bias = np.stack([first.reshape(count, width, lanes), np.zeros((count, width, lanes))], 1)
    else:
        # Vector after vector goes to the pipes in turn: the first numbers are ready first.
        weights = whole.reshape(count, width, pipes, lanes, padded).transpose(0, 2, 1, 3, 4)
        bias = first.reshape(count, width, pipes, lanes).transpose(0, 2, 1, 3)
    return _Block(rows, count, width, parts, split, unroll, weights, bias)


class _Maker:
    def __init__(self, law: Law, network: Network, plan: Plan) -> None:
        self.law, self.network, self.plan = law, network, plan
        self.lanes = 1 + plan.machine.build.lanes
        self.blocks = [_blocks(layer, plan.machine) for layer in network.layers]
        self.functions = [
            None if layer.activation is None
            else LaneFunction(core_graph(layer.activation, plan.machine))
            for layer in network.layers
        ]  # fmt: skip

    def make(self) -> None:
        plan, network, blocks = self.plan, self.network, self.blocks
        ((_, ports),) = self.law.matched("argument", [network.argument])
        ((_, results),) = self.law.matched("result", [network.result])
        for number, block in enumerate(blocks):
            size = block.columns + block.unroll  # loads of the last round go beyond
            plan.spaces[f"layer{number}"] = max(size, blocks[number - 1].stored if number else 0)
        if blocks[-1].count > 1:
            plan.spaces[f"layer{len(blocks)}"] = blocks[-1].stored
        used, room = sum(plan.spaces.values()), plan.machine.data_words
        if used > room:
            raise ModelError(
                f"{self.law.title}: the numbers of all layers take {used} words of data memory, "
                f"the core has {room}; take fewer neurons"
            )
        plan.rewind()
        values: list[str] | None = [port.name for port in ports]
        for number in range(len(blocks)):
            values = self.layer(number, values)
        if values is None:
            values = [plan.load(f"layer{len(blocks)}", k) for k in range(len(results))]
        self.outputs(results, values)

    def outputs(self, results: Sequence[Port], values: Sequence[str]) -> None:
        for port, value in zip(results, values, strict=False):
            if port.limits is None:
                self.plan.op("mov", value, to=port.name)
            else:
                self.plan.op("fsat", value, *map(float, port.limits), to=port.name)

    def layer(self, number: int, values: list[str] | None) -> list[str] | None:
        """Append a layer whose input is in these registers, or in data memory; its results, None if
        they are in data memory.
        """
        plan, block = self.plan, self.blocks[number]
        if block.count == 1:
            self.begin(block, ())
            self.products(number, block, values, ())
            return self.results(number, block)
        for k, value in enumerate(values or ()):
            plan.store(value, f"layer{number}", k)
        axis, target = f"block{number}", f"layer{number + 1}"
        plan.op("iadd", 0, 0, to="row")
        with plan.loop(axis, block.count):
            self.begin(block, (axis,))
            self.products(number, block, None, (axis,))
            for r, value in enumerate(self.results(number, block)):
                plan.store(value, target, r, "row")
            plan.op("iadd", "row", block.stored // block.count, to="row")
        return None

    def begin(self, block: _Block, axes: tuple[str, ...]) -> None:
        """Sums of a block with the bias in them."""
        for vector in range(block.width):
            for pipe, pin in enumerate(PIPES):
                for part, name in enumerate(block.sums(pipe, vector)):
                    bias = block.bias[:, pipe, vector] * (part == 0)
                    words = Vectors(bias if axes else bias[0], axes)
                    self.plan.vector("vfmul", words, 1.0, pipe=pin, to=name)

    def products(
        self, number: int, block: _Block, values: list[str] | None, axes: tuple[str, ...]
    ) -> None:
        """Append the products of a block. The first rounds of numbers that are in registers take
        them from there; meanwhile the others go to data memory, from where the loop loads them.
        """
        plan, space, rounds = self.plan, f"layer{number}", block.rounds
        ahead = 0
        if values is not None:
            while ahead < rounds and len(values) - ahead * block.unroll > ahead * block.cycles:
                ahead += 1
            if rounds - ahead < 2:
                ahead = rounds
        first = ahead * block.unroll
        for k, value in enumerate(values or ()):
            if k >= first:
                plan.store(value, space, k)
        known: list[Operand] = [*(values or ())]
        known += [0.0] * (first - len(known))
        for k in range(ahead):
            here = slice(k * block.unroll, (k + 1) * block.unroll)
            self.round(block, known[here], block.weights[..., here], axes)
        if ahead == rounds:
            return
        for u in range(block.unroll):
            plan.load(space, first + u, to=f"in{u}")
        plan.op("iadd", 0, first, to="at")
        column = f"column{number}"
        rest = block.weights[..., first:]
        rest = rest.reshape(*rest.shape[:-1], rounds - ahead, block.unroll)
        with plan.loop(column, rounds - ahead):
            names = [f"in{u}" for u in range(block.unroll)]
            self.round(block, names, rest, (*axes, column))
            for u, name in enumerate(names):
                plan.load(space, u + block.unroll, "at", to=name)
            plan.op("iadd", "at", block.unroll, to="at")

    def round(
        self, block: _Block, values: Sequence[Operand], weights: np.ndarray, axes: tuple[str, ...]
    ) -> None:
        """Append the products of a round. weights: (blocks, pipes, width, lanes, ..., columns)."""
        for u, value in enumerate(values):
            step = u // len(PIPES) if block.split else u
            for vector in range(block.width):
                for pipe, pin in enumerate(PIPES):
                    if block.split and u % len(PIPES) != pipe:
                        continue
                    words = weights[:, pipe, vector, ..., u]  # (blocks, lanes, ...)
                    words = np.moveaxis(words, 1, -1)
                    if block.count == 1:
                        words = words[0]
                    name = block.sums(pipe, vector)[step % block.parts]
                    self.plan.vector("vfmadd", Vectors(words, axes), value, name, pipe=pin, to=name)

    def results(self, number: int, block: _Block) -> list[str]:
        """Append the sums of parts and the functions of a block; its numbers."""
        plan, function = self.plan, self.functions[number]
        ends: list[list[str]] = []
        for vector in range(block.width):
            ends.append([])
            for pipe, pin in enumerate(PIPES):
                left = list(block.sums(pipe, vector))
                while len(left) > 1:
                    made = plan.vector("vmadd", left[0], 1.0, left[1], pipe=pin)
                    left = [*left[2:], made]
                if function is not None and function.usable and not block.split:
                    left = [function.append(plan, pin, left[0])]
                ends[-1].append(left[0])
        values = []
        for vectors in ends:
            if block.split:
                for lane in range(self.lanes):
                    value: Operand = 0.0
                    for pin, vector_name in zip(PIPES, vectors, strict=True):
                        value = plan.vector("vout", value, vector_name, pipe=pin, lane=lane)
                    values.append(str(value))
                continue
            for pin, vector_name in zip(PIPES, vectors, strict=True):
                values += [
                    plan.vector("vout", 0.0, vector_name, pipe=pin, lane=lane)
                    for lane in range(self.lanes)
                ]
        activation = self.network.layers[number].activation
        if activation is not None and (block.split or not (function and function.usable)):
            values = [activate(plan, activation, value) for value in values[: block.rows]]
        return values if block.count > 1 else values[: block.rows]
