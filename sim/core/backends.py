# SPDX-License-Identifier: Apache-2.0
"""A core somewhere that runs a program: one interface for the Verilated RTL, the instruction-set
model, and cores with a debug block (sim/debug/backend.py), boards for example.
"""

from __future__ import annotations

import struct
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asip_asm.diagnostics import closest
from asip_asm.image import Image
from asip_asm.isa import default_isa
from asip_asm.profile import Trace
from sim.core.fault import NO_FAULT, Fault, fault_text
from sim.rtl.asip_bus import BLOCK, CSR, FAULT_NAMES, STATUS, AsipError, place_address, run_words

if TYPE_CHECKING:
    from sim.core.iss import Iss
    from sim.core.iss.stepped import SteppedRun
    from sim.rtl.asip_rtl import AsipRtl, TickPort

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


class Kind(Enum):
    """What a core does: nothing (between two runs), halted inside a run, running, faulted."""

    IDLE = "idle"
    HALTED = "halted"
    RUNNING = "running"
    FAULT = "fault"


@dataclass(frozen=True)
class Status:
    """State of a core. position: bundle that issues next, or the last one before a fault; reason:
    why it is halted ('breakpoint', 'watch', 'step', 'start', 'request'); which: of the watches;
    fault: of a faulted core.
    """

    kind: Kind
    position: int = 0
    reason: str = ""
    which: int = 0
    fault: Fault | None = None


IDLE = Status(Kind.IDLE)


class Backend(ABC):
    """A core somewhere, with the program that `load` has given it.

    `run` does whole runs. A run that can be stopped inside begins with `begin`; `poll` reports
    when the core stops, then `step` or `resume` goes on. A core without a debug block (its
    `breakpoints` are 0) refuses that.

    Words are raw, 32 bits. Places are 'a3', 'k7', 'o0', 'd12', 'a3.2' in a further lane; `place`
    finds those of the program's names. All methods raise AsipError for what the core cannot do,
    and its subclass LinkError if nothing answers any more.
    """

    label: str
    image: Image
    """The program loaded, or the function of it that `select` has chosen."""
    breakpoints = 0
    watches = 0
    driven = False
    """Another host writes the inputs and starts the runs; `begin` takes the next one."""

    # ------------------------------------------------------------------ programs
    @abstractmethod
    def load(self, image: Image) -> None:
        """Load a program, states at their initial values. Raises ImageError."""

    @abstractmethod
    def select(self, image: Image) -> None:
        """Go on with another function of the image loaded (`Image.function`), by its names."""

    def _name(self, image: Image) -> None:
        self.image = image
        self._places = readable_places(image)

    def place(self, name: str) -> str | None:
        """Place of an output, export, state or register (banks A, B, C) by name, else None."""
        return self._places.get(name) or (name if is_register(name) else None)

    # ------------------------------------------------------------------ words
    @abstractmethod
    def read(self, place: str) -> int:
        """Word of a place."""

    def read_name(self, name: str) -> int:
        """Word of a name that `place` knows."""
        return self.read(self._place(name))

    def _place(self, name: str) -> str:
        place = self.place(name)
        if place is None:
            raise AsipError(unknown("output, export, state or register", name, self._places))
        return place

    @abstractmethod
    def write(self, place: str, word: int) -> None:
        """Give a place another word."""

    def write_data(self, address: int, words: Sequence[int]) -> None:
        """Words of data memory from an address on."""
        for k, word in enumerate(words, address):
            self.write(f"d{k}", word)

    def preset(self, words: Mapping[str, int]) -> None:
        """States by name, for the next run."""
        places = {state.name: state.register for state in self.image.states}
        for name, word in words.items():
            self.write(places[name], word)

    # ------------------------------------------------------------------ whole runs
    @abstractmethod
    def run(self, inputs: Sequence[str], data: NDArray[np.uint32], read: Sequence[str]) -> Runs:
        """A run per row of data (n, inputs), up to a fault. read: names that `place` knows."""

    @abstractmethod
    def observed(self) -> Observed:
        """What the runs since `clear` did, at least one."""

    @abstractmethod
    def count(self) -> tuple[str, int]:
        """How long the run has taken so far: 'CYCLES' or, without a clock, 'BUNDLES'."""

    @abstractmethod
    def clear(self) -> None:
        """End a fault and empty the trace."""

    # ------------------------------------------------------------------ runs that stop inside
    def begin(self, inputs: Mapping[str, int], hold: bool) -> None:
        """Start a run with these inputs; `hold`: it halts before its first bundle."""
        raise self._no_block()

    def resume(self) -> None:
        """Go on; the bundle that waits issues whatever breakpoint it has."""
        raise self._no_block()

    def step(self) -> None:
        """Issue one bundle."""
        raise self._no_block()

    def halt(self) -> None:
        """Issue no further bundle."""
        raise self._no_block()

    def abort(self) -> None:
        """Give up the run that the core is in."""
        raise self._no_block()

    def poll(self, seconds: float) -> Status:
        """The state, as soon as the core does not run, at the latest after so long."""
        raise self._no_block()

    def arm(self, bundles: Sequence[int], places: Sequence[str]) -> None:
        """Halt before these bundles, and after every write of these registers and outputs; those
        of an earlier call are gone."""
        raise self._no_block()

    def _no_block(self) -> AsipError:
        return AsipError(f"the {self.label} has no debug block: only whole runs are possible")

    def stream_places(self) -> dict[str, int]:
        """Place of the next word of each pipe's stream, as far as the core shows it."""
        return {}

    # ------------------------------------------------------------------ life
    @abstractmethod
    def reconnect(self) -> None:
        """Look for a core that is gone. Raises LinkError if it is still."""

    @abstractmethod
    def close(self) -> None:
        """Leave the core; one that others drive goes on without breakpoints."""


@dataclass(frozen=True)
class OneRun:
    """Flags as STATUS has them, clock cycles (None without a clock), fault of one run."""

    flags: int
    cycles: int | None
    fault: Fault | None


def run_each(
    backend: Backend,
    one: Callable[[Mapping[str, int]], OneRun],
    inputs: Sequence[str],
    data: NDArray[np.uint32],
    read: Sequence[str],
) -> Runs:
    """`Backend.run` for a core that takes one run after the other; one: carries out a run with
    inputs by name."""
    words, done, text = [], [], ""
    for row in data.tolist():
        given = dict(zip(inputs, row, strict=True))
        done.append(one(given))
        words.append([backend.read_name(name) for name in read])
        if done[-1].fault is not None:
            text = fault_text(backend.image, done[-1].fault, given)
            break
    cycles = [run.cycles for run in done if run.cycles is not None]
    return Runs(
        np.array(words, dtype=np.uint32).reshape(len(words), len(read)),
        np.array([run.flags for run in done], dtype=np.uint8),
        np.array(cycles, dtype=np.uint32) if cycles else None,
        done[-1].fault if done else None,
        text,
    )


class BusBackend(Backend):
    """A core whose bus can be reached."""

    @abstractmethod
    def read_word(self, address: int) -> int:
        """Word at a bus address."""

    @abstractmethod
    def write_word(self, address: int, word: int) -> None:
        """One word to a bus address."""

    def select(self, image: Image) -> None:
        for address, word in run_words(image):
            self.write_word(address, word)
        self._name(image)

    def read(self, place: str) -> int:
        return self.read_word(_address(place))

    def write(self, place: str, word: int) -> None:
        if place[:1] == "o":
            raise AsipError(f"'{place}': only runs write outputs")
        self.write_word(_address(place), word)

    def fault(self, cause: str) -> Fault:
        """The fault that the core is in."""
        return Fault.of(cause, self.read_word(CSR["FAULT_INFO"]))

    def observed(self) -> Observed:
        return Observed({name: self.read_word(CSR[name]) for name in COUNTERS}, [])

    def count(self) -> tuple[str, int]:
        return "CYCLES", self.read_word(CSR["CYCLES"])


def _address(place: str) -> int:
    """Bus address of a place. Raises AsipError."""
    if "." in place:
        raise AsipError(f"{place}: the core shows the first lane alone, --iss all")
    if place[:1] == "d" and place[1:].isdecimal() and int(place[1:]) < default_isa().data_words:
        return BLOCK["data"] + int(place[1:])
    try:
        return place_address(place)
    except ValueError as error:
        raise AsipError(str(error)) from None


class RtlBackend(BusBackend):
    """The Verilated core `rtl`, built at first use. trace: its writes and issues are recorded."""

    label = "Verilated core"
    rtl: AsipRtl

    def __init__(self, trace: bool = False) -> None:
        self._trace = trace

    def load(self, image: Image) -> None:
        # Verilator is needed here only, not by the instruction-set model.
        from sim.rtl.asip_rtl import AsipRtl

        self.rtl = AsipRtl(image.configuration)
        self.rtl.load(image)
        self._name(image)

    def _name(self, image: Image) -> None:
        super()._name(image)
        self._ports: dict[tuple[tuple[str, ...], ...], TickPort] = {}

    def select(self, image: Image) -> None:
        self.rtl.select(image)
        self._name(image)

    def read_word(self, address: int) -> int:
        return self.rtl.read(address)

    def write_word(self, address: int, word: int) -> None:
        self.rtl.write(address, word)

    def run(self, inputs: Sequence[str], data: NDArray[np.uint32], read: Sequence[str]) -> Runs:
        port = self._port(tuple(inputs), tuple(read), len(data))
        port.data[:] = data
        done = port.run()
        status = port.status[:done]
        words, cycles = port.words[:done].copy(), port.cycles[:done].copy()
        flags = ((status & FLAGS.mask) >> FLAGS.low).astype(np.uint8)
        if not done or not STATUS["fault"].of(int(status[-1])):
            return Runs(words, flags, cycles)
        fault = self.fault(FAULT_NAMES[STATUS["cause"].of(int(status[-1]))])
        last = dict(zip(inputs, data[done - 1].tolist(), strict=True))
        return Runs(words, flags, cycles, fault, fault_text(self.image, fault, last))

    def _port(self, inputs: tuple[str, ...], read: tuple[str, ...], ticks: int) -> TickPort:
        """Ports of single ticks are used again: a loop has the same names in each tick."""
        port = self._ports.get((inputs, read))
        if port is None or ticks != 1:
            reads = [_address(self._place(name)) for name in read]
            port = self.rtl.port(self.rtl.input_addresses(inputs), reads, ticks)
            if ticks == 1:
                self._ports[inputs, read] = port
        return port

    def clear(self) -> None:
        self.rtl.trace(self._trace)
        self.rtl.clear()

    def observed(self) -> Observed:
        counters = super().observed().counters
        timed = self.rtl.timed_writes()
        return Observed(
            counters,
            [(f"{bank.lower()}{index}", word) for _, bank, index, word in timed],
            Trace(self.rtl.traced_issues(), timed, counters),
        )

    def reconnect(self) -> None:
        """The model is always there."""

    def close(self) -> None:
        self._ports.clear()
        self.rtl.close()


class IssBackend(Backend):
    """The instruction-set model `iss`: same bits except for sine and cosine, which it rounds
    correctly; no clock cycles. trace: every write is recorded, not only the last of a register.

    It has no limits of a debug block but those that keep tables of breakpoints readable.
    """

    label = "instruction-set model"
    breakpoints = 64
    watches = 64
    iss: Iss

    def __init__(self, trace: bool = False) -> None:
        self._trace = trace
        self._held: SteppedRun | None = None
        self._going = False
        self._reason = ""
        self._which = 0
        self._bundles: Sequence[int] = ()
        self._watched: Sequence[str] = ()

    def load(self, image: Image) -> None:
        from sim.core.iss import Iss

        self.iss = Iss(image, trace=self._trace)
        self._name(image)
        self._held = None

    def select(self, image: Image) -> None:
        self.iss.select(image)
        self._name(image)

    def read(self, place: str) -> int:
        try:
            return self.iss.read_place(place)
        except KeyError:
            raise AsipError(f"there is no place '{place}'") from None

    def write(self, place: str, word: int) -> None:
        try:
            self.iss.write_place(place, word)
        except KeyError:
            raise AsipError(f"there is no place '{place}'") from None

    def run(self, inputs: Sequence[str], data: NDArray[np.uint32], read: Sequence[str]) -> Runs:
        return run_each(self, self._one_run, inputs, data, read)

    def _one_run(self, inputs: Mapping[str, int]) -> OneRun:
        self.iss.set_words(inputs)
        result = self._last = self.iss.run()
        return OneRun(result.flags, None, _fault(result.fault.name, result.fault_bundle))

    def observed(self) -> Observed:
        result = self._last
        writes = [(name, word) for name, words in result.writes.items() for word in words]
        return Observed({"BUNDLES": result.bundles}, writes)

    def count(self) -> tuple[str, int]:
        return "BUNDLES", self._held.bundles if self._held else 0

    def stream_places(self) -> dict[str, int]:
        return dict(zip("AB", self.iss.stream_places, strict=False))

    def clear(self) -> None:
        self._held = None

    def abort(self) -> None:
        self._held, self._going = None, False

    def begin(self, inputs: Mapping[str, int], hold: bool) -> None:
        from sim.core.iss.stepped import SteppedRun

        self.iss.set_words(inputs)
        self._held = SteppedRun(self.iss)
        self._going = not hold
        self._reason = "start" if hold else ""
        if self._held.position in self._bundles and not hold:
            self._stop("breakpoint")

    def resume(self) -> None:
        if self._held and self._held.position is not None:
            self._going = True
            self._one(self._held)

    def step(self) -> None:
        self.resume()
        if self._going:
            self._stop("step")

    def halt(self) -> None:
        if self._going:
            self._stop("request")

    def poll(self, seconds: float) -> Status:
        run, end = self._held, time.monotonic() + seconds
        if run is None:
            return IDLE
        while self._going and time.monotonic() < end:
            self._one(run)
        if run.position is None:
            fault = _fault(run.fault.name, run.fault_bundle)
            return Status(Kind.FAULT, run.fault_bundle or 0, fault=fault) if fault else IDLE
        if self._going:
            return Status(Kind.RUNNING, run.position)
        return Status(Kind.HALTED, run.position, self._reason, self._which)

    def arm(self, bundles: Sequence[int], places: Sequence[str]) -> None:
        self._bundles, self._watched = bundles, places

    def reconnect(self) -> None:
        """The model is always there."""

    def close(self) -> None:
        """The model needs nothing."""

    def _stop(self, reason: str, which: int = 0) -> None:
        self._going, self._reason, self._which = False, reason, which

    def _one(self, run: SteppedRun) -> None:
        """Execute the bundle that waits, and see whether the next one waits."""
        run.step()
        if run.position is None:
            self._going = False
            return
        for which, place in enumerate(self._watched):
            if place in run.writes:
                self._stop("watch", which)
        if self._going and run.position in self._bundles:
            self._stop("breakpoint")


def _fault(cause: str, bundle: int | None) -> Fault | None:
    return None if cause == NO_FAULT else Fault(cause, bundle=bundle)


BACKENDS: Mapping[str, Callable[..., Backend]] = {"rtl": RtlBackend, "iss": IssBackend}


def number(word: int, type_name: str) -> float | int:
    """Value of a word."""
    data = word.to_bytes(4, "big")
    if type_name == "int":
        return int.from_bytes(data, "big", signed=True)
    (value,) = struct.unpack(">f", data)
    return float(value)


def readable_places(image: Image) -> dict[str, str]:
    """Places of outputs, exports and states by name, except for exports of bank K."""
    found = {name: at for name, at in image.registers.items() if is_register(at)}
    return found | {output.name: f"o{output.index}" for output in image.outputs}


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
