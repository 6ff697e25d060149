# SPDX-License-Identifier: Apache-2.0
"""Where a `Core` runs: the Verilated RTL or the instruction-set model, behind one interface."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from sim.asip_run.inputs import is_register
from sim.asip_run.runners import NO_FAULT, Fault, number
from sim.asip_run.show import fault_text


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


class Backend(Protocol):
    """A loaded program. Words are raw, 32 bits."""

    def has(self, name: str) -> bool:
        """Whether `read` knows the name: outputs, exports, states, registers of banks A, B, C."""

    def run(self, inputs: Sequence[str], data: NDArray[np.uint32], read: Sequence[str]) -> Runs:
        """A run per row of data (n, inputs), up to a fault."""

    def preset(self, words: Mapping[str, int]) -> None: ...

    def read(self, name: str) -> int: ...

    def close(self) -> None: ...


class RtlBackend:
    """The Verilated core `rtl`, built at first use."""

    def __init__(self, image: Image) -> None:
        # Verilator is needed here only, not by the instruction-set model.
        from sim.harness import asip_rtl

        self._bus = asip_rtl
        self._image = image
        self.rtl = asip_rtl.AsipRtl(image.configuration)
        self.rtl.load(image)
        block = asip_rtl.BLOCK["outputs"]
        places = {e.name: e.register for e in (*image.exports, *image.states)}
        self._addresses = {
            name: asip_rtl.register_address(register)
            for name, register in places.items()
            if is_register(register)
        } | {output.name: block + output.index for output in image.outputs}

    def has(self, name: str) -> bool:
        return name in self._addresses or is_register(name)

    def _address(self, name: str) -> int:
        known = self._addresses.get(name)
        return self._bus.register_address(name) if known is None else known

    def run(self, inputs: Sequence[str], data: NDArray[np.uint32], read: Sequence[str]) -> Runs:
        addresses = self.rtl.input_addresses(inputs)
        result = self.rtl.run(addresses, data, [self._address(name) for name in read])
        flags = self._bus.STATUS["flags"].of(result.status).astype(np.uint8)
        if not len(data) or result.fault == NO_FAULT:
            return Runs(result.words, flags, result.cycles)
        info = self.rtl.read(self._bus.CSR["FAULT_INFO"])
        place = "output" if result.fault == "NOT_FINITE" else "bundle"
        fault = Fault(result.fault, **{place: info})
        return Runs(result.words, flags, result.cycles, fault, fault_text(self._image, fault))

    def preset(self, words: Mapping[str, int]) -> None:
        self.rtl.preset(words)

    def read(self, name: str) -> int:
        return self.rtl.read(self._address(name))

    def close(self) -> None:
        self.rtl.close()


class IssBackend:
    """The instruction-set model `iss`: same bits but for sine and cosine, which it rounds
    correctly; no clock cycles."""

    def __init__(self, image: Image) -> None:
        from sim.iss import Iss

        self._image = image
        self.iss = Iss(image)
        self._outputs = {o.name: int(o.safe, 16) for o in image.outputs}
        self._readable = {entry.name for entry in (*image.exports, *image.states)}
        self._types = {entry.name: entry.type for entry in (*image.inputs, *image.states)}

    def _values(self, words: Mapping[str, int]) -> dict[str, float]:
        return {name: number(word, self._types[name]) for name, word in words.items()}

    def has(self, name: str) -> bool:
        return name in self._outputs or name in self._readable or is_register(name)

    def run(self, inputs: Sequence[str], data: NDArray[np.uint32], read: Sequence[str]) -> Runs:
        words, flags, fault, text = [], [], None, ""
        for row in data.tolist():
            self.iss.set_inputs(self._values(dict(zip(inputs, row, strict=True))))
            result = self.iss.run()
            self._outputs = result.output_bits
            words.append([self.read(name) for name in read])
            flags.append(result.flags)
            if result.fault.name != NO_FAULT:
                fault = Fault(result.fault.name, bundle=result.fault_bundle)
                text = fault_text(self._image, fault)
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
        self.iss.set_state(self._values(words))

    def read(self, name: str) -> int:
        return self._outputs[name] if name in self._outputs else self.iss.read_bits(name)

    def close(self) -> None:
        del self.iss


BACKENDS: Mapping[str, Callable[[Image], Backend]] = {"rtl": RtlBackend, "iss": IssBackend}
