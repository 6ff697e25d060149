# SPDX-License-Identifier: Apache-2.0
"""Random programs on the core against the instruction-set model (environment: SEED=n).

Sources are assembly text, so that a failure leaves one below build/asip that asip-run takes. Few
registers and any words, so that hazards and special values are frequent.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field, replace

import pytest

from asip_asm.isa import STREAM_PINS
from sim.core.iss import Iss
from tests.asip import core_bench as bench
from tests.asip.core_bench import CORNERS, ISA
from tests.bench.seed import SEED

STRAIGHT, BRANCHING = 40, 40  # programs of each kind and configuration
BUNDLES = 90
INSTRUCTIONS = {"fast": 10_000, "small": 5_000}  # executed at least, all programs together
REGISTERS = (8, 20)  # of each bank in use: many hazards, or few and collisions at the write port
DATA_WORDS = 16
STREAM_WORDS = 12  # few, so that seeks are frequent
EVERY = [op.name for op in ISA.of_unit("lanes") if op.every]
FMA = [name for name, record in ISA.operations.items() if record.unit == "fma"]
AUX = [
    name
    for name, record in ISA.operations.items()
    if record.writes and ISA.units[record.unit].bank != "pipe" and name != "ld"
]
# Operations whose result is finite whatever they read, as outputs must be.
FINITE = ("feq", "flt", "fle", "i2f")
# Beyond those registers: an index into data memory, a loop counter, constants for both.
INDEX, COUNTER = ("c60", "c61"), "c62"
MINUS_ONE, SMALL = "k100", ("k101", "k102", "k103")


@dataclass
class Writer:
    """Text of one program, `kind` 'straight', 'branching' or 'loops' (those of the core)."""

    configuration: str
    rng: random.Random
    kind: str
    rows: list[str] = field(default_factory=list)
    outputs: int = 0
    labels: int = 0
    registers: int = 0
    places: dict[str, int] = field(default_factory=dict)  # of the next word of each stream

    def __post_init__(self) -> None:
        self.sought: tuple[str, int] | None = None
        self.depth = 0
        self.vectors: dict[str, set[str]] = {"a": set(), "b": set()}  # registers written as such
        self.registers = self.rng.choice(REGISTERS)

    def text(self) -> str:
        banks = "ac" if self.configuration == "small" else "abc"
        states = [f"{bank}{i}" for bank in banks for i in range(self.registers)]
        while len(self.rows) < BUNDLES:
            self.step()
        head = [f'.program "random {SEED}"', f".config {self.configuration}", ".watchdog 50000"]
        head += [f".state s_{name} : int = 0x{self.word():08x}, pin {name}" for name in states]
        head += [f".state s_{name} : int = {self.rng.randrange(4)}, pin {name}" for name in INDEX]
        head += [f".state s_{COUNTER} : int = 0, pin {COUNTER}"]
        head += [f".const k{i} = 0x{self.word():08x} : int" for i in range(self.registers)]
        integers = zip((MINUS_ONE, *SMALL), (-1, 1, 2, 3), strict=True)
        head += [f".const {name} = {value} : int" for name, value in integers]
        head += [f".output out{i}, safe = {i}.5" for i in range(self.outputs)]
        words = ", ".join(f"0x{self.finite():08x}" for _ in range(DATA_WORDS))
        head += [f".data : int = {words}"]
        if self.configuration == "wide":
            for pin in STREAM_PINS:
                count = STREAM_WORDS * ISA.lanes_of_a_vector
                values = ", ".join(f"0f{self.finite():08x}" for _ in range(count))
                head += [f".vectors s{pin}, pin {pin} = {values}"]
        if self.configuration == "stream":
            for pin in STREAM_PINS:
                values = ", ".join(f"0f{self.finite():08x}" for _ in range(STREAM_WORDS))
                head += [f".stream s{pin}, pin {pin} = {values}"]
        return "\n".join([*head, *self.rows, "{ nop } halt", ""])

    def word(self) -> int:
        """Corner, any bits, or a number near 1."""
        kind = self.rng.random()
        if kind < 0.12:
            return self.rng.choice(CORNERS)
        if kind < 0.2:
            return self.rng.getrandbits(32)
        return self.rng.getrandbits(1) << 31 | self.rng.randrange(0x3E000000, 0x42000000)

    def finite(self) -> int:
        word = self.word()
        return word & ~0x00800000 if word >> 23 & 0xFF == 0xFF else word

    def source(self) -> str:
        banks = "aaaccck" if self.configuration == "small" else "aaabbbccck"
        bank = self.rng.choice(banks)
        if self.rng.random() < 0.03:
            return "zero"
        return f"{bank}{self.rng.randrange(self.registers)}"

    def sources(self, mnemonic: str) -> list[str]:
        names = [self.source() for _ in ISA.operations[mnemonic].sources]
        while mnemonic == "fsat" and all(name[0] in "kz" for name in names[1:]):
            names[2] = self.source()  # two constants may be crossed, which is an error
        return names

    def operand(self, known: list[str]) -> str:
        """Of an operation on vectors: one of these, or a word that is no register of a pipe."""
        word = self.rng.choice(["zero", f"k{self.rng.randrange(self.registers)}",
                                f"c{self.rng.randrange(self.registers)}"])  # fmt: skip
        return self.rng.choice(known) if self.rng.random() < 0.6 else word

    def vector(self, bank: str) -> str:
        """A vector operation, or one that takes a lane of a register with a vector."""
        known, dst = sorted(self.vectors[bank]), f"{bank}{self.rng.randrange(self.registers)}"
        pin = bank.upper()
        if known and self.rng.random() < 0.5:
            lane = self.rng.randrange(ISA.lanes_of_a_vector)
            return f"vout {dst}, {self.source()}, {self.rng.choice(known)}, {lane}"
        if known and self.rng.random() < 0.5:
            mnemonic = self.rng.choice(EVERY)
            record = ISA.operations[mnemonic]
            names = [self.operand(known) for _ in record.sources]
            vector = self.rng.choice(record.sources) if record.vector is None else record.vector
            names[record.sources.index(vector)] = self.rng.choice(known)
            self.vectors[bank].add(dst)
            return f"{mnemonic} {dst}, {', '.join(names)}"
        if self.places.get(pin, STREAM_WORDS) == STREAM_WORDS:
            return self.line("fmul", dst)
        self.places[pin] += 1
        addend = self.rng.choice([*known, "zero"])
        self.vectors[bank].add(dst)
        if self.rng.random() < 0.3:
            return f"vfmul {dst}, {pin}+, {self.source()}"
        return f"vfmadd {dst}, {pin}+, {self.source()}, {addend}"

    def fma(self, bank: str) -> str:
        if self.configuration == "wide" and self.rng.random() < 0.5:
            return self.vector(bank)
        mnemonic = self.rng.choice(FMA)
        line = self.line(mnemonic, f"{bank}{self.rng.randrange(self.registers)}")
        pin = bank.upper()
        if self.places.get(pin, STREAM_WORDS) == STREAM_WORDS or self.rng.random() < 0.3:
            return line
        self.places[pin] += 1
        dst, *sources = line.split(", ")
        sources[self.rng.randrange(len(sources))] = f"{pin}+"
        return ", ".join([dst, *sources])

    def line(self, mnemonic: str, dst: str) -> str:
        return f"{mnemonic} {', '.join([dst, *self.sources(mnemonic)])}"

    def address(self) -> str:
        # index 0..3, immediate 0..12: always inside the data, the last word is never stored to
        index = self.rng.choice(("", f"[{self.rng.choice(INDEX)}]"))
        return f"{self.rng.randrange(DATA_WORDS - 4)}{index}"

    def aux(self) -> str:
        if self.configuration in ("stream", "wide") and self.rng.random() < 0.15:
            return self.seek()
        kind = self.rng.random()
        dst = f"c{self.rng.randrange(self.registers)}"
        if kind < 0.08:
            return f"ld {dst}, {self.address()}"
        if kind < 0.14:
            return f"st {self.source()}, {self.address()}"
        if kind < 0.18:
            return f"mov {self.rng.choice(INDEX)}, {self.rng.choice(('zero', *SMALL))}"
        # every unit as often as any other, not every operation
        unit = self.rng.choice(("cmp", "cmp", "cmp", "divsqrt", "divsqrt", "i2f", "f2i", "sincos"))
        if unit == "sincos" and self.rng.random() < 0.5:
            unit = "cmp"
        return self.line(self.rng.choice([n for n in AUX if ISA.operations[n].unit == unit]), dst)

    def seek(self) -> str:
        """Sets a stream; words taken in the same bundle are those before it."""
        pin = self.rng.choice(STREAM_PINS)
        self.sought = pin, self.rng.randrange(STREAM_WORDS)
        return f"seek {pin}+{self.sought[1]}"

    def output(self) -> str:
        self.outputs += 1
        if self.rng.random() < 0.2:
            return f"ld o{self.outputs - 1}, {DATA_WORDS - 1}"  # a word that no store reaches
        return self.line(self.rng.choice(FINITE), f"o{self.outputs - 1}")

    def bundle(self, aux: str | None = None) -> str:
        """Bundle with a given auxiliary operation, or a random one."""
        if self.configuration == "small":
            return f"{{ {aux or (self.fma('a') if self.rng.random() < 0.5 else self.aux())} }}"
        slots = [self.fma(bank) for bank in "ab" if self.rng.random() < 0.7]
        if aux or self.rng.random() < 0.7:
            slots.append(aux or self.aux())
        if self.sought is not None:
            pin, self.places[pin] = self.sought
            self.sought = None
        self.rng.shuffle(slots)
        return f"{{ {' | '.join(slots) or 'nop'} }}"

    def step(self) -> None:
        kind = self.rng.random()
        if kind < 0.06 and self.outputs < ISA.outputs and not self.depth:
            self.rows.append(self.bundle(self.output()))
        elif kind > 0.97:
            self.rows += ["{ nop }"] * self.rng.randrange(1, 12)
        elif self.kind == "loops" and kind < 0.14 and self.depth < 3:
            self.rounds()
        elif self.kind == "branching" and kind < 0.14:
            self.branch()
        elif self.kind == "branching" and kind < 0.18:
            self.loop()
        else:
            self.rows.append(self.bundle())

    def label(self) -> str:
        self.labels += 1
        return f"L{self.labels}"

    def branch(self) -> None:
        """Forward over a few bundles, taken or not."""
        label = self.label()
        condition = self.rng.choice((self.source(), "zero", COUNTER))
        self.rows.append(self.bundle(f"{self.rng.choice(('bz', 'bnz'))} {condition}, {label}"))
        self.rows += [self.bundle() for _ in range(self.rng.randrange(0, 4))]
        self.rows.append(f"{label}:\n{self.bundle()}")

    def loop(self) -> None:
        """A few rounds, counted down by an integer in c22; jumps over a bundle on the way out."""
        label, out = self.label(), self.label()
        self.rows.append(self.bundle(f"mov {COUNTER}, {self.rng.choice(SMALL)}"))
        self.rows.append(f"{label}:\n{self.bundle()}")
        self.rows += [self.bundle() for _ in range(self.rng.randrange(0, 4))]
        self.rows.append(self.bundle(f"iadd {COUNTER}, {COUNTER}, {MINUS_ONE}"))
        if self.rng.random() < 0.5:
            self.rows.append(self.bundle(f"bnz {COUNTER}, {label}"))
        else:
            self.rows.append(self.bundle(f"bz {COUNTER}, {out}"))
            self.rows.append(self.bundle(f"jmp {label}"))
        self.rows.append(f"{out}:\n{self.bundle()}")

    def rounds(self) -> None:
        """A loop of the core. Each body seeks the streams that it takes words of."""
        self.rows.append(self.bundle(f"loop {self.rng.choice((1, 2, 2, 3, 7))}"))
        self.depth += 1
        self.places.clear()
        for _ in range(self.rng.randrange(1, 6)):
            self.step()
        self.places.clear()
        self.depth -= 1
        self.rows.append("endloop")


def check(configuration: str, kind: str, number: int) -> int:
    """One program; a failure names the seed and the source. Returns operations executed."""
    rng = random.Random(f"{SEED} {configuration} {kind} {number}")
    text = Writer(configuration, rng, kind).text()
    program = bench.assembled(text)
    hint = f"SEED={SEED}, {configuration} {kind} program {number}"
    got = bench.verify(program, hint, timing=kind != "branching")
    operations = [sum(op is not None for op in item.slots) for item in bench.decoded(program)]
    return sum(operations[address] for address in got.bundle_order)


def test_random_programs__words_flags_outputs_and_cycles_of_the_model(configuration):
    print(f"SEED={SEED}")
    executed = sum(check(configuration, "straight", number) for number in range(STRAIGHT))
    executed += sum(check(configuration, "branching", number) for number in range(BRANCHING))
    print(f"{executed} instructions")
    assert executed >= INSTRUCTIONS[configuration]


@pytest.mark.full
def test_random_programs__many__words_flags_outputs_and_cycles_of_the_model(configuration):
    print(f"SEED={SEED}")
    for number in range(1000, 1800):
        check(configuration, "straight" if number % 2 else "branching", number)


UNTRACED = [("fast", "straight"), ("fast", "branching"), ("small", "branching")]
UNTRACED += [("stream", "loops"), ("wide", "straight"), ("wide", "loops")]


@pytest.mark.parametrize(("configuration", "kind"), UNTRACED)
def test_model_without_trace__compiles_its_bundles__does_what_the_traced_one_does(
    configuration, kind
):
    """The traced model, which never compiles a bundle, is the one that the core is compared with.
    Bundles are compiled when they run again.
    """
    registers = [f"{bank}{i}" for bank in "abc" for i in range(64)]
    places = [*registers, *(f"d{i}" for i in range(DATA_WORDS))]
    lanes = range(1, 1 + ISA.configurations[configuration].lanes)
    places += [f"{place}.{lane}" for place in registers for lane in lanes]
    print(f"SEED={SEED}")
    for number in range(4):
        rng = random.Random(f"{SEED} {configuration} {kind} {number}")
        program = bench.assembled(Writer(configuration, rng, kind).text())
        traced, untraced = (Iss(program, trace=trace) for trace in (True, False))
        for run in range(4):
            wanted, got = replace(traced.run(), writes={}), untraced.run()
            where = f"SEED={SEED}, {configuration} {kind} program {number}, run {run}"
            assert got == wanted, where
            words = [[iss.read_place(place) for place in places] for iss in (traced, untraced)]
            assert words[0] == words[1], where
            assert traced.stream_places == untraced.stream_places, where
