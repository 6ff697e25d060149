# SPDX-License-Identifier: Apache-2.0
"""Random sequences of packets against a model of what they must do.

The model executes four instructions and knows the manual's words for each packet. What a packet
acknowledges must be true when the next packet acts: a write before a reset, a register before a
step, a breakpoint before a continue.
"""

from __future__ import annotations

import random
import struct

import pytest

from sim.rtl.n2_lockstep_isa import default_isa
from tests.bench.seed import SEED
from tests.gdb.client import PC, Client, Debugged, program, stopped_at, system

ISA = default_isa()
RESET, LOOP, SLOTS = 0x1000_0000, 0x1000_0400, 14  # the loop: SLOTS instructions, then a branch
DATA, BYTES = 0x1004_8000, 0x80
POINTER = 4  # the register that the loop's loads and stores use
NUMBERS = (2, 3, 5, 6, 7, 8, 9, 24, 25)  # registers of the loop; 24, 25: et and bt
CONTROL = (34, 36)  # estatus, ienable: one bit each is compared
CUSTOM = range(49, 57)  # bounds of the saturation instruction


class Model:
    """The system as the manual and the instruction set have it."""

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        self.registers = dict.fromkeys((*NUMBERS, POINTER, *CUSTOM), 0)
        self.data = bytearray(BYTES)
        self.slots = [self.instruction() for _ in range(SLOTS)]
        self.points: set[tuple[int, int]] = set()  # kind, address
        self.pc, self.stopped_by_point = RESET, False

    def instruction(self) -> tuple[str, int, int, int]:
        """Name, register written or stored, register read, immediate."""
        rng, name = self.rng, self.rng.choice(("addi", "addi", "stw", "ldw"))
        target = rng.choice(NUMBERS)
        if name == "addi":
            return name, target, rng.choice(NUMBERS), rng.randrange(-99, 100)
        return name, target, POINTER, 4 * rng.randrange(BYTES // 4)

    def place(self) -> int:
        """Address of an instruction of the loop."""
        return LOOP + 4 * self.rng.randrange(SLOTS)

    def point_here(self) -> bool:
        """Whether a breakpoint is at the pc."""
        return any(address == self.pc for _, address in self.points)

    def step(self) -> None:
        """Execute the instruction at the pc, which is in the loop."""
        slot = (self.pc - LOOP) // 4
        if slot == SLOTS:
            self.pc = LOOP
            return
        name, target, source, value = self.slots[slot]
        if name == "addi":
            self.registers[target] = (self.registers[source] + value) & 0xFFFF_FFFF
        elif name == "stw":
            struct.pack_into("<I", self.data, value, self.registers[target])
        else:
            (self.registers[target],) = struct.unpack_from("<I", self.data, value)
        self.pc += 4

    def go_on(self) -> None:
        """Continue: a breakpoint stops at once unless the program has stopped at it already."""
        if not (self.point_here() and not self.stopped_by_point):
            self.step()
            while not self.point_here():
                self.step()
        self.stopped_by_point = True


def encoded(instruction: tuple[str, int, int, int]) -> bytes:
    name, target, source, value = instruction
    operands = (target, source, value) if name == "addi" else (target, value, source)
    return struct.pack("<I", ISA.instructions[name].encode(*operands))


class Sequence:
    """Packets at random, to the server and to the model."""

    def __init__(self, gdb: Client, seed: int) -> None:
        self.gdb, self.rng = gdb, random.Random(seed)
        self.model = Model(self.rng)
        branch = ISA.instructions["br"].encode(-4 * (SLOTS + 1))
        gdb.monitor("reset")
        gdb.write(LOOP, b"".join(map(encoded, self.model.slots)) + struct.pack("<I", branch))
        gdb.write(DATA, bytes(BYTES))
        for number in self.model.registers:
            gdb.set_register(number, 0)
        self.set_register(POINTER, DATA)
        for number in CONTROL:
            gdb.set_register(number, 0)

    def set_register(self, number: int, value: int) -> None:
        self.gdb.set_register(number, value)
        self.model.registers[number] = value

    # ------------------------------------------------------------------ packets
    def write_register(self) -> None:
        number = self.rng.choice((*NUMBERS, *CUSTOM))
        self.set_register(number, self.rng.getrandbits(32))

    def write_data(self) -> None:
        first = self.rng.randrange(BYTES)
        data = self.rng.randbytes(self.rng.randint(1, BYTES - first))
        if self.rng.random() < 0.5:
            self.gdb.write(DATA + first, data)
        else:
            special = b"}$#*"
            text = (bytes([0x7D, b ^ 0x20]) if b in special else bytes([b]) for b in data)
            self.gdb.ok(b"X%x,%x:" % (DATA + first, len(data)) + b"".join(text))
        self.model.data[first : first + len(data)] = data

    def write_code(self) -> None:
        slot = self.rng.randrange(SLOTS)
        self.model.slots[slot] = self.model.instruction()
        self.gdb.write(LOOP + 4 * slot, encoded(self.model.slots[slot]))

    def insert(self) -> None:
        kind, address = self.rng.randrange(2), self.model.place()
        if kind and sum(k for k, _ in self.model.points) == 4:
            return
        self.gdb.ok(f"Z{kind},{address:x},4")
        self.model.points.add((kind, address))

    def remove(self) -> None:
        if self.model.points:
            point = self.rng.choice(sorted(self.model.points))
            self.gdb.ok(f"z{point[0]},{point[1]:x},4")
            self.model.points.discard(point)

    def jump(self) -> None:
        address = self.model.place()
        self.gdb.set_register(PC, address)
        if address != self.model.pc:
            self.model.pc, self.model.stopped_by_point = address, False

    def reset(self) -> None:
        self.gdb.monitor("reset")
        self.model.pc, self.model.stopped_by_point = RESET, False

    def step(self) -> None:
        if self.model.pc == RESET:
            self.jump()
        assert stopped_at(self.gdb.go(self.rng.choice(("s", "vCont;s")))) == self.stepped()

    def stepped(self) -> int:
        self.model.step()
        self.model.stopped_by_point = self.model.point_here()
        return self.model.pc

    def go_on(self) -> None:
        if self.model.pc == RESET:
            self.jump()
        if not self.model.points:
            self.insert()
        self.model.go_on()
        assert stopped_at(self.gdb.go(self.rng.choice(("c", "vCont;c")))) == self.model.pc

    def read(self) -> None:
        model, rng = self.model, self.rng
        number = rng.choice((*NUMBERS, *CUSTOM))
        assert self.gdb.register(number) == model.registers[number], number
        first = rng.randrange(BYTES)
        length = rng.randint(1, BYTES - first)
        assert self.gdb.read(DATA + first, length) == model.data[first : first + length]
        slot = rng.randrange(SLOTS)
        assert self.gdb.read(LOOP + 4 * slot, 4) == encoded(model.slots[slot])
        assert self.gdb.register(PC) == model.pc

    ACTIONS = (
        *(write_register, write_data, write_data, write_code, insert, remove, jump, reset),
        *(step, step, go_on, go_on, read),
    )

    def run(self, packets: int) -> None:
        """So many packets, then everything is compared."""
        for _ in range(packets):
            self.rng.choice(self.ACTIONS)(self)
        for number, value in self.model.registers.items():
            assert self.gdb.register(number) == value, number
        assert self.gdb.read(DATA, BYTES) == self.model.data


def differences(sequences: int, seed: int, packets: int = 25) -> list[str]:
    """Sequences that end otherwise than the model, in words, with the seed that repeats each."""
    found = []
    debugged = Debugged(system(), program("run/demo_hello_fpga2"))
    for number in range(sequences):
        with debugged as gdb:
            try:
                Sequence(gdb, seed + number).run(packets)
            except (AssertionError, EOFError) as error:
                found.append(f"seed {seed + number}: {str(error).splitlines()[:1]}")
            gdb.ask("D")
        debugged.server.running = False
        debugged.system.target.halt()
    return found


@pytest.mark.full
def test_sequences__do_what_the_model_does():
    assert differences(250, SEED) == []


@pytest.mark.full
def test_ten_thousand_sequences__do_what_the_model_does():
    assert differences(10_000, SEED) == []


def test_write_then_reset__the_word_is_in_memory():
    with Debugged(system(), program("run/demo_hello_fpga2")) as gdb:
        gdb.write(LOOP, encoded(("addi", 2, 2, 1)))  # A reset keeps memories once code is written.
        for value in range(1, 20):
            word = struct.pack("<I", value * 0x0101_0101)
            gdb.write(DATA, word)
            gdb.monitor("reset")
            assert gdb.read(DATA, 4) == word


def test_breakpoint_at_the_address_of_a_jump__stops_at_once():
    with Debugged(system(), program("run/demo_hello_fpga2")) as gdb:
        for kind in (0, 1):
            gdb.write(LOOP, encoded(("addi", 2, 2, 1)) * 4)
            gdb.set_register(2, 0)
            gdb.ok(f"Z{kind},{LOOP + 4:x},4")
            gdb.set_register(PC, LOOP + 4)
            reply = gdb.go("vCont;c")
            assert stopped_at(reply) == LOOP + 4 and gdb.register(2) == 0
            assert (b"hwbreak" if kind else b"swbreak") in reply
            gdb.ok("Z1,%x,4" % (LOOP + 8))
            assert stopped_at(gdb.go("vCont;c")) == LOOP + 8 and gdb.register(2) == 1
            gdb.ok("z1,%x,4" % (LOOP + 8))
            gdb.ok(f"z{kind},{LOOP + 4:x},4")


@pytest.mark.parametrize("kind", [0, 1])
@pytest.mark.parametrize("taken_away", [False, True])
def test_breakpoint_at_a_break_of_the_program__each_stops_it_once(kind, taken_away):
    """GDB takes a breakpoint away for the step over it; the program's own `break` is passed too."""
    with Debugged(system(), program("run/demo_hello_fpga2")) as gdb:
        add, own = (
            encoded(("addi", 2, 2, 1)),
            struct.pack("<I", ISA.instructions["break"].encode(0)),
        )
        gdb.write(LOOP, add + own + 2 * add + own)
        gdb.set_register(2, 0)
        gdb.set_register(PC, LOOP)
        gdb.ok(f"Z{kind},{LOOP + 4:x},4")
        assert stopped_at(gdb.go("vCont;c")) == LOOP + 4 and gdb.register(2) == 1
        if taken_away:
            gdb.ok(f"z{kind},{LOOP + 4:x},4")
        assert stopped_at(gdb.go("vCont;c")) == LOOP + 16 and gdb.register(2) == 3
        gdb.ok(f"z{kind},{LOOP + 4:x},4")
