# SPDX-License-Identifier: Apache-2.0
"""Test programs for the Nios II core: constrained random ones, corner operands, accesses."""

from __future__ import annotations

import random
import struct
from collections.abc import Callable, Sequence

from sim.rtl.n2_lockstep_isa import OP_CUSTOM
from sim.rtl.n2_lockstep_program import BT, ISA, LabelledWords, prologue
from sim.rtl.n2_lockstep_rtl import DTCM, ITCM

# RAM for QEMU, after the Avalon master for the core.
AVALON_RAM = 0x1100_0000
CORNERS = (
    0,
    1,
    2,
    3,
    31,
    32,
    0x7FFF,
    0x8000,
    0xFFFF,
    0x10000,
    0x5555_5555,
    0x7FFF_FFFF,
    0x8000_0000,
    0x8000_0001,
    0xAAAA_AAAA,
    0xFFFF_8000,
    0xFFFF_FFFE,
    0xFFFF_FFFF,
)
# Registers the programs' frame needs for itself.
BASES = {16: DTCM + 0x8000, 17: ITCM + 0xE000, 18: AVALON_RAM + 0x8000}
COUNTER, POINTER = 20, 21


def _reserved_words(rng: random.Random) -> int:
    """A word with a reserved opcode, or the shadow register instructions."""
    while True:
        word = rng.getrandbits(32)
        if rng.random() < 0.5:
            word = word & ~0x3F | 0x3A
        record = ISA.find(word)
        if record is None or record.unit == "illegal":
            return word


def _of_units(*units: str) -> list:
    return [record for record in ISA.instructions.values() if record.unit in units]


ALU = _of_units("alu", "shift", "mul", "div")
MEMORY, CACHES = _of_units("load", "store"), _of_units("cache")
BRANCHES = [record for record in _of_units("branch") if record.name != "br"]
READABLE = [number for name, number in ISA.control.items() if name != "status"]
STATUSES = [ISA.control[name] for name in ("status", "estatus", "bstatus")]
WRITABLE = [*STATUSES, *(ISA.control[n] for n in ("ienable", "badaddr", "ipending", "cpuid"))]
FUNCTIONS = ("f0", "f1", "f2", "f3")


class _Random:
    """A random program under way; every choice is drawn from `rng`, in the order written here."""

    def __init__(self, rng: random.Random) -> None:
        self.rng, self.program = rng, prologue()
        self.pool = list(range(1, 16))  # registers in use
        self.labels = 0
        for register, base in BASES.items():
            self.program.li(register, base)
        for register in range(1, 16):
            self.program.li(register, rng.choice((rng.choice(CORNERS), rng.getrandbits(32))))
        self.program.emit("wrctl", ISA.control["ienable"], rng.randrange(16))
        for _, base in sorted(BASES.items()):
            block = bytes(rng.getrandbits(8) for _ in range(256))
            self.program.data.append((base - 128, block))

    def source(self) -> int:
        rng = self.rng
        return rng.choice(self.pool) if rng.random() < 0.9 else rng.randrange(32)

    def target(self) -> int:
        return self.rng.choice(self.pool) if self.rng.random() < 0.97 else 0

    def new_label(self, name: str) -> str:
        self.labels += 1
        return f"{name}{self.labels}"

    def operation(self) -> None:
        record = self.rng.choices((self.rng.choice(ALU), self.rng.choice(MEMORY)), (3, 2))[0]
        if record in MEMORY:
            self.access(record)
            return
        if record.unit == "div" and self.rng.random() < 0.6:
            record = self.rng.choice(ALU)  # a division takes long; its operands are often bad
        self.program.emit(record.name, *(self.operand(record, kind) for kind in record.operands))

    def operations(self, below: int, least: int = 0) -> None:
        for _ in range(self.rng.randrange(least, below)):
            self.operation()

    def access(self, record) -> None:
        size = {"w": 4, "h": 2, "b": 1}[record.name[2]]
        spread = 128 if self.rng.random() < 0.6 else 16
        offset = self.rng.randrange(-spread, spread)
        if self.rng.random() < 0.96:
            offset -= offset % size
        register = self.target() if record.unit == "load" else self.source()
        self.program.emit(record.name, register, offset, self.rng.choice(list(BASES)))

    def operand(self, record, kind: str) -> int:
        rng = self.rng
        if kind in "abc":
            destination = kind == ("c" if record.opx is not None else "b")
            return self.target() if destination else self.source()
        if kind == "i5":
            return rng.choice((0, 1, 31, rng.randrange(32)))
        if kind == "s16":
            return rng.choice((-32768, -1, 0, 1, 32767, rng.randrange(-99, 99)))
        return rng.choice((0, 1, 0x8000, 0xFFFF, rng.getrandbits(16)))

    def over(self, emit_branch: Callable[[str], None]) -> None:
        """A branch over some operations."""
        label = self.new_label("skip")
        emit_branch(label)
        self.operations(6)
        self.program.label(label)

    def jump(self, name: str, label: str) -> None:
        self.program.la(POINTER, label)
        self.operations(3)
        if self.rng.random() < 0.15:
            misaligned = self.rng.choice((1, 2, 3))
            self.program.emit("addi", POINTER, POINTER, misaligned)
        self.program.emit(name, POINTER)

    def branch(self) -> None:
        name = self.rng.choice(BRANCHES).name
        self.over(lambda label: self.program.to(name, label, self.source(), self.source()))

    def direct(self) -> None:
        name = self.rng.choice(("br", "jmpi"))
        self.over(lambda label: self.program.to(name, label))

    def call(self) -> None:
        label = self.rng.choice(FUNCTIONS)
        if self.rng.random() < 0.5:
            self.program.to("call", label)
        else:
            self.jump("callr", label)

    def loop(self) -> None:
        label = self.new_label("loop")
        self.program.emit("addi", COUNTER, 0, self.rng.randrange(1, 6))
        self.program.label(label)
        self.operations(8, least=1)
        if self.rng.random() < 0.5:
            self.branch()
        self.program.emit("addi", COUNTER, COUNTER, -1)
        self.program.to("bne", label, COUNTER, 0)

    def breaks(self) -> None:
        self.program.emit("addi", BT, 0, 1)
        self.program.emit("break", self.rng.choice((0, 2, 31)))

    def write_control(self) -> None:
        number, register = self.rng.choice(WRITABLE), self.rng.randrange(16)
        if number in STATUSES:
            self.program.emit("andi", POINTER, register, 1)  # other bits: not in a minimum core
            register = POINTER
        self.program.emit("wrctl", number, register)

    def cache(self) -> None:
        record = self.rng.choice(CACHES)
        values = {"a": self.rng.choice(list(BASES)), "s16": 4 * self.rng.randrange(8)}
        self.program.emit(record.name, *(values[kind] for kind in record.operands))


# What a random number below the limit gives, the first that holds.
KINDS = (
    (0.70, _Random.operation),
    (0.82, _Random.branch),
    (0.84, _Random.direct),
    (0.86, lambda made: made.over(lambda label: made.jump("jmp", label))),
    (0.88, _Random.call),
    (0.90, _Random.loop),
    (0.91, lambda made: made.program.emit("trap", made.rng.randrange(32))),
    (0.92, _Random.breaks),
    (0.93, lambda made: made.program.word(_reserved_words(made.rng))),
    (0.95, lambda made: made.program.emit("rdctl", made.target(), made.rng.choice(READABLE))),
    (0.97, _Random.write_control),
    (0.99, _Random.cache),
    (1.00, lambda made: made.program.emit("nextpc", made.target())),
)


def random_program(seed: int, length: int = 1500) -> LabelledWords:
    """Every instruction but custom, in random order, with loops, calls, exceptions and hazards.

    Registers r1 to r15 are free; few of them are used at a time, so that results are consumed soon.
    Ends by itself: backward branches count down. The seed decides everything.
    """
    rng = random.Random(seed)
    made = _Random(rng)
    program = made.program
    while len(program.words) < length:
        if rng.random() < 0.05:
            made.pool = rng.sample(range(1, 16), rng.choice((2, 4, 8, 15)))
        kind = rng.random()
        next(emit for below, emit in KINDS if kind < below)(made)
    program.end()
    for label in FUNCTIONS:
        program.label(label)
        made.operations(8)
        if rng.random() < 0.3:
            program.emit("trap", 1)
        program.emit("ret")
    return program


def corner_program(corners: Sequence[int] = CORNERS) -> LabelledWords:
    """Every arithmetic instruction with every pair of corner operands, immediates likewise."""
    program = prologue()
    two = [i for i in ISA.instructions.values() if i.operands == ("c", "a", "b")]
    two = [i for i in two if i.op != OP_CUSTOM and i.unit != "illegal"]
    program.data.append((DTCM, struct.pack(f"<{len(corners)}I", *corners)))
    first, last, inner, a, b = 10, 11, 12, 2, 3
    program.li(first, DTCM)
    program.li(last, DTCM + 4 * len(corners))
    program.label("outer")
    program.emit("ldw", a, 0, first)
    program.li(inner, DTCM)
    program.label("inner")
    program.emit("ldw", b, 0, inner)
    for record in two:
        program.emit(record.name, 4, a, b)
    for record in (i for i in ISA.instructions.values() if i.unit == "branch" and i.name != "br"):
        label = f"{record.name}{len(program.words)}"
        program.to(record.name, label, a, b)
        program.emit("addi", 5, 5, 1)
        program.label(label)
    program.emit("addi", inner, inner, 4)
    program.to("bne", "inner", inner, last)
    for record in ISA.instructions.values():
        if record.unit in ("alu", "shift", "mul") and record.opx is None:
            edges = (-32768, -1, 0, 1, 32767) if "s16" in record.operands else (0, 1, 32768, 65535)
        elif record.operands == ("c", "a", "i5"):
            edges = (0, 1, 7, 8, 16, 30, 31)
        else:
            continue
        for value in edges:
            program.emit(record.name, 4, a, value)
    program.emit("addi", first, first, 4)
    program.to("bne", "outer", first, last)
    program.end()
    return program


def access_program() -> LabelledWords:
    """Every load and store at every byte of a word in all memories, misaligned ones included."""
    program = prologue()
    for register, base in BASES.items():
        program.li(register, base)
        program.data.append((base - 8, bytes((37 * i + 0x81) & 0xFF for i in range(32))))
    program.li(3, 0x8091_A2B3)
    for record in ISA.instructions.values():
        for base in BASES:
            for offset in (-4, -3, -2, -1, 4, 5, 6, 7) if record.unit in ("load", "store") else ():
                if record.unit == "store":
                    program.emit(record.name, 3, offset, base)
                    program.emit("ldw", 2, offset & ~3, base)
                    program.emit("roli", 3, 3, 5)
                else:
                    program.emit(record.name, 2, offset, base)
                    program.emit("add", 5, 2, 2)
    program.end()
    return program
