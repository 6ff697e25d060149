# SPDX-License-Identifier: Apache-2.0
"""Client of the debug block: what a debugger or a scope does with a core, over any link.

    client = connect(model)                       # sim.debug.model.DebugRtl, in this process
    client = connect("tcp://localhost:2331")      # a server, python -m sim.debug.server
    client = connect("serial:/dev/ttyUSB0?baud=3000000")

    client.set_breakpoint(31)
    client.resume()
    client.wait(lambda state: state.halted)
    client.read_register("c12"), client.state().next

Words are raw, 32 bits; addresses of bundles, data and registers are those of the program image.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from asip_asm.image import Image
from sim.debug.link import Bus, DirectLink, open_link
from sim.debug.recorder import Recorder
from sim.debug.requests import DebugError
from sim.debug.run_control import RunControl
from sim.debug.state import STAGE, configuration_of, word_of
from sim.rtl.asip_bus import (
    BLOCK,
    CLEAR,
    CSR,
    FAULT_NAMES,
    START,
    STATUS,
    load_words,
    place_address,
)

__all__ = ["Client", "DebugError", "connect"]


def connect(target: Bus | str, timeout: float = 2.0) -> Client:
    """A client of a model in this process, or of an address (`sim.debug.link.open_link`).

    Raises LinkError if nothing answers, or what answers is no debug block.
    """
    link = open_link(target) if isinstance(target, str) else DirectLink(target)
    try:
        return Client(link, timeout)
    except BaseException:
        link.close()
        raise


class Client(RunControl, Recorder):
    """All that a debugger or a scope does with one core."""

    # ------------------------------------------------------------------ registers and data
    def read_register(self, name: str) -> int:
        """Word of a register ('a3', 'k5') or output ('o2': of the last completed run)."""
        return self.read_word(place_address(name))

    def write_register(self, name: str, word: int) -> None:
        """Word of a register, or of bank K. Raises ValueError for an output."""
        if name[:1].lower() == "o":
            raise ValueError(f"'{name}': only runs write outputs")
        self.write_word(place_address(name), word)

    def read_data(self, address: int, count: int = 1) -> list[int]:
        """Words of data memory."""
        return self.read_words(BLOCK["data"] + address, count)

    def write_data(self, address: int, words: Sequence[int]) -> None:
        """Words of data memory."""
        self.write_words(BLOCK["data"] + address, words)

    # ------------------------------------------------------------------ programs and runs
    def load(self, image: Image) -> None:
        """Load a program, its states at their initial values, as a driver would.

        Raises ImageError for an image that no assembler writes, DebugError inside a run or for an
        image that is for another configuration.
        """
        image.check()
        self._check_configuration(image)
        if self.state().running:
            raise DebugError("the core is inside a run; abort it, or let it end, before a load")
        self.write_word(CSR["CONTROL"], CLEAR)
        for address, words in _rows(load_words(image)):
            self.write_words(address, words)

    def check_program(self, image: Image) -> None:
        """Raises DebugError if the core has another program than an image, whose names would be
        those of other words. Program memory cannot be read back: entry and outputs identify it."""
        self._check_configuration(image)
        runs = {(image.entry, image.output_mask)}
        runs |= {(each.entry, each.output_mask) for each in image.functions}
        entry, mask = self.read_word(CSR["ENTRY"]), self.read_word(CSR["OUTPUT_MASK"])
        if (entry, mask) not in runs:
            title = f"'{image.title}'" if image.title else "the image"
            raise DebugError(
                f"the core has another program than {title}: its entry is {entry} and its "
                f"outputs {mask:#x}, the image's {image.entry} and {image.output_mask:#x}; give "
                "the image that the core was loaded with, or load this one"
            )

    def _check_configuration(self, image: Image) -> None:
        config, stream = (self.read_word(CSR[name]) for name in ("CONFIG", "STREAM"))
        if (core := configuration_of(config, stream)) != image.configuration:
            raise DebugError(
                f"the program is for '{image.configuration}', the core is '{core}': assemble it "
                f"with --config {core}"
            )

    def start(self) -> None:
        """Start a run; ignored by a core that runs or is faulted."""
        self.write_word(CSR["CONTROL"], START)

    def clear(self) -> None:
        """Clear done and fault of the core."""
        self.write_word(CSR["CONTROL"], CLEAR)

    def fault(self) -> tuple[str, int]:
        """Cause of the core's fault ('NONE' without) and FAULT_INFO (docs/regmap.md)."""
        cause = FAULT_NAMES[STATUS["cause"].of(self.read_word(CSR["STATUS"]))]
        return cause, self.read_word(CSR["FAULT_INFO"])

    def cycles(self) -> int:
        """Clock cycles of the present or last run; halted ones count if the watchdog runs."""
        return self.read_word(CSR["CYCLES"])

    def runs(self) -> int:
        """Runs that have ended since reset."""
        return self._read("RUNS")

    # ------------------------------------------------------------------ live parameters
    def stage(self, words: Iterable[tuple[int, int]]) -> None:
        """Stage words of bank K by index: they change with the next `commit`, all together.

        Raises DebugError if they do not fit.
        """
        for index, word in words:
            self.write_word(STAGE + index, word)
        if self.state().overflow:
            raise DebugError(
                f"more than {self.sizes.stage_words} words are staged; discard, and stage fewer"
            )

    def stage_parameters(self, image: Image, values: dict[str, float]) -> None:
        """Stage parameters of the program by name (`.param NAME = VALUE`).

        Raises DebugError for a name that is none.
        """
        places = {entry.name: entry for entry in image.constants if entry.name in image.parameters}
        for name in values:
            if name not in places:
                raise DebugError(
                    f"no parameter '{name}' in bank K; there are {', '.join(places) or 'none'}: "
                    "declare it with .param NAME = VALUE, and use it in no expression, which "
                    "would fix its value in the program"
                )
        self.stage((places[n].index, word_of(v, places[n].type)) for n, v in values.items())

    def commit(self) -> None:
        """All staged words go to bank K between two runs, never inside one; `version` counts."""
        self._control("commit")

    def discard(self) -> None:
        """Drop the staged words."""
        self._control("discard")

    def version(self) -> tuple[int, int]:
        """Commits done: of the words in bank K now, and of those that the present or last run
        began with (modulo 2^16)."""
        fields = self._fields("VERSION")
        return fields["page"], fields["run"]


def _rows(writes: Iterable[tuple[int, int]]) -> Iterable[tuple[int, list[int]]]:
    """Writes put together where addresses follow each other."""
    start, words = 0, list[int]()
    for address, word in writes:
        if words and address != start + len(words):
            yield start, words
            words = []
        if not words:
            start = address
        words.append(word)
    if words:
        yield start, words
