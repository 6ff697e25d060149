# SPDX-License-Identifier: Apache-2.0
"""Runs of a program on a core over a link, a board for example, as a backend of a `Core`."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from sim.core.backends import COUNTERS, Observed, Runs, is_register, readable_addresses
from sim.core.fault import NO_FAULT, Fault, fault_text
from sim.debug.client import Client, DebugError
from sim.rtl.asip_bus import BLOCK, CSR, FAULT_NAMES, STATUS, register_address, run_words


class LinkBackend:
    """A program loaded over a link; `Backend` of sim/core/backends.py. It has no trace.

    Methods raise LinkError, DebugError.
    """

    def __init__(self, image: Image, client: Client) -> None:
        """Ends a run that goes on or is held, frees breakpoints and watches, loads the program."""
        self.client = client
        client.set_mode()
        client.free_points()
        if client.state().running:
            client.abort()
        if client.state().held:
            client.resume()
        client.wait(lambda state: not state.running)
        client.load(image)
        self._name(image)

    def _name(self, image: Image) -> None:
        self._image = image
        self._addresses = readable_addresses(image)
        self._inputs = {entry.name: BLOCK["constants"] + entry.index for entry in image.inputs}

    def select(self, image: Image) -> None:
        for address, word in run_words(image):
            self.client.write_word(address, word)
        self._name(image)

    def has(self, name: str) -> bool:
        return name in self._addresses or is_register(name)

    def run(self, inputs: Sequence[str], data: NDArray[np.uint32], read: Sequence[str]) -> Runs:
        words: list[list[int]] = []
        flags: list[int] = []
        cycles: list[int] = []
        fault, text = None, ""
        for row in data.tolist():
            for name, word in zip(inputs, row, strict=True):
                self.client.write_word(self._inputs[name], word)
            status = self._run()
            words.append([self.read(name) for name in read])
            flags.append(STATUS["flags"].of(status))
            cycles.append(self.client.cycles())
            cause = FAULT_NAMES[STATUS["cause"].of(status)]
            if cause != NO_FAULT:
                fault = Fault.of(cause, self.client.read_word(CSR["FAULT_INFO"]))
                text = fault_text(self._image, fault, dict(zip(inputs, row, strict=True)))
                break
        return Runs(
            np.array(words, dtype=np.uint32).reshape(len(words), len(read)),
            np.array(flags, dtype=np.uint8),
            np.array(cycles, dtype=np.uint32),
            fault,
            text,
        )

    def _run(self) -> int:
        """STATUS after one run. Raises DebugError if it does not end."""
        self.client.clear()
        self.client.start()
        end = time.monotonic() + self.client.timeout
        while STATUS["busy"].of(status := self.client.read_word(CSR["STATUS"])):
            if time.monotonic() > end:
                raise DebugError(
                    f"the run has not ended within {self.client.timeout:g} s; is a debugger "
                    "holding the core? Its watchdog is "
                    f"{self._image.watchdog} cycles"
                )
            self.client.link.pause()
        return status

    def preset(self, words: Mapping[str, int]) -> None:
        states = {state.name: state.register for state in self._image.states}
        for name, word in words.items():
            self.client.write_register(states[name], word)

    def write_data(self, address: int, words: Sequence[int]) -> None:
        self.client.write_data(address, words)

    def read(self, name: str) -> int:
        address = self._addresses.get(name)
        return self.client.read_word(register_address(name) if address is None else address)

    def clear(self) -> None:
        self.client.clear()

    def observed(self) -> Observed:
        return Observed({name: self.client.read_word(CSR[name]) for name in COUNTERS}, [])

    def close(self) -> None:
        self.client.close()
