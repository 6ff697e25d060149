# SPDX-License-Identifier: Apache-2.0
"""Programs for the scheduler's tests: random graphs and a loop."""

from __future__ import annotations

import random

from asip_asm.allocate import allocate_registers
from asip_asm.ir import (
    ZERO,
    Export,
    Operation,
    Output,
    OutputWord,
    Program,
    Region,
    Register,
    State,
    Virtual,
)
from asip_asm.machine import Machine
from asip_asm.schedule import DEFAULT_EFFORT, bundle_in_order, schedule_program

BINARY_AUX = ("feq", "flt", "fmin", "fmax", "iadd", "isub", "fdiv")
UNARY_AUX = ("fabs", "fneg", "mov", "fsgn", "i2f", "f2i", "fsqrt")


class Builder:
    """Collects operations of one region in single-assignment form; methods return the written
    value.
    """

    def __init__(self, configuration: str = "fast") -> None:
        self.program = Program(configuration=configuration)
        self.region = Region(halt=True)
        self.program.regions.append(self.region)
        self.names = 0
        self.words = 0

    def input(self) -> Register:
        self.words += 1
        return Register("K", (self.words - 1) % 128)

    def emit(self, mnemonic: str, dst=None, *values, **fields) -> Operation:
        layout = {"fadd": "ac", "fsub": "ac"}.get(mnemonic, "abc")
        op = Operation(mnemonic, dst, **dict(zip(layout, values, strict=False)), **fields)
        self.region.operations.append(op)
        return op

    def op(self, mnemonic: str, *values, name: str | None = None, version: int = 1, **fields):
        if name is None:
            self.names += 1
            name = f"v{self.names}"
        dst = Virtual(name, version)
        self.emit(mnemonic, dst, *values, **fields)
        return dst

    def output(self, mnemonic: str, *values) -> None:
        index = len(self.program.outputs)
        self.program.outputs.append(OutputWord(f"o{index}", index, 0))
        self.emit(mnemonic, Output(index), *values)

    def state(self, name: str, pin: str | None = None) -> Virtual:
        first = Virtual(name, 0)
        self.program.states.append(State(name, "float", 0, first, pin=pin))
        return first

    def write_state(self, name: str, mnemonic: str, *values) -> Virtual:
        state = next(s for s in self.program.states if s.name == name)
        state.last = self.op(mnemonic, *values, name=name, version=1)
        return state.last

    def export(self, value: Virtual) -> None:
        self.program.exports.append(Export(value.name, value))


def random_program(seed: int, size: int, configuration: str = "fast") -> Program:
    """Random operations with outputs, states (one pinned), exports, loads, stores and shared
    symbols.
    """
    rng = random.Random(seed)
    build = Builder(configuration)
    values = [build.input() for _ in range(6)] + [ZERO]
    states = [build.state(f"s{i}", pin="A" if i == 0 else None) for i in range(rng.randrange(1, 4))]
    values += states
    build.program.data = [0] * 8

    def pick():
        window = values[-12:] if rng.random() < 0.7 else values
        return rng.choice(window)

    outputs = 0
    for _ in range(size):
        kind = rng.random()
        if kind < 0.55:
            mnemonic = rng.choice(("fmadd", "fmsub", "fnmsub", "fmul", "fadd", "fsub"))
            count = 3 if mnemonic.startswith(("fma", "fms", "fnms")) else 2
            values.append(build.op(mnemonic, *(pick() for _ in range(count))))
        elif kind < 0.72:
            values.append(build.op(rng.choice(BINARY_AUX), pick(), pick()))
        elif kind < 0.82:
            values.append(build.op(rng.choice(UNARY_AUX), pick()))
        elif kind < 0.84:
            values.append(build.op(rng.choice(("fsin", "fcos")), pick()))
        elif kind < 0.88:
            index = pick() if rng.random() < 0.2 else ZERO
            build.emit("st", None, pick(), index, imm=rng.randrange(8))
        elif kind < 0.92:
            index = pick() if rng.random() < 0.2 else ZERO
            values.append(build.op("ld", ZERO, index, imm=rng.randrange(8)))
        elif kind < 0.96:
            name = rng.choice(("p", "q"))
            mnemonic = "fmul" if name == "p" else "mov"
            symbol = build.op(mnemonic, pick(), pick(), name=name, version=-1)
            values.append(symbol)
        elif outputs < 20:
            outputs += 1
            build.output("fsat", pick(), pick(), pick())
    for position, state in enumerate(states):
        if rng.random() < 0.8 or state.name == "s0":
            mnemonic = "fadd" if position == 0 else rng.choice(("fadd", "mov", "fdiv"))
            operands = rng.choice(values), rng.choice(values)
            # From here on the name means the new value.
            values = [v for v in values if v != state]
            values.append(build.write_state(state.name, mnemonic, *operands))
    exportable = [v for v in values if isinstance(v, Virtual) and v.name.startswith("v")]
    for value in rng.sample(exportable, min(3, len(exportable))):
        build.export(value)
    return build.program


def loop_program():
    """Counts down in a loop, chooses one of two paths, and uses values from before both."""
    k0, k1 = Register("K", 0), Register("K", 1)
    build = Builder()
    before = build.op("fmul", k0, k1)
    build.op("mov", k0, name="n", version=-1)
    n, r = Virtual("n", -1), Virtual("r", -1)
    loop = Region(labels=["loop"])
    loop.operations += [
        Operation("fdiv", Virtual("t", 1), n, before),
        Operation("isub", n, n, k1),
        Operation("mov", r, Virtual("t", 1)),
        Operation("bnz", None, n, target="loop"),
    ]
    path = Region(
        operations=[
            Operation("mov", r, before),
            Operation("st", None, r, imm=0),
            Operation("bz", None, r, target="end"),
        ]
    )
    other = Region(operations=[Operation("fneg", r, n)])
    end = Region(labels=["end"], halt=True)
    end.operations += [
        Operation("ld", Virtual("w", 1), imm=0),
        Operation("fsat", Output(0), r, before, Virtual("w", 1)),
        Operation("fadd", Virtual("s", 1), Virtual("s", 0), r),
    ]
    program = build.program
    program.data = [0]
    program.states = [State("s", "float", 0, Virtual("s", 0), Virtual("s", 1))]
    build.region.halt = False
    program.regions += [loop, path, other, end]
    return program


def arrange(
    program: Program, machine: Machine, in_order: bool = False, effort: int = DEFAULT_EFFORT
) -> None:
    """Bundles by the scheduler, or in the order written, and registers for all values."""
    if in_order:
        bundle_in_order(program, machine)
    else:
        schedule_program(program, machine, effort)
    allocate_registers(program, machine)
