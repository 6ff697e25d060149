# SPDX-License-Identifier: Apache-2.0
"""Where a program runs: the Verilated core or the instruction-set model, behind one interface."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from asip_asm.image import Image
from asip_asm.profile import Trace as CoreTrace
from sim.asip_run.inputs import UserError
from sim.iss import Iss

COUNTERS = ("CYCLES", "STALL_OPERAND", "STALL_PORT", "STALL_UNIT", "STALL_FETCH", "DRAIN")
NO_FAULT = "NONE"


@dataclass(frozen=True)
class Fault:
    """Cause by name, the bundle it names (None: an output), and the output's index."""

    cause: str
    bundle: int | None = None
    output: int | None = None


@dataclass(frozen=True)
class Run:
    """Result of one run: fault, flags {nv, dz, of, uf, nx}, counters by name, words by name.

    writes: (register or output, word), on the core in the order of time, on the model by register.
    trace: issues and writes by clock cycle, of a traced run on the core.
    """

    fault: Fault
    flags: int
    counters: dict[str, int]
    words: dict[str, int]
    writes: list[tuple[str, int]]
    trace: CoreTrace | None = None


class RunLimit:
    """Bounds the watchdog of an image by --max-cycles, and says so where that stops a run."""

    def __init__(self, image: Image, cycles: int) -> None:
        self.own = image.watchdog
        self.cycles = cycles
        image.watchdog = min(image.watchdog, cycles)

    def note(self, result: Run) -> str:
        """What to add to the text of a fault."""
        if result.fault.cause != "WATCHDOG" or self.own <= self.cycles:
            return ""
        return (
            f"\n  stopped by --max-cycles {self.cycles}; the program's own watchdog is {self.own}"
        )


class Runner(Protocol):
    """A loaded program. `run` writes inputs (words by name), runs once and reads `names`."""

    def run(self, inputs: Mapping[str, int], names: Sequence[str]) -> Run: ...


def rtl_runner(image: Image, states: Mapping[str, int], trace: bool) -> Runner:
    """The program on the Verilated core, which is built on first use."""
    # Verilator is needed here only, not by the instruction-set model.
    from sim.harness.asip_rtl import BLOCK, CSR, STATUS, AsipError, AsipRtl, register_address
    from sim.harness.build import BuildError

    try:
        core = AsipRtl(image.configuration)
    except BuildError as error:
        raise UserError(str(error)) from None
    core.load(image)
    core.preset(states)
    outputs = {output.name: output.index for output in image.outputs}
    places = {entry.name: entry.register for entry in (*image.exports, *image.states)}

    constants = {f"k{entry.index}": int(entry.bits, 16) for entry in image.constants}
    input_names = {f"k{entry.index}": entry.name for entry in image.inputs}

    def read(name: str, inputs: Mapping[str, int]) -> int:
        if name in outputs:
            return core.read(BLOCK["outputs"] + outputs[name])
        register = places.get(name, name)
        if register in input_names:  # the host cannot read bank K
            return inputs[input_names[register]]
        if register in constants:
            return constants[register]
        return core.read(register_address(register))

    class RtlRunner:
        def run(self, inputs: Mapping[str, int], names: Sequence[str]) -> Run:
            for name, address in zip(inputs, core.input_addresses(list(inputs)), strict=True):
                core.write(address, inputs[name])
            core.trace(trace)
            core.clear()
            try:
                result = core.run([], np.zeros((1, 0), dtype=np.uint32), [])
            except AsipError as error:
                raise UserError(str(error)) from None
            counters = {name: core.read(CSR[name]) for name in COUNTERS}
            info = core.read(CSR["FAULT_INFO"])
            if result.fault == NO_FAULT:
                fault = Fault(NO_FAULT)
            elif result.fault == "NOT_FINITE":
                fault = Fault(result.fault, output=info)
            else:
                fault = Fault(result.fault, bundle=info)
            return Run(
                fault=fault,
                flags=STATUS["flags"].of(int(result.status[-1])),
                counters=counters,
                words={name: read(name, inputs) for name in names},
                writes=[(f"{b.lower()}{i}", word) for b, i, word in core.traced_writes()],
                trace=CoreTrace(core.traced_issues(), core.timed_writes(), counters)
                if trace
                else None,
            )

    return RtlRunner()


def iss_runner(image: Image, states: Mapping[str, int], trace: bool) -> Runner:
    """The program on the instruction-set model."""
    model = Iss(image, trace=trace)
    types = {entry.name: entry.type for entry in (*image.inputs, *image.states)}

    def values(words: Mapping[str, int]) -> dict[str, float]:
        return {name: number(word, types[name]) for name, word in words.items()}

    model.set_state(values(states))

    class IssRunner:
        def run(self, inputs: Mapping[str, int], names: Sequence[str]) -> Run:
            model.set_inputs(values(inputs))
            result = model.run()
            return Run(
                fault=Fault(result.fault.name, bundle=result.fault_bundle),
                flags=result.flags,
                counters={"BUNDLES": result.bundles},
                words={
                    name: result.output_bits[name]
                    if name in result.output_bits
                    else model.read_bits(name)
                    for name in names
                },
                writes=[(name, word) for name, words in result.writes.items() for word in words],
            )

    return IssRunner()


def number(word: int, type_name: str) -> float | int:
    """Value of a word."""
    data = word.to_bytes(4, "big")
    if type_name == "int":
        return int.from_bytes(data, "big", signed=True)
    return struct.unpack(">f", data)[0]
