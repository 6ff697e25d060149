# SPDX-License-Identifier: Apache-2.0
"""Test programs for the Nios II core: constrained random ones, corner operands, accesses."""

from __future__ import annotations

import random
import struct
from collections.abc import Sequence

from sim.harness.n2_lockstep_isa import OP_CUSTOM
from sim.harness.n2_lockstep_program import BT, ISA, Program, prologue
from sim.harness.n2_lockstep_rtl import DTCM, ITCM

# RAM for QEMU, behind the Avalon master for the core.
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


def random_program(seed: int, length: int = 1500) -> Program:
    """Every instruction but custom, in random order, with loops, calls, exceptions and hazards.

    Registers r1 to r15 are free; few of them are used at a time, so that results are consumed soon.
    Ends by itself: backward branches count down. The seed decides everything.
    """
    rng = random.Random(seed)
    program = prologue()
    for register, base in BASES.items():
        program.li(register, base)
    for register in range(1, 16):
        program.li(register, rng.choice((rng.choice(CORNERS), rng.getrandbits(32))))
    program.emit("wrctl", ISA.control["ienable"], rng.randrange(16))
    for _, base in sorted(BASES.items()):
        block = bytes(rng.getrandbits(8) for _ in range(256))
        program.data.append((base - 128, block))

    alu = [i for i in ISA.instructions.values() if i.unit in ("alu", "shift", "mul", "div")]
    memory = [i for i in ISA.instructions.values() if i.unit in ("load", "store")]
    branches = [i for i in ISA.instructions.values() if i.unit == "branch" and i.name != "br"]
    caches = [i for i in ISA.instructions.values() if i.unit == "cache"]
    readable = [number for name, number in ISA.control.items() if name != "status"]
    writable = [ISA.control[n] for n in ("status", "estatus", "bstatus", "ienable", "badaddr")]
    ignored = [ISA.control[n] for n in ("ipending", "cpuid")]
    functions = [f"f{i}" for i in range(4)]
    pool = list(range(1, 16))
    counter = 0

    def source() -> int:
        return rng.choice(pool) if rng.random() < 0.9 else rng.randrange(32)

    def target() -> int:
        return rng.choice(pool) if rng.random() < 0.97 else 0

    def operation() -> None:
        record = rng.choices((rng.choice(alu), rng.choice(memory)), (3, 2))[0]
        values: list[int] = []
        if record in memory:
            size = {"w": 4, "h": 2, "b": 1}[record.name[2]]
            spread = 128 if rng.random() < 0.6 else 16
            offset = rng.randrange(-spread, spread)
            if rng.random() < 0.96:
                offset -= offset % size
            register = target() if record.unit == "load" else source()
            program.emit(record.name, register, offset, rng.choice(list(BASES)))
            return
        if record.unit == "div" and rng.random() < 0.6:
            record = rng.choice(alu)  # a division takes long; its operands are often bad
        for kind in record.operands:
            if kind in "abc":
                destination = kind == ("c" if record.opx is not None else "b")
                values.append(target() if destination else source())
            elif kind == "i5":
                values.append(rng.choice((0, 1, 31, rng.randrange(32))))
            elif kind == "s16":
                values.append(rng.choice((-32768, -1, 0, 1, 32767, rng.randrange(-99, 99))))
            else:
                values.append(rng.choice((0, 1, 0x8000, 0xFFFF, rng.getrandbits(16))))
        program.emit(record.name, *values)

    def skip_over(emit_branch, most: int = 6) -> None:
        nonlocal counter
        counter += 1
        emit_branch(f"skip{counter}")
        for _ in range(rng.randrange(most)):
            operation()
        program.label(f"skip{counter}")

    def jump(name: str, label: str) -> None:
        program.la(POINTER, label)
        for _ in range(rng.randrange(3)):
            operation()
        if rng.random() < 0.15:
            program.emit("addi", POINTER, POINTER, rng.choice((1, 2, 3)))  # misaligned target
        program.emit(name, POINTER)

    def anything() -> None:
        nonlocal counter
        kind = rng.random()
        if kind < 0.70:
            operation()
        elif kind < 0.82:
            record = rng.choice(branches)
            skip_over(lambda label: program.to(record.name, label, source(), source()))
        elif kind < 0.84:
            name = rng.choice(("br", "jmpi"))
            skip_over(lambda label: program.to(name, label))
        elif kind < 0.86:
            skip_over(lambda label: jump("jmp", label))
        elif kind < 0.88:
            label = rng.choice(functions)
            if rng.random() < 0.5:
                program.to("call", label)
            else:
                jump("callr", label)
        elif kind < 0.90:
            counter += 1
            program.emit("addi", COUNTER, 0, rng.randrange(1, 6))
            program.label(f"loop{counter}")
            name = f"loop{counter}"
            for _ in range(rng.randrange(1, 8)):
                operation()
            if rng.random() < 0.5:
                record = rng.choice(branches)
                skip_over(lambda label: program.to(record.name, label, source(), source()))
            program.emit("addi", COUNTER, COUNTER, -1)
            program.to("bne", name, COUNTER, 0)
        elif kind < 0.91:
            program.emit("trap", rng.randrange(32))
        elif kind < 0.92:
            program.emit("addi", BT, 0, 1)
            program.emit("break", rng.choice((0, 2, 31)))
        elif kind < 0.93:
            program.word(_reserved_words(rng))
        elif kind < 0.95:
            program.emit("rdctl", target(), rng.choice(readable))
        elif kind < 0.97:
            number = rng.choice(writable + ignored)
            register = rng.randrange(16)
            if number == ISA.control["status"] or number in writable[1:3]:
                program.emit("andi", POINTER, register, 1)  # other bits: not in a minimum core
                register = POINTER
            program.emit("wrctl", number, register)
        elif kind < 0.99:
            record = rng.choice(caches)
            values = {"a": rng.choice(list(BASES)), "s16": 4 * rng.randrange(8)}
            program.emit(record.name, *(values[k] for k in record.operands))
        else:
            program.emit("nextpc", target())

    while len(program.words) < length:
        if rng.random() < 0.05:
            pool = rng.sample(range(1, 16), rng.choice((2, 4, 8, 15)))
        anything()
    program.end()
    for label in functions:
        program.label(label)
        for _ in range(rng.randrange(8)):
            operation()
        if rng.random() < 0.3:
            program.emit("trap", 1)
        program.emit("ret")
    return program


def corner_program(corners: Sequence[int] = CORNERS) -> Program:
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


def access_program() -> Program:
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
