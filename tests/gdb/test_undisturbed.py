# SPDX-License-Identifier: Apache-2.0
"""A debugged program computes what it computes alone: random halts against an undisturbed run."""

from __future__ import annotations

import random
from dataclasses import dataclass
from functools import cache

import pytest

from sim.debug.gdb.module import DebugModule
from sim.debug.gdb.system import NiosSystem
from sim.rtl.nios_image import IMAGES, read_elf
from sim.rtl.nios_rtl import NiosRtl
from tests.bench.seed import SEED
from tests.gdb.client import Client, Debugged, program, stopped_at, system

BA = 30  # the debugger's own
DTCM, STACK = 0x1004_0000, 0x1004_FF00
SHORT = [
    f"tests/{name}"  # of nios_sw, they end by `break 1`
    for name in ("set_jump", "state_machine", "recursion", "variadic", "queens", "fixed_point")
]
LIMIT = 10_000_000  # cycles


@dataclass(frozen=True)
class Final:
    """What a program leaves: status, registers, data memory, instructions completed."""

    status: int
    registers: tuple[int, ...]
    memory: bytes
    instructions: int


def clear(nios: NiosSystem) -> None:
    """Registers to 0: a reset leaves them, and programs save them on the stack."""
    for number in range(1, 32):
        if number != BA:
            nios.target.module.set_register(number, 0)


def final(nios: NiosSystem) -> Final:
    """State of a program that has ended, and so is halted."""
    core = nios.core
    assert core.halted and core.ended is not None
    nios.target.halted()
    numbers = [n for n in range(1, 32) if n != BA]
    registers = tuple(nios.target.module.registers(numbers))
    memory = core.read(DTCM, core.map.memories["dtcm"].words).tobytes()
    return Final(core.ended, registers, memory, core.retired)


@cache
def alone(name: str) -> Final:
    """A run that nothing halts before its end."""
    nios = NiosSystem(system(), program(name))
    clear(nios)
    nios.target.module.leave(nios.target.pc, step=False)
    assert nios.run(LIMIT)
    return final(nios)


def places(name: str) -> list[int]:
    """Addresses of instructions of the program."""
    functions = program(name).functions()
    return [a for f in functions for a in range(f.address, f.address + f.size, 4)]


class Disturber:
    """Random packets of a debugger that must not change what the program computes."""

    def __init__(self, gdb: Client, name: str, rng: random.Random) -> None:
        self.gdb, self.rng, self.places = gdb, rng, places(name)
        self.points: list[str] = []
        self.ended = False

    def run(self, packet: str) -> None:
        """Let it run by a packet; notes its end."""
        self.ended = self.gdb.go(packet).startswith(b"W")

    def breakpoint(self) -> None:
        """A breakpoint of either kind."""
        self._insert(f"{self.rng.randrange(2)},{self.rng.choice(self.places):x},4")

    def _insert(self, point: str) -> None:
        if self.gdb.ask("Z" + point) == b"OK":
            self.points.append(point)

    def watchpoint(self) -> None:
        """A watchpoint on the stack or in the data."""
        address = self.rng.choice((STACK, DTCM)) + self.rng.randrange(0x100)
        self._insert(f"{self.rng.randint(2, 4)},{address:x},{self.rng.choice((1, 2, 4, 8)):x}")

    def remove(self) -> None:
        """One of them goes."""
        if self.points:
            self.gdb.ok("z" + self.points.pop(self.rng.randrange(len(self.points))))

    def steps(self) -> None:
        """Some single steps."""
        for _ in range(self.rng.randint(1, 6)):
            if not self.ended:
                self.run("s")

    def onward(self) -> None:
        """On to the next breakpoint."""
        self.run("c")

    def interrupt(self) -> None:
        """On, and Ctrl-C at once."""
        self.gdb.send(b"c")
        self.gdb.peer.sendall(b"\x03")
        self.ended = self.gdb.stop().startswith(b"W")

    def look(self) -> None:
        """Registers read and written back, memory read."""
        values = self.gdb.registers()
        number = self.rng.choice([n for n in range(1, 32) if n != BA])
        self.gdb.set_register(number, values[number])
        self.gdb.read(STACK + self.rng.randrange(64), self.rng.randrange(64))
        self.gdb.read(self.rng.choice(self.places), 8)

    def disturb(self, actions: int) -> None:
        """So many random actions, then to the end of the program."""
        kinds = (self.breakpoint, self.watchpoint, self.remove, self.steps, self.onward)
        kinds += (self.interrupt, self.look, self.onward)
        for _ in range(actions):
            if not self.ended:
                self.rng.choice(kinds)()
        while self.points and not self.ended:
            self.remove()
        if not self.ended:
            self.run("c")
        assert self.ended


def disturbed(seed: int) -> None:
    """One run against the undisturbed one."""
    rng = random.Random(seed)
    name = rng.choice(SHORT)
    session = Debugged(system(), program(name))
    clear(session.system)
    with session as gdb:
        Disturber(gdb, name, rng).disturb(rng.randint(4, 20))
    assert final(session.system) == alone(name), f"{name}: repeat with SEED={seed} (first run)"


def test_random_halts__the_program_ends_as_it_does_alone():
    for run in range(40):
        disturbed(SEED + run)


@pytest.mark.full
def test_a_thousand_runs_with_random_halts():
    for run in range(1000):
        disturbed(SEED + run)


def test_every_breakpoint_of_a_function_is_met_in_the_order_of_execution():
    """Single steps alone and breakpoints on every instruction alone see the same addresses."""
    name, seen = "tests/recursion", []
    for kind in ("s", "c"):
        with Debugged(system(), program(name)) as gdb:
            main = program(name).symbols["main"]
            points = [main.address + 4 * n for n in range(main.size // 4)]
            gdb.ok(f"Z0,{main.address:x},4")
            gdb.go()
            if kind == "c":
                for at in points:
                    gdb.ok(f"Z0,{at:x},4")
            path, reply = [], gdb.go(kind)
            while len(path) < 25 and not reply.startswith(b"W"):
                if stopped_at(reply) in points:
                    path.append(stopped_at(reply))
                reply = gdb.go(kind)
            assert len(path) > 5
            seen.append(path)
    assert seen[0] == seen[1]


def test_debug_module_costs_no_cycle_and_no_bit():
    """Without it, with it idle, with it enabled: the same cycles, instructions, memory, text."""
    found = []
    for debug, enable in ((False, 0), (True, 0), (True, 1)):
        core = NiosRtl("fpga2", debug)  # a new one: the branch table remembers what ran before
        if debug:
            DebugModule(core.debug, core.until_halt).control(enable=enable)
        rows = []
        for elf in ("run/demo_hello_fpga2.elf", "demo_timer_fpga2.elf"):
            core.load(read_elf(IMAGES / elf))
            begin = core.cycles
            core.start()
            status = core.execute(LIMIT)
            memory = core.read(DTCM, core.map.memories["dtcm"].words).tobytes()
            rows.append((status, core.cycles - begin, core.retired, memory, core.take_console()))
        found.append(rows)
    assert found[0][0][4].startswith(b"square root of 2")
    assert found[1] == found[0] and found[2] == found[0]


def test_timer_of_a_halted_core_stands_still():
    """A program that measures the latency of its own interrupts finds nothing wrong."""
    image = read_elf(IMAGES / "demo_timer_fpga2.elf")
    rng = random.Random(SEED)
    with Debugged(system(), image) as gdb:
        gdb.ok(f"Z0,{image.address('exception_handler'):x},4")
        reply, halts = gdb.go(), 0
        while not reply.startswith(b"W"):
            halts += 1
            reply = gdb.go("s" if halts < 30 and rng.random() < 0.5 else "c")
        assert reply == b"W00" and halts > 20
