# SPDX-License-Identifier: Apache-2.0
"""Campaigns on the core with its debug block, for tests and for the goals of the workbench."""

from __future__ import annotations

import functools
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from asip_asm.assemble import assemble
from asip_asm.image import Image
from sim.core.iss import Iss
from sim.debug.client import Client
from sim.debug.link import DirectLink
from sim.debug.model import DebugRtl
from sim.debug.state import Channel, ScopeSetup, State, word_of
from sim.rtl.asip_bus import BLOCK, CLEAR, CSR, START, STATUS, place_address
from tests.asip import core_bench
from tests.asip.test_core_random import Writer

PROGRAMS = Path(core_bench.ROOT) / "asip_asm/programs"
SHIPPED = ("tracking_optimised", "tracking_as_printed", "planner_scurve", "planner_trajectory")
BANKS = {"fast": "abc", "small": "ac", "stream": "abc"}
DATA = 32  # words of data memory compared
LIMIT = 200_000  # clocks of a run


@functools.cache
def model(configuration: str = "fast") -> DebugRtl:
    """The one model of a configuration."""
    return DebugRtl(configuration)


def loaded(image: Image) -> tuple[DebugRtl, Client]:
    """The fast model after a reset with a program, and a client."""
    rtl = model()
    rtl.reset()
    client = client_of(rtl)
    client.load(image)
    return rtl, client


def client_of(rtl: DebugRtl) -> Client:
    """A client in this process that lets few clocks pass at a time."""
    return Client(DirectLink(rtl, clocks=20))


@functools.cache
def shipped(name: str, configuration: str = "fast") -> Image:
    """A program of the project."""
    return assemble(PROGRAMS / f"{name}.s", configuration=configuration)


def written(seed: int, configuration: str = "fast") -> Image:
    """A random program: straight, or with branches, on a core with loops with loops."""
    rng = random.Random(seed)
    others = "loops" if configuration == "stream" else "branching"
    text = Writer(configuration, rng, "straight" if seed % 2 else others).text()
    return core_bench.assembled(text, configuration)


@dataclass(frozen=True)
class Final:
    """What a run leaves: registers, data, outputs, flags and fault, and its cycles."""

    words: tuple[int, ...]
    cycles: int

    def differences(self, other: Final) -> list[int]:
        """Places of the words that differ."""
        return [n for n, (a, b) in enumerate(zip(self.words, other.words, strict=True)) if a != b]


class Bench:
    """A loaded program whose runs all begin in one state."""

    def __init__(self, rtl: DebugRtl, image: Image, seed: int) -> None:
        self.rtl, self.image = rtl, image
        self.client = client_of(rtl)
        rtl.clear()
        rtl.load(image)
        rng = random.Random(seed)
        banks = BANKS[image.configuration]
        states = {s.register: int(s.bits, 16) for s in image.states}
        places = [f"{bank}{n}" for bank in banks for n in range(64)]
        self._words = [(place_address(p), states.get(p, 0)) for p in places]
        self._words += [
            (BLOCK["data"] + n, int(image.data[n], 16) if n < len(image.data) else 0)
            for n in range(DATA)
        ]
        for entry in image.inputs:
            value = word_of(_input(rng, entry.type), entry.type)
            self._words.append((BLOCK["constants"] + entry.index, value))
        self._read = [address for address, _ in self._words[: len(places) + DATA]]
        self.outcome = 1 + len(self._read)  # first word of outputs, cause and FAULT_INFO
        self._read += [BLOCK["outputs"] + o.index for o in image.outputs]

    def begin(self) -> None:
        """The state before a run, and its start."""
        for address, word in self._words:
            self.rtl.write(address, word)
        self.rtl.write(CSR["CONTROL"], CLEAR)
        self.rtl.write(CSR["CONTROL"], START)

    def finish(self) -> None:
        """Let the run end. Raises AssertionError if it does not."""
        for _ in range(LIMIT // 50):
            if not STATUS["busy"].of(self.rtl.read(CSR["STATUS"])):
                return
            self.rtl.clock(50)
        raise AssertionError("the run does not end")

    def faulted(self) -> bool:
        """Whether the last run ended in a fault."""
        return bool(STATUS["fault"].of(self.rtl.read(CSR["STATUS"])))

    def final(self) -> Final:
        """The state after a run."""
        words = [self.rtl.read(address) for address in self._read]
        status = self.rtl.read(CSR["STATUS"])
        words += [STATUS["cause"].of(status), self.rtl.read(CSR["FAULT_INFO"])]
        words.insert(0, STATUS["flags"].of(status))
        return Final(tuple(words), self.rtl.read(CSR["CYCLES"]))

    def undisturbed(self) -> Final:
        """A run that nothing stops."""
        self.begin()
        self.finish()
        return self.final()

    def disturbed(self, rng: random.Random) -> tuple[Final, int]:
        """A run that is halted, stepped and looked at; how often it was seen halted."""
        client, halts = self.client, 0
        slots = [
            client.set_breakpoint(rng.randrange(len(self.image.bundles)))
            for _ in range(rng.randrange(4))
        ]
        watches = []
        if rng.random() < 0.3:
            place = rng.choice(BANKS[self.image.configuration]) + str(rng.randrange(20))
            watches.append(client.set_watch(place))
        client.set_mode(stop_at_start=rng.random() < 0.2)
        if rng.random() < 0.2:
            client.halt()
        self.begin()
        for _ in range(rng.randrange(1, 25)):
            state = client.state()
            if not state.running:
                break
            halts += state.halted
            self._act(rng, state)
        for slot in slots:
            client.clear_breakpoint(slot)
        for watch in watches:
            client.clear_watch(watch)
        client.set_mode()
        client.resume()
        self.finish()
        client.resume()  # what a halt or step after the last bundle left
        return self.final(), halts

    def _act(self, rng: random.Random, state: State) -> None:
        client, act = self.client, rng.randrange(8)
        if act == 0:
            client.halt()
        elif act == 1:
            client.resume()
        elif act == 2:
            self.rtl.clock(rng.randrange(1, 60))
        elif not state.halted:
            self.rtl.clock(rng.randrange(1, 20))
        elif act == 3:
            client.step(rng.randrange(1, 6))
        elif act == 4:
            address = rng.choice(self._read[: 64 * len(BANKS[self.image.configuration]) + DATA])
            self.rtl.write(address, self.rtl.read(address))
        elif act == 5:
            # A word of program memory, as it is: the stages of fetch are filled again.
            offset, word = rng.choice(list(self.image.words()))
            self.rtl.write(BLOCK["program"] + offset, word)
        elif act == 6:
            self.rtl.read(BLOCK["outputs"] + rng.randrange(8))
        else:
            client.step()


def random_halts(sequences: int, seed: int, configuration: str = "fast") -> Iterator[str]:
    """Disturbed runs of shipped and random programs; yields what differed, "" for each that did
    not."""
    rtl = model(configuration)
    done, program = 0, 0
    while done < sequences:
        rng = random.Random(f"{seed} {program} {configuration}")
        name = SHIPPED[program // 4 % len(SHIPPED)] if program % 4 == 0 else ""
        image = shipped(name, configuration) if name else written(seed + program, configuration)
        bench = Bench(rtl, image, seed)
        want = bench.undisturbed()
        # Registers after a fault depend on how far the bundles after it got: outputs and cause.
        first = bench.outcome if bench.faulted() else 0
        for _ in range(25):
            got, halts = bench.disturbed(rng)
            done += 1
            places = [n for n in want.differences(got) if n >= first]
            text = f"seed {seed}, program {program} {name}, halts {halts}: words {places} differ"
            yield text if places else ""
            if places:
                return
        program += 1


def torn_pages(changes: int, seed: int) -> tuple[int, int, int]:
    """Live parameters under load: (changes, torn runs, runs with a wrong version).

    Sixteen parameters always have one value. A program adds their differences, so that an output
    is not zero when two of them differ, and writes the first one as its second output. Changes are
    staged and committed while runs follow each other without a pause.
    """
    rng = random.Random(seed)
    count = 16
    names = [f"p{n}" for n in range(count)]
    rows = ['.program "one value in many words"', ".input unused"]
    rows += [f".param {name} = 1.0" for name in names]
    rows += [".output torn, safe = 1.0", ".output value, safe = 0.0"]
    rows += ["  fadd a0, unused, zero"]
    for n in range(1, count):
        rows += [f"  fsub t{n}, p{n}, p{n - 1}", f"  fabs u{n}, t{n}"]
        rows += [f"  fadd s{n}, u{n}, {f's{n - 1}' if n > 1 else 'zero'}"]
    rows += [f"  mov torn, s{count - 1}", "  mov value, p0", "  halt", ""]
    image = core_bench.assembled("\n".join(rows))
    rtl, client = loaded(image)
    places = {c.name: c.index for c in image.constants}
    torn = wrong = 0
    values = {client.version()[0]: 0x3F800000}
    for _ in range(changes):
        word = rng.randrange(0x3F800000, 0x40000000)
        rtl.write(CSR["CONTROL"], START)
        rtl.clock(rng.randrange(0, 8))
        order = rng.sample(names, count)
        client.stage((places[name], word) for name in order)
        rtl.write(CSR["CONTROL"], START)
        rtl.clock(rng.randrange(0, 40))
        before = client.version()[0]
        client.commit()
        values[(before + 1) & 0xFFFF] = word
        for _ in range(2):
            rtl.write(CSR["CONTROL"], START)  # ignored inside a run
            while STATUS["busy"].of(rtl.read(CSR["STATUS"])):
                rtl.clock(rng.randrange(1, 10))
            torn += rtl.read(BLOCK["outputs"]) != 0
            wrong += rtl.read(BLOCK["outputs"] + 1) != values.get(client.version()[1])
        wrong += client.version() != ((before + 1) & 0xFFFF,) * 2
    return changes, torn, wrong


def recorded(ticks: int, seed: int, name: str = "planner_trajectory") -> Iterator[tuple[int, int]]:
    """Words of eight channels of a shipped program's ticks: as the scope recorded, as the
    instruction-set model computes. Channels: outputs, an input, writes of registers by number."""
    rng = random.Random(seed)
    image = shipped(name)
    rtl, client = loaded(image)
    iss = Iss(image, sincos=core_bench.rtl_sincos, trace=True)
    inputs = {e.name: e for e in image.inputs}

    def values() -> dict[str, int]:
        return {n: word_of(_input(rng, e.type), e.type) for n, e in inputs.items()}

    def tick(words: dict[str, int]) -> dict[str, list[int]]:
        for entry, word in words.items():
            rtl.write(BLOCK["constants"] + inputs[entry].index, word)
        iss.set_words(words)
        rtl.write(CSR["CONTROL"], START)
        while STATUS["busy"].of(rtl.read(CSR["STATUS"])):
            rtl.clock(10)
        return iss.run().writes

    writes = tick(values())
    registers = [p for p in writes if p[0] in "abc" and len(writes[p]) < 16]
    outputs = [p for p in writes if p[0] == "o"]
    chosen = [(p, rng.randrange(0, len(writes[p]) + 1)) for p in rng.sample(registers, 5)]
    entry = rng.choice(list(inputs))
    channels = [(p, 0) for p in rng.sample(outputs, min(2, len(outputs)))] + chosen
    channels = [*channels[:7], (f"k{inputs[entry].index}", 0)]
    client.configure(ScopeSetup(tuple(Channel(p, w) for p, w in channels)))
    client.arm()
    for _ in range(ticks):
        words = values()
        writes = tick(words)
        rtl.clock(12)  # the record follows the run
        (record,) = client.drain().words
        for (place, write), got in zip(channels, record, strict=True):
            want = words[entry] if place[0] == "k" else writes[place][write - 1]
            yield got, want


def _input(rng: random.Random, type_name: str) -> float:
    return rng.uniform(0.1, 0.9) if type_name == "float" else rng.randrange(1, 1000)
