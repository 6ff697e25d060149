# SPDX-License-Identifier: Apache-2.0
"""Driver and monitor of module `asip`: programs, ticks, faults and the Avalon-MM port."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import cocotb
import numpy as np
from cocotb.triggers import First, RisingEdge, Timer

from asip_asm.assemble import assemble
from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.image import Image
from asip_asm.isa import default_isa
from sim.cocotb.agent import Agent, AgentPins
from sim.cocotb.clocked import Bus, Pin, word
from sim.core.backends import number, readable_places, unknown
from sim.rtl.asip_bus import (
    BLOCK,
    CLEAR,
    CSR,
    FAULT_NAMES,
    START,
    STATUS,
    load_words,
    place_address,
    register_address,
)

RUN_LIMIT = 20_000  # clocks of one run


@dataclass(frozen=True)
class Tick:
    """One run: outputs as numbers and as bits, CYCLES, IEEE exceptions, the fault and FAULT_INFO,
    which is 0 without a fault."""

    outputs: dict[str, float]
    words: dict[str, int]
    cycles: int
    flags: int
    fault: str
    fault_info: int


class AsipPins(AgentPins, Protocol):
    """Pins of `asip`."""

    irq_o: Pin
    trace_issue_o: Pin
    trace_pc_o: Bus
    trace_write_o: Bus
    trace_index_o: Bus
    trace_data_o: Bus


class Asip(Agent):
    """The core at its host port. `pause` is the probability of an idle clock before an access.

    The unused hooks of the debug block are tied to 0.
    """

    dut: AsipPins

    def __init__(
        self, dut: AsipPins, period: int = 8000, seed: int = 1, pause: float = 0.0
    ) -> None:
        super().__init__(dut, REGMAP, period, seed, pause, quiet=("hook_i",))
        self.image: Image | None = None

    # ------------------------------------------------------------------ bus
    async def register(self, name: str, index: int = 0) -> int:
        """Read a register of the map by its name, or 'a3', 'c12' of the banks."""
        if name in CSR:
            return await super().register(name, index)
        return await self.read(register_address(name))

    # ------------------------------------------------------------------ programs
    async def configuration(self) -> str:
        """Name of the core's configuration, from its register CONFIG."""
        fields, config = REGMAP.registers["CONFIG"].fields, await self.read(CSR["CONFIG"])
        shape = fields["slots"].of(config), fields["fma_pipes"].of(config)
        for name in default_isa().without_streams:
            known = default_isa().configurations[name]
            if shape == (len(known.slots), known.fma_pipes):
                return name
        raise AssertionError(f"CONFIG is {config:#010x}: no configuration of the assembler")

    async def load(self, program: Path | str | Image, **options: Any) -> Image:
        """Assemble a program for this core, or take an image, and load it. `options` are those of
        `assemble`. A fault is cleared before.
        """
        if isinstance(program, Image):
            image = program
        else:
            options.setdefault("configuration", await self.configuration())
            image = assemble(Path(program), **options)
        await self.write(CSR["CONTROL"], CLEAR)
        for address, data in load_words(image):
            await self.write(address, data)
        self.image = image
        self._inputs = {entry.name: entry for entry in image.inputs}
        places = readable_places(image)
        self._readable = {name: place_address(place) for name, place in places.items()}
        return image

    async def preset(self, values: Mapping[str, float]) -> None:
        """Set states by name. Raises ValueError for an unknown name."""
        states = {state.name: state for state in self._loaded().states}
        for name, value in values.items():
            if name not in states:
                raise ValueError(unknown("state", name, states))
            state = states[name]
            await self.write(register_address(state.register), bits(value, state.type))

    async def bits_of(self, name: str) -> int:
        """Word of an output, a state or an export of the program by name."""
        self._loaded()
        if name not in self._readable:
            raise ValueError(unknown("value", name, self._readable))
        return await self.read(self._readable[name])

    async def value(self, name: str) -> float | int:
        """The same as a number; exports are taken as floats."""
        kinds = {state.name: state.type for state in self._loaded().states}
        return number(await self.bits_of(name), kinds.get(name, "float"))

    # ------------------------------------------------------------------ runs
    async def set(self, **inputs: float) -> None:
        """Write inputs by name; the others keep their values."""
        self._loaded()
        for name, value in inputs.items():
            if name not in self._inputs:
                raise ValueError(unknown("input", name, self._inputs))
            entry = self._inputs[name]
            await self.write(BLOCK["constants"] + entry.index, bits(value, entry.type))

    async def start(self) -> None:
        """Start a run; clears `done` of the last one, and a fault."""
        await self.write(CSR["CONTROL"], CLEAR)
        await self.write(CSR["CONTROL"], START)

    async def wait(self) -> None:
        """Wait for the interrupt at the end of a run."""
        if not word(self.dut.irq_o):
            limit = Timer(RUN_LIMIT * self.period, unit="ps")
            await First(RisingEdge(self.dut.irq_o), limit)
        await self.next()
        assert word(self.dut.irq_o), f"the run did not end in {RUN_LIMIT} clocks"

    async def result(self) -> Tick:
        """What the last run left."""
        status, outputs = await self.read(CSR["STATUS"]), self._loaded().outputs
        words = {out.name: await self.read(BLOCK["outputs"] + out.index) for out in outputs}
        fault = FAULT_NAMES[STATUS["cause"].of(status)]
        # FAULT_INFO has no value before the first fault.
        info = await self.read(CSR["FAULT_INFO"]) if STATUS["fault"].of(status) else 0
        return Tick(
            outputs={name: float(number(data, "float")) for name, data in words.items()},
            words=words,
            cycles=await self.read(CSR["CYCLES"]),
            flags=STATUS["flags"].of(status),
            fault=fault,
            fault_info=info,
        )

    async def tick(self, **inputs: float) -> Tick:
        """Write inputs, run the program once, read its outputs. A fault is no exception here."""
        await self.set(**inputs)
        await self.start()
        await self.wait()
        return await self.result()

    def _loaded(self) -> Image:
        if self.image is None:
            raise ValueError("no program is loaded; await load(program) first")
        return self.image


def bits(value: float, kind: str) -> int:
    """32 bits of a number as an input of that type."""
    if kind == "int":
        if not -(1 << 31) <= value < 1 << 32 or value != int(value):
            raise ValueError(f"{value} is no integer of 32 bits")
        return int(value) & 0xFFFFFFFF
    with np.errstate(over="ignore"):
        return int(np.float32(value).view(np.uint32))


@dataclass
class AsipMonitor:
    """Watches a core from `start` on: bundles issued and words written, each with its clock.

    Every clock it checks that no control output is X and that no write is reported in reset.
    """

    core: Asip
    issued: list[tuple[int, int]] = field(default_factory=list)  # clock, bundle
    written: list[tuple[int, str, int]] = field(default_factory=list)  # clock, register, word
    clock: int = 0

    def start(self) -> None:
        """Watch until the test ends."""
        cocotb.start_soon(self._watch())

    async def _watch(self) -> None:
        dut = self.core.dut
        while True:
            await self.core.next()
            await self.core.settle()
            self.clock += 1
            for pin in (dut.waitrequest_o, dut.irq_o, dut.trace_issue_o, dut.trace_write_o):
                word(pin)
            if word(dut.trace_issue_o):
                self.issued.append((self.clock, word(dut.trace_pc_o)))
            write = word(dut.trace_write_o)
            if not write:
                continue
            index, data = packed(dut.trace_index_o), packed(dut.trace_data_o)
            for lane, bank in enumerate("abc"):
                if write >> lane & 1:
                    at, what = index >> 6 * lane & 63, data >> 32 * lane & 0xFFFFFFFF
                    self.written.append((self.clock, f"{bank}{at}", what))
            if write >> 3 & 1:
                self.written.append((self.clock, f"o{index >> 12 & 31}", data >> 64 & 0xFFFFFFFF))


def packed(handle: Bus) -> int:
    """Value of several words in one port; X, in words that are not written now, is taken as 0."""
    return int("".join(c if c in "01" else "0" for c in str(handle.value)), 2)
