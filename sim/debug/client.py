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

import time
from collections.abc import Callable, Iterable, Sequence

from asip_asm.image import Image
from sim.debug.link import Bus, DirectLink, Link, LinkError, open_link
from sim.debug.packets import (
    READ_WORDS,
    WRITE_WORDS,
    ErrorCode,
    Event,
    Packet,
    PacketError,
    Type,
    event,
    read_body,
    samples,
    unpack_words,
    write_body,
)
from sim.debug.state import (
    BANKS,
    FIELDS,
    REGISTER,
    REGMAP,
    RING,
    RING_WORDS,
    STAGE,
    Records,
    ScopeSetup,
    Sizes,
    State,
    code,
    configuration_of,
    place_address,
    word_of,
)
from sim.harness.asip_bus import BLOCK, CLEAR, CSR, FAULT_NAMES, START, STATUS, load_words

TRIES = 3


class DebugError(RuntimeError):
    """The block cannot do what was asked for; the text says why, and the cure."""


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


class Client:
    """One debug block behind a link. Methods raise LinkError if nothing answers any more.

    timeout: seconds for an answer; a request is sent TRIES times. A read of registers, data or
    outputs during a run is answered when the run has ended or is halted.
    """

    def __init__(self, link: Link, timeout: float = 2.0) -> None:
        self.link = link
        self.timeout = timeout
        self.events: list[Event] = []
        """Events that came unasked, oldest first; whoever reads them removes them."""
        self._sequence = 0
        self._setup: ScopeSetup | None = None
        self._taken = 0  # records drained since arm
        self._streamed: list[Records] = []
        identity, config = self._neighbours("ID", "CONFIG")
        if identity != REGMAP.registers["ID"].reset:
            raise LinkError(
                f"word {REGISTER['ID']:#06x} is {identity:#010x}, no debug block: the core was "
                "built without one, take `debug_asip` in place of `asip`"
            )
        fields = {name: f.of(config) for name, f in FIELDS["CONFIG"].items()}
        self.sizes = Sizes(
            fields["breakpoints"],
            fields["watches"],
            fields["channels"],
            1 << fields["ring_log2"],
            1 << fields["stage_log2"],
            bool(fields["uart"]),
        )

    def close(self) -> None:
        """End the link; the core goes on as it is."""
        self.link.close()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # ------------------------------------------------------------------ words
    def read_words(self, address: int, count: int = 1) -> list[int]:
        """Words from a bus address on."""
        words: list[int] = []
        while len(words) < count:
            part = min(count - len(words), READ_WORDS)
            body = self._request(Type.READ, read_body(address + len(words), part))
            words += unpack_words(body)
        return words

    def write_words(self, address: int, words: Sequence[int]) -> None:
        """Words for a bus address and those behind it."""
        for at in range(0, len(words), WRITE_WORDS):
            part = [word & 0xFFFFFFFF for word in words[at : at + WRITE_WORDS]]
            self._request(Type.WRITE, write_body(address + at, part))

    def read_word(self, address: int) -> int:
        """The word at a bus address."""
        return self.read_words(address)[0]

    def write_word(self, address: int, word: int) -> None:
        """One word to a bus address."""
        self.write_words(address, [word])

    def _read(self, register: str) -> int:
        return self.read_word(REGISTER[register])

    def _neighbours(self, *registers: str) -> list[int]:
        """Registers that stand one behind the other, in one packet."""
        return self.read_words(REGISTER[registers[0]], len(registers))

    def _write(self, register: str, word: int, n: int = 0) -> None:
        self.write_word(REGISTER[register] + n, word)

    def _control(self, *bits: str) -> None:
        self._write("CONTROL", REGMAP.registers["CONTROL"].word(**dict.fromkeys(bits, 1)))

    # ------------------------------------------------------------------ run control
    def state(self) -> State:
        """The state now."""
        return State.of(*self._neighbours("STATUS", "PLACE"))

    def halt(self) -> None:
        """Hold the core after the bundle that issues now; without a run, at the first bundle of
        the next one. `wait` tells when it is halted."""
        self._control("halt")

    def resume(self) -> None:
        """Let bundles issue until the next breakpoint or watch."""
        self._control("resume")

    def step(self, bundles: int = 1, timeout: float | None = None) -> State:
        """Issue so many bundles one by one; each is written back before the next one.

        Returns the state behind: halted before the next bundle, or not running if the run has
        ended. Raises DebugError if the core is not halted.
        """
        state = self.state()
        for _ in range(bundles):
            if not state.halted:
                raise DebugError("a step needs a core that is halted inside a run; halt it first")
            self._control("step")
            state = self.wait(lambda now: now.halted or not now.running, timeout)
            if not state.running:
                break
        return state

    def abort(self) -> None:
        """End a run with the fault WATCHDOG: outputs take their safe values."""
        self._control("abort")

    def wait(self, until: Callable[[State], bool], timeout: float | None = None) -> State:
        """The first state seen for which `until` holds. Raises DebugError after `timeout` seconds
        (None: that of the client)."""
        seconds = self.timeout if timeout is None else timeout
        end = time.monotonic() + seconds
        while True:
            state = self.state()
            if until(state):
                return state
            if time.monotonic() > end:
                raise DebugError(f"not reached within {seconds:g} s; the state is {state}")
            self.link.pause()

    def set_mode(self, *, watchdog_runs: bool = False, stop_at_start: bool = False) -> None:
        """watchdog_runs: the watchdog counts while the core is halted, and ends the run with a
        fault; else it stands. stop_at_start: every run waits before its first bundle."""
        word = REGMAP.registers["MODE"].word(
            watchdog_runs=int(watchdog_runs), stop_at_start=int(stop_at_start)
        )
        self._write("MODE", word)

    # ------------------------------------------------------------------ breakpoints
    def set_breakpoint(self, bundle: int) -> int:
        """Hold the core before it issues this bundle; returns the breakpoint's number.

        Raises DebugError if all are taken, ValueError for an address that is none.
        """
        word = REGMAP.registers["BREAK"].word(value=bundle)
        number = self._free("breakpoints", self.sizes.breakpoints)
        self._write("BREAK", word, number)
        self._enable("breakpoints", number, True)
        return number

    def clear_breakpoint(self, number: int) -> None:
        """Free a breakpoint."""
        self._enable("breakpoints", number, False)

    def set_watch(self, place: str, value: int | None = None, mask: int = 0xFFFFFFFF) -> int:
        """Hold the core when a register ('a3', 'b0', 'c12') or output ('o2') is written, with
        `value` in the bits of `mask` (None: whatever is written); returns the watch's number.

        A watch sees the write-back: some bundles behind the one that made the value have issued
        by then. Raises DebugError if all are taken, ValueError for a place that is none.
        """
        letter, digits = place[:1].lower(), place[1:]
        if letter == "k":
            raise ValueError(f"'{place}': programs do not write bank K")
        place_address(place)
        bank = 3 if letter == "o" else BANKS.index(letter)
        number = self._free("watches", self.sizes.watches)
        word = REGMAP.registers["WATCH_PLACE"].word(bank=bank, index=int(digits))
        self._write("WATCH_PLACE", word, number)
        self._write("WATCH_MASK", 0 if value is None else mask, number)
        self._write("WATCH_VALUE", (value or 0) & mask, number)
        self._enable("watches", number, True)
        return number

    def clear_watch(self, number: int) -> None:
        """Free a watch."""
        self._enable("watches", number, False)

    def _enabled(self) -> dict[str, int]:
        word = self._read("ENABLE")
        return {name: f.of(word) for name, f in FIELDS["ENABLE"].items()}

    def _free(self, what: str, count: int) -> int:
        used = self._enabled()[what]
        for number in range(count):
            if not used >> number & 1:
                return number
        raise DebugError(f"all {count} {what} of the core are taken; clear one")

    def _enable(self, what: str, number: int, on: bool) -> None:
        bits = self._enabled()
        bits[what] = (bits[what] & ~(1 << number)) | (int(on) << number)
        self._write("ENABLE", REGMAP.registers["ENABLE"].word(**bits))

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
        if (core := configuration_of(self.read_word(CSR["CONFIG"]))) != image.configuration:
            raise DebugError(f"the program is for '{image.configuration}': give --config {core}")
        if self.state().running:
            raise DebugError("the core is inside a run; abort it, or let it end, before a load")
        self.write_word(CSR["CONTROL"], CLEAR)
        for address, words in _rows(load_words(image)):
            self.write_words(address, words)

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
        word = self._read("VERSION")
        return FIELDS["VERSION"]["page"].of(word), FIELDS["VERSION"]["run"].of(word)

    # ------------------------------------------------------------------ scope
    def configure(self, setup: ScopeSetup) -> None:
        """Set the scope up; it is frozen until `arm`. Raises ValueError (ScopeSetup.check)."""
        setup.check()
        self._control("freeze")
        trigger, registers = setup.trigger, REGMAP.registers
        type_name = setup.channels[trigger.channel].type
        words = [channel.word() for channel in setup.channels]
        self.write_words(REGISTER["CHANNEL"], words)
        last = len(setup.channels) - 1
        record = registers["RECORD"].word(last_channel=last, skip=setup.decimation - 1)
        kind = code("trigger_kind", trigger.kind)
        when = registers["TRIGGER"].word(
            kind=kind, channel=trigger.channel, float=int(type_name == "float")
        )
        low, high = word_of(trigger.low, type_name), word_of(trigger.high, type_name)
        around = registers["AROUND"].word(pre=setup.pre, post=setup.post)
        self.write_words(REGISTER["RECORD"], [record, when, low, high, around])
        self._setup = setup

    def arm(self) -> None:
        """Empty the ring and record from the next run on; over a serial line the records come by
        themselves from here on."""
        if self.link.streams:
            self._set_uart(stream=1)
        self._control("arm")
        self._taken = 0
        self._streamed.clear()

    def freeze(self) -> None:
        """Stop recording; the ring keeps what it has."""
        self._control("freeze")

    def trigger(self) -> None:
        """Trigger a scope that waits."""
        self._control("trigger")

    def triggered_at(self) -> int | None:
        """Number of the record that triggered, None if none has since `arm`."""
        return self._read("TRIGGERED_AT") if self.state().triggered else None

    def drain(self) -> Records:
        """Records since the last call, or since `arm`; `lost` are those that the ring or the
        line dropped. Raises DebugError before `configure`."""
        if self._setup is None:
            raise DebugError("configure the scope first")
        if self.link.streams:
            return self._drain_stream()
        total = self._read("RECORDS")
        first = max(self._taken, total - self._setup.capacity)
        words = self.ring(first, total - first)
        # What was overwritten while the ring was being read.
        gone = max(0, self._read("RECORDS") - self._setup.capacity - first)
        lost = first + min(gone, len(words)) - self._taken
        self._taken = total
        return Records(first + gone, words[gone:], lost)

    def ring(self, first: int, count: int) -> list[tuple[int, ...]]:
        """Records by number, out of the ring: after a fault or trigger, what is before it."""
        if self._setup is None:
            raise DebugError("configure the scope first")
        size, channels = self._setup.size, len(self._setup.channels)
        at, left, words = first * size % RING_WORDS, count * size, []
        while left:
            part = min(left, RING_WORDS - at)
            words += self.read_words(RING + at, part)
            at, left = 0, left - part
        return [tuple(words[n : n + channels]) for n in range(0, len(words), size)]

    def _drain_stream(self) -> Records:
        self.poll()
        parts, self._streamed = self._streamed, []
        if not parts:
            return Records(self._taken, [])
        # A gap ends what is returned now; the rest comes with the next call.
        words, first = list(parts[0].words), parts[0].first
        for n, part in enumerate(parts[1:], 1):
            if part.first != first + len(words):
                self._streamed = parts[n:] + self._streamed
                break
            words += part.words
        lost = first - self._taken
        self._taken = first + len(words)
        return Records(first, words, lost)

    # ------------------------------------------------------------------ packets
    def set_events(self, on: bool = True) -> None:
        """Over a serial line: whether the block tells changes of its state by itself."""
        self._set_uart(events=int(on))

    def _set_uart(self, **bits: int) -> None:
        word = self._read("UART")
        fields = {name: f.of(word) for name, f in FIELDS["UART"].items()} | bits
        self._write("UART", REGMAP.registers["UART"].word(**fields))

    def poll(self) -> None:
        """Take in what came unasked: events and records."""
        while (packet := self.link.receive(0.0)) is not None:
            self._unasked(packet)

    def _unasked(self, packet: Packet) -> None:
        if packet.type == Type.EVENT:
            self.events.append(event(packet.body))
        elif packet.type == Type.SAMPLES:
            first, words = samples(packet.body)
            self._streamed.append(Records(first, words))

    def _request(self, kind: Type, body: bytes) -> bytes:
        """Body of the answer. Raises LinkError, PacketError."""
        self._sequence = (self._sequence + 1) & 0xFF
        request = Packet(kind, self._sequence, body)
        for _ in range(TRIES):
            self.link.send(request)
            end = time.monotonic() + self.timeout
            while (packet := self.link.receive(max(0.0, end - time.monotonic()))) is not None:
                if packet.sequence != self._sequence or packet.type in (Type.SAMPLES, Type.EVENT):
                    self._unasked(packet)
                elif packet.type == Type.ERROR:
                    known = [c.name for c in ErrorCode if packet.body == bytes([c])]
                    raise PacketError(f"the block refused {request}: {known or packet.body.hex()}")
                elif packet.type == kind | 0x80:
                    return packet.body
        raise LinkError(
            f"no answer within {self.timeout:g} s, {TRIES} times; is the board powered, has it a "
            "debug block, and is the baud rate that of UART.divider? A core inside a run without "
            "end answers when it is halted"
        )


def _rows(writes: Iterable[tuple[int, int]]) -> Iterable[tuple[int, list[int]]]:
    """Writes put together where addresses follow each other."""
    start, words = 0, []
    for address, word in writes:
        if words and address != start + len(words):
            yield start, words
            words = []
        if not words:
            start = address
        words.append(word)
    if words:
        yield start, words
