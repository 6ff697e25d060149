# SPDX-License-Identifier: Apache-2.0
"""The ASIP's RTL as a Python object: Verilated model, bus, program loading, control ticks."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asip_asm.image import Image
from asip_asm.isa import default_isa
from sim.rtl.asip_bus import (
    BLOCK,
    CLEAR,
    CSR,
    FAULT_NAMES,
    START,
    STATUS,
    AsipError,
    load_words,
    register_address,
    run_words,
)
from sim.rtl.build import build_library, file_list
from sim.rtl.verilated import Verilated

HARNESS = Path(__file__).with_name("asip_harness.cpp")


@dataclass(frozen=True)
class TickResult:
    """Runs of consecutive ticks: what was read (ticks, reads), STATUS and CYCLES of each."""

    words: np.ndarray
    status: np.ndarray
    cycles: np.ndarray

    @property
    def fault(self) -> str:
        """Fault of the last tick, 'NONE' without one."""
        return FAULT_NAMES[STATUS["cause"].of(int(self.status[-1]))]


class TickPort:
    """Runs of so many ticks: fill `data`, call `run`, read `words`, `status` and `cycles`.

    data (ticks, writes), words (ticks, reads), status and cycles (ticks,), all uint32. Invalid
    after the core is closed.
    """

    def __init__(
        self,
        lib: ctypes.CDLL,
        model: int,
        write_address: Sequence[int],
        read_address: Sequence[int],
        ticks: int,
    ) -> None:
        self._lib = lib
        self._addresses = [np.asarray(a, dtype=np.uint32) for a in (write_address, read_address)]
        writes, reads = self._addresses
        self.data = np.zeros((ticks, len(writes)), dtype=np.uint32)
        self.words = np.zeros((ticks, len(reads)), dtype=np.uint32)
        status_cycles = np.zeros((ticks, 2), dtype=np.uint32)
        self.status, self.cycles = status_cycles.T
        self._arguments = (
            model,
            ticks,
            writes.ctypes.data,
            len(writes),
            self.data.ctypes.data,
            reads.ctypes.data,
            len(reads),
            self.words.ctypes.data,
            status_cycles.ctypes.data,
            CSR["CONTROL"],
            CSR["STATUS"],
            CSR["CYCLES"],
            STATUS["fault"].mask,
            CLEAR,
            START,
        )

    def run(self) -> int:
        """Run the ticks; returns how many, fewer if one faulted. Raises AsipError."""
        done = int(self._lib.asip_run(*self._arguments))
        if done < 0:
            raise AsipError("the core neither finished nor faulted")
        return done


class AsipRtl(Verilated):
    """One instance of the Verilated core in one of the configurations.

    The model is built on first use. All data are raw 32-bit words; floats go through numpy views.
    """

    prefix = "asip"
    top = "asip"
    files = ("asip/asip.f",)
    headers: tuple[Path, ...] = ()
    harness_flags: tuple[str, ...] = ()

    def __init__(self, configuration: str = "fast") -> None:
        shape = default_isa().configurations[configuration]
        integer, u32, pointer = ctypes.c_int, ctypes.c_uint32, ctypes.c_void_p
        pointers_and_lengths = (pointer, u32, pointer, pointer, u32, pointer, pointer)
        signatures = {
            "reset": (None,),
            "irq": (integer,),
            "cycles": (ctypes.c_uint64,),
            "write": (integer, u32, u32),
            "read": (integer, u32, pointer),
            "clock": (None, u32),
            "issued": (None, pointer, u32),
            "trace": (None, integer),
            "trace_issues": (u32, pointer, u32),
            "trace_writes": (u32, pointer, u32),
            "run": (ctypes.c_int64, u32, *pointers_and_lengths, *[u32] * 6),
        }
        library = self._library(shape.parameters)
        super().__init__(library, signatures)
        self.configuration = configuration

    def _library(self, parameters: Mapping[str, int]) -> Path:
        """The model with these parameters of its top."""
        return build_library(
            self.top,
            [path for name in self.files for path in file_list(name)],
            HARNESS,
            parameters,
            headers=self.headers,
            harness_flags=self.harness_flags,
        )

    @property
    def _model(self) -> int:
        """Handle of the model. Raises AsipError after `close`."""
        if self._handle is None:
            raise AsipError("the core is closed; make another one")
        return self._handle

    # ------------------------------------------------------------------ bus
    def write(self, address: int, data: int) -> None:
        """One bus write; waits while the core holds it."""
        if not self._call("write", address, data & 0xFFFFFFFF):
            raise AsipError(f"bus write to {address:#06x} was never accepted")

    def read(self, address: int) -> int:
        """One bus read."""
        word = self._word("read", address)
        if word is None:
            raise AsipError(f"bus read of {address:#06x} was never answered")
        return word

    def clock(self, cycles: int = 1) -> None:
        """Let time pass without bus traffic."""
        self._call("clock", cycles)

    def reset(self) -> None:
        """Assert reset for four cycles; memories keep their contents."""
        self._call("reset")

    @property
    def irq(self) -> bool:
        """Level of the interrupt line."""
        return bool(self._call("irq"))

    @property
    def cycles(self) -> int:
        """Clock cycles simulated since the model was made."""
        return int(self._call("cycles"))

    # ------------------------------------------------------------------ traces
    def issued(self, bundles: int) -> np.ndarray:
        """Bundles issued so far per program address."""
        counts = np.zeros(bundles, dtype=np.uint64)
        self._call("issued", counts.ctypes.data, bundles)
        return counts

    def trace(self, on: bool = True) -> None:
        """Start (and empty) or stop the trace of issues and of register and output writes."""
        self._call("trace", int(on))

    def traced_issues(self) -> list[tuple[int, int]]:
        """Bundles issued since `trace` in order: (cycle since `trace`, program address)."""
        return [(c, a) for c, a in self._events("trace_issues", np.uint32, 2).tolist()]

    def traced_writes(self) -> list[tuple[str, int, int]]:
        """Writes since `trace` in order: (bank 'A', 'B', 'C' or 'O' for outputs, index, word)."""
        return [write[1:] for write in self.timed_writes()]

    def timed_writes(self) -> list[tuple[int, str, int, int]]:
        """Writes since `trace` in order: (cycle since `trace`, bank, index, word)."""
        events = self._events("trace_writes", np.uint32, 4).tolist()
        return [(cycle, "ABCO"[bank], index, word) for cycle, bank, index, word in events]

    # ------------------------------------------------------------------ programs
    def load(self, image: Image) -> None:
        """Load a program image as a driver would; states get their initial values.

        Raises ImageError for an image that no assembler writes.
        """
        image.check()
        if image.configuration != self.configuration:
            raise AsipError(
                f"image is for configuration '{image.configuration}', "
                f"the core is '{self.configuration}'"
            )
        self.clear()
        for address, word in load_words(image):
            self.write(address, word)
        self.image = image

    def select(self, image: Image) -> None:
        """Go on with another function of the image loaded (`Image.function`), by its names."""
        for address, word in run_words(image):
            self.write(address, word)
        self.image = image

    def clear(self) -> None:
        """Clear done and fault: after a fault the core starts no run before that."""
        self.write(CSR["CONTROL"], CLEAR)

    def preset(self, words: Mapping[str, int]) -> None:
        """Write states by name (raw words) before the first tick."""
        places = {state.name: state.register for state in self.image.states}
        for name, word in words.items():
            self.write(register_address(places[name]), word)

    def run(
        self, write_address: Sequence[int], data: np.ndarray, read_address: Sequence[int]
    ) -> TickResult:
        """Run data.shape[0] ticks: write data[t] to the addresses, start, wait, read the addresses.

        data: (ticks, len(write_address)) of 32-bit items. Stops early after a faulted tick.
        """
        data = np.ascontiguousarray(data).view(np.uint32)
        port = self.port(write_address, read_address, data.shape[0])
        port.data[:] = data
        done = port.run()
        return TickResult(port.words[:done], port.status[:done], port.cycles[:done])

    def port(
        self, write_address: Sequence[int], read_address: Sequence[int], ticks: int = 1
    ) -> TickPort:
        """For many calls with the same addresses, without making arrays each time."""
        return TickPort(self._lib, self._model, write_address, read_address, ticks)

    # ------------------------------------------------------------------ addresses by name
    def input_addresses(self, names: Sequence[str]) -> list[int]:
        """Bus addresses of inputs."""
        places = {word.name: word.index for word in self.image.inputs}
        return [BLOCK["constants"] + places[name] for name in names]

    def output_addresses(self, names: Sequence[str]) -> list[int]:
        """Bus addresses of outputs."""
        places = {word.name: word.index for word in self.image.outputs}
        return [BLOCK["outputs"] + places[name] for name in names]

    def export_addresses(self, names: Sequence[str]) -> list[int]:
        """Bus addresses of exported registers (banks A, B, C)."""
        places = {word.name: word.register for word in self.image.exports}
        return [register_address(places[name]) for name in names]
