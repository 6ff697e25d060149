# SPDX-License-Identifier: Apache-2.0
"""Where a `Core` runs: the Verilated RTL or the instruction-set model, with one interface."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from asip_asm.diagnostics import closest
from asip_asm.image import Image
from asip_asm.isa import default_isa
from asip_asm.profile import Trace
from sim.core.fault import NO_FAULT, Fault, fault_text
from sim.rtl.asip_bus import BLOCK, CSR, STATUS, register_address

FLAGS = STATUS["flags"]
FLAG_NAMES = ("nv", "dz", "of", "uf", "nx")  # bit 4 .. 0
COUNTERS = ("CYCLES", "STALL_OPERAND", "STALL_PORT", "STALL_UNIT", "STALL_FETCH", "DRAIN")


@dataclass(frozen=True)
class Runs:
    """n runs: words (n, names) read after each, flags and cycles (n,) (None without a clock).

    fault, text: of the last run, the runs end with it.
    """

    words: NDArray[np.uint32]
    flags: NDArray[np.uint8]
    cycles: NDArray[np.uint32] | None
    fault: Fault | None = None
    text: str = ""


@dataclass(frozen=True)
class Observed:
    """What a run did: counters by name; writes (register or output, word), on the core in the order
    of time, on the model by register; trace: issues and writes by clock cycle, on the core only.
    """

    counters: dict[str, int]
    writes: list[tuple[str, int]]
    trace: Trace | None = None


class Backend(Protocol):
    """A loaded program. Words are raw, 32 bits."""

    def has(self, name: str) -> bool:
        """Whether `read` knows the name: outputs, exports, states, registers of banks A, B, C."""

    def run(self, inputs: Sequence[str], data: NDArray[np.uint32], read: Sequence[str]) -> Runs:
        """A run per row of data (n, inputs), up to a fault."""

    def preset(self, words: Mapping[str, int]) -> None: ...

    def write_data(self, address: int, words: Sequence[int]) -> None:
        """Words of data memory from an address on."""

    def select(self, image: Image) -> None:
        """Go on with another function of the image loaded (`Image.function`), by its names."""

    def read(self, name: str) -> int: ...

    def clear(self) -> None:
        """End a fault and empty the trace."""

    def observed(self) -> Observed:
        """What the runs since `clear` did, at least one."""

    def close(self) -> None: ...


class RtlBackend:
    """The Verilated core `rtl`, built at first use. trace: its writes and issues are recorded."""

    def __init__(self, image: Image, trace: bool = False) -> None:
        # Verilator is needed here only, not by the instruction-set model.
        from sim.rtl.asip_rtl import AsipRtl

        self._trace = trace
        self.rtl = AsipRtl(image.configuration)
        self.rtl.load(image)
        self._name(image)

    def _name(self, image: Image) -> None:
        self._image = image
        self._addresses = readable_addresses(image)

    def select(self, image: Image) -> None:
        self.rtl.select(image)
        self._name(image)

    def has(self, name: str) -> bool:
        return name in self._addresses or is_register(name)

    def _address(self, name: str) -> int:
        known = self._addresses.get(name)
        return register_address(name) if known is None else known

    def run(self, inputs: Sequence[str], data: NDArray[np.uint32], read: Sequence[str]) -> Runs:
        addresses = self.rtl.input_addresses(inputs)
        result = self.rtl.run(addresses, data, [self._address(name) for name in read])
        flags = ((result.status & FLAGS.mask) >> FLAGS.low).astype(np.uint8)
        if not len(data) or result.fault == NO_FAULT:
            return Runs(result.words, flags, result.cycles)
        fault = self.fault(result.fault)
        last = dict(zip(inputs, data[len(result.words) - 1].tolist(), strict=True))
        text = fault_text(self._image, fault, last)
        return Runs(result.words, flags, result.cycles, fault, text)

    def fault(self, cause: str) -> Fault:
        """The fault that the core is in."""
        return Fault.of(cause, self.rtl.read(CSR["FAULT_INFO"]))

    def preset(self, words: Mapping[str, int]) -> None:
        self.rtl.preset(words)

    def write_data(self, address: int, words: Sequence[int]) -> None:
        for k, word in enumerate(words, BLOCK["data"] + address):
            self.rtl.write(k, word)

    def read(self, name: str) -> int:
        return self.rtl.read(self._address(name))

    def clear(self) -> None:
        self.rtl.trace(self._trace)
        self.rtl.clear()

    def observed(self) -> Observed:
        counters = {name: self.rtl.read(CSR[name]) for name in COUNTERS}
        timed = self.rtl.timed_writes()
        return Observed(
            counters,
            [(f"{bank.lower()}{index}", word) for _, bank, index, word in timed],
            Trace(self.rtl.traced_issues(), timed, counters),
        )

    def close(self) -> None:
        self.rtl.close()


class IssBackend:
    """The instruction-set model `iss`: same bits except for sine and cosine, which it rounds
    correctly; no clock cycles. trace: every write is recorded, not only the last of a register."""

    def __init__(self, image: Image, trace: bool = False) -> None:
        from sim.core.iss import Iss

        self.iss = Iss(image, trace=trace)
        self._name(image)

    def select(self, image: Image) -> None:
        self.iss.select(image)
        self._name(image)

    def _name(self, image: Image) -> None:
        self._image = image
        self._outputs = {o.name: int(o.safe, 16) for o in image.outputs}
        self._readable = set(image.registers)

    def has(self, name: str) -> bool:
        return name in self._outputs or name in self._readable or is_register(name)

    def run(self, inputs: Sequence[str], data: NDArray[np.uint32], read: Sequence[str]) -> Runs:
        words, flags, fault, text = [], [], None, ""
        for row in data.tolist():
            self.iss.set_words(dict(zip(inputs, row, strict=True)))
            result = self._last = self.iss.run()
            self._outputs = result.output_bits
            words.append([self.read(name) for name in read])
            flags.append(result.flags)
            if result.fault.name != NO_FAULT:
                fault = Fault(result.fault.name, bundle=result.fault_bundle)
                text = fault_text(self._image, fault, dict(zip(inputs, row, strict=True)))
                break
        shape = (len(words), len(read))
        return Runs(
            np.array(words, dtype=np.uint32).reshape(shape),
            np.array(flags, dtype=np.uint8),
            None,
            fault,
            text,
        )

    def preset(self, words: Mapping[str, int]) -> None:
        self.iss.set_words(words)

    def write_data(self, address: int, words: Sequence[int]) -> None:
        for k, word in enumerate(words, address):
            self.iss.write_place(f"d{k}", word)

    def read(self, name: str) -> int:
        return self._outputs[name] if name in self._outputs else self.iss.read_bits(name)

    def clear(self) -> None:
        """The model needs nothing."""

    def observed(self) -> Observed:
        result = self._last
        writes = [(name, word) for name, words in result.writes.items() for word in words]
        return Observed({"BUNDLES": result.bundles}, writes)

    def close(self) -> None:
        del self.iss


BACKENDS: Mapping[str, Callable[..., Backend]] = {"rtl": RtlBackend, "iss": IssBackend}


def number(word: int, type_name: str) -> float | int:
    """Value of a word."""
    data = word.to_bytes(4, "big")
    if type_name == "int":
        return int.from_bytes(data, "big", signed=True)
    return struct.unpack(">f", data)[0]


def readable_addresses(image: Image) -> dict[str, int]:
    """Bus addresses of outputs, exports and states by name, except for exports of bank K."""
    places = image.registers.items()
    found = {name: register_address(at) for name, at in places if is_register(at)}
    return found | {output.name: BLOCK["outputs"] + output.index for output in image.outputs}


def unknown(what: str, name: str, known: Iterable[str]) -> str:
    """Message for a name that the program does not have."""
    known = list(known)
    help_text = closest(name, known) or (f"it has {', '.join(known)}" if known else "it has none")
    return f"the program has no {what} '{name}'; {help_text}"


def flag_text(flags: int) -> str:
    """Names of the exceptions raised, `0b00011` -> `"uf nx"`; no flag -> `"-"`."""
    return " ".join(n for i, n in enumerate(FLAG_NAMES) if flags >> (4 - i) & 1) or "-"


def is_register(name: str) -> bool:
    """Whether the name is a register that a host can read ('a3', 'c12')."""
    banks = {bank.lower(): default_isa().banks[bank].size for bank in "ABC"}
    return name[:1] in banks and name[1:].isdecimal() and int(name[1:]) < banks[name[0]]
