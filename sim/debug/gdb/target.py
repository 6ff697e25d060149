# SPDX-License-Identifier: Apache-2.0
"""The program on a halted Nios II system: registers by GDB's numbers, bytes of memory, breakpoints.

Breakpoints of GDB's kind 0 are `break` instructions in the instruction memory, without limit; those
of kind 1, and watchpoints, are comparators of the debug module.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

from sim.debug.gdb.description import FIRST_CONTROL, FIRST_CUSTOM, PC, custom_registers, saturation
from sim.debug.gdb.module import DebugModule
from sim.rtl.n2_lockstep_isa import default_isa
from sim.rtl.nios_map import SystemMap

ISA = default_isa()
BREAK = ISA.instructions["break"]
BREAKPOINT = BREAK.encode(0)
STATUS, BSTATUS = ISA.control["status"], ISA.control["bstatus"]
BREAKPOINTS = ("swbreak", "hwbreak")
WATCHES = {2: "watch", 3: "rwatch", 4: "awatch"}
"""Kinds of watchpoints by GDB's numbers."""
HALT_CYCLES = 10_000  # a core that has not halted by then never will


class TargetError(ValueError):
    """What was asked cannot be done; the message says why."""


@dataclass(frozen=True)
class Stop:
    """Why the core is halted: 'halt', 'break', 'swbreak', 'hwbreak', 'watch', 'rwatch', 'awatch'.

    `address` is that of the data of a watchpoint, or of a `break` of the program.
    """

    reason: str
    address: int = 0


@dataclass(frozen=True)
class Watch:
    """A watchpoint as GDB set it, and its comparators."""

    kind: str
    address: int
    length: int
    comparators: tuple[int, ...]


class Target:
    """A Nios II system under a debugger: 'fpga1' or 'fpga2'."""

    def __init__(self, system: str, system_map: SystemMap, module: DebugModule) -> None:
        self.system, self.map, self.module = system, system_map, module
        self.pc = 0
        self.stop = Stop("halt")
        self.freeze, self.mask_interrupts = True, True
        self.code_written = False  # by the debugger: the program may be another one
        self._saved: dict[int, int] = {}  # words under breakpoints of kind 0
        self._comparators: list[int | None] = [None] * module.breakpoints
        self._watches: list[Watch] = []
        self._custom = custom_registers(system)
        for number in range(module.breakpoints):
            module.set_breakpoint(number, None)
        for number in range(module.watchpoints):
            module.set_watchpoint(number, 0, 0, 0, False, False)
        self.configure()

    def configure(self) -> None:
        """Instruct the debug module how the core is to behave."""
        self.module.control(
            enable=1, freeze=int(self.freeze), mask_interrupts=int(self.mask_interrupts)
        )

    # ------------------------------------------------------------------ run control
    def halted(self) -> None:
        """To be called when the core has halted: where and why."""
        hits = set(self.module.watch_hits())
        self.pc = self.module.halted()
        self.stop = Stop("halt")
        for watch in self._watches:
            if hits & set(watch.comparators):
                self.stop = Stop(watch.kind, watch.address)
                return
        if reason := self._breakpoint():
            self.stop = Stop(reason)
        elif self._at_break():
            self.stop = Stop("break", self.pc)

    def halt(self) -> None:
        """Halt a running core. Raises TargetError if it does not."""
        self.module.request_halt()
        self._until_halt("the core did not halt")

    def _until_halt(self, otherwise: str) -> None:
        # The end of the program ends a run too, before a step is complete.
        if not self.module.run(HALT_CYCLES) and not self.module.run(HALT_CYCLES):
            raise TargetError(f"{otherwise} within {HALT_CYCLES} cycles")
        self.halted()

    def resume(self, step: bool) -> bool:
        """Let the program go on; to be halted again after one instruction if `step`.

        A breakpoint or a `break` of the program at which it stopped does not stop it again. Any
        other breakpoint at the pc stops it at once: the debugger has set the pc, as GDB's `jump`
        does, or has inserted the breakpoint since. False: the core is halted, `stop` says why.
        """
        if not step and self.stop.reason not in BREAKPOINTS and (reason := self._breakpoint()):
            self.stop = Stop(reason)
            return False
        if self.pc in self._saved:
            here = self.pc
            if self._passed_over(self._saved[here]):
                self.pc += 4
                self.module.leave(self.pc, step)
                return True
            self.module.write_words(here, [self._saved[here]])
            self.module.leave(here, True)
            self._until_halt("a step did not end")
            self.module.write_words(here, [BREAKPOINT])
            if (
                step or self.stop.reason != "halt"
            ):  # The next instruction may have a breakpoint too.
                return False
        elif self.stop.reason in ("break", *BREAKPOINTS) and self._at_break():
            self.pc += 4
        self.module.leave(self.pc, step)
        return True

    def _breakpoint(self) -> str:
        """The stop reason of a breakpoint at the pc, "" without one."""
        if self.pc in self._saved:
            return "swbreak"
        return "hwbreak" if self.pc in self._comparators else ""

    def _at_break(self) -> bool:
        """Whether the program's own instruction at the pc is a `break` that stops it once."""
        if not self._memory("itcm", self.pc, 4) or self.pc in self._saved:
            return False
        return self._passed_over(self.module.read_words(self.pc, 1)[0])

    @staticmethod
    def _passed_over(word: int) -> bool:
        """Whether an instruction is a `break` that does not end the program."""
        return ISA.find(word) is BREAK and word != BREAK.encode(1)

    def forget(self) -> None:
        """Remove all breakpoints and watchpoints."""
        for address in list(self._saved):
            self.remove(0, address, 4)
        for address in [a for a in self._comparators if a is not None]:
            self.remove(1, address, 4)
        for watch in list(self._watches):
            self._drop(watch)

    # ------------------------------------------------------------------ registers
    def registers(self) -> list[int]:
        """Those of the feature org.gnu.gdb.nios2.cpu."""
        control = self.module.control_registers(range(16))
        control[STATUS] = control[BSTATUS]  # what the program had, and will have again
        return [*self.module.registers(range(PC)), self.pc, *control]

    def register(self, number: int) -> int:
        """A register by GDB's number. Raises TargetError."""
        if number < PC:
            return self.module.register(number)
        if number == PC:
            return self.pc
        if number < FIRST_CUSTOM:
            control = number - FIRST_CONTROL
            return self.module.control_registers([BSTATUS if control == STATUS else control])[0]
        pair, high = self._bound(number)
        return self._bounds(pair)[high]

    def set_register(self, number: int, value: int) -> None:
        """Write a register by GDB's number. Raises TargetError."""
        if number < PC:
            self.module.set_register(number, value)
        elif number == PC:
            if not self._memory("itcm", value, 4) or value & 3:
                raise TargetError(f"0x{value:08x} is no address of an instruction")
            if value != self.pc:
                self.pc, self.stop = value, Stop("halt")
        elif number < FIRST_CUSTOM:
            control = number - FIRST_CONTROL
            self.module.set_control_register(BSTATUS if control == STATUS else control, value)
        else:
            pair, high = self._bound(number)
            bounds = self._bounds(pair)
            bounds[high] = value
            self.module.custom_write(saturation()["set"], pair, *bounds, writerc=0)

    def _bound(self, number: int) -> tuple[int, int]:
        if not 0 <= number - FIRST_CUSTOM < len(self._custom):
            raise TargetError(f"no register {number}")
        return divmod(number - FIRST_CUSTOM, 2)

    def _bounds(self, pair: int) -> list[int]:
        low, high = saturation()["low"], saturation()["high"]
        return [
            self.module.custom_read(low, pair, 0, readra=0),
            self.module.custom_read(high, pair, 0, readra=0, readrb=0),
        ]

    # ------------------------------------------------------------------ memory
    def _memory(self, name: str, address: int, length: int) -> bool:
        memory = self.map.memories[name]
        return memory.base <= address and address + length <= memory.base + 4 * memory.words

    def _check(self, address: int, length: int) -> None:
        io = self.map.io
        if any(self._memory(name, address, length) for name in self.map.memories):
            return
        if not (io.base <= address and address + length <= io.base + io.bytes):
            raise TargetError(f"no memory at 0x{address:08x}, {length} bytes")
        if address % 4 or length % 4:
            raise TargetError("registers of the I/O block are whole words")

    def read(self, address: int, length: int) -> bytes:
        """Bytes as the program sees them, without breakpoints. Raises TargetError."""
        self._check(address, length)
        first = address & ~3
        words = self.module.read_words(first, (address + length - first + 3) // 4)
        for at, word in self._saved.items():
            if 0 <= at - first < 4 * len(words):
                words[(at - first) // 4] = word
        data = struct.pack(f"<{len(words)}I", *words)
        return data[address - first : address - first + length]

    def write(self, address: int, data: bytes) -> None:
        """Write bytes; breakpoints stay. Raises TargetError."""
        self._check(address, len(data))
        if not data:
            return
        first = address & ~3
        last = (address + len(data) + 3) & ~3
        before = self.read(first, address - first)
        behind = self.read(address + len(data), last - address - len(data))
        words = list(struct.unpack(f"<{(last - first) // 4}I", before + data + behind))
        for at in self._saved:
            if first <= at < last:
                self._saved[at] = words[(at - first) // 4]
                words[(at - first) // 4] = BREAKPOINT
        self.module.write_words(first, words)
        self.code_written |= self._memory("itcm", address, len(data))

    # ------------------------------------------------------------------ breakpoints
    def insert(self, kind: int, address: int, length: int) -> None:
        """Set what a Z packet of GDB asks for. Raises TargetError."""
        if kind <= 1:
            if not self._memory("itcm", address, 4) or address % 4:
                raise TargetError(f"0x{address:08x} is no address of an instruction")
            if kind == 0 and address not in self._saved:
                (word,) = self.module.read_words(address, 1)
                self.module.write_words(address, [BREAKPOINT])
                self._saved[address] = word
            elif kind == 1 and address not in self._comparators:
                if None not in self._comparators:
                    raise TargetError(f"all {len(self._comparators)} comparators are in use")
                number = self._comparators.index(None)
                self._comparators[number] = address
                self.module.set_breakpoint(number, address)
        elif not self._watches_of(kind, address, length):
            self._watch(WATCHES[kind], address, length)

    def remove(self, kind: int, address: int, length: int) -> None:
        """Take it away again; nothing happens if it is not there."""
        if kind == 0 and address in self._saved:
            self.module.write_words(address, [self._saved.pop(address)])
        elif kind == 1 and address in self._comparators:
            number = self._comparators.index(address)
            self._comparators[number] = None
            self.module.set_breakpoint(number, None)
        for watch in self._watches_of(kind, address, length):
            self._drop(watch)

    def _watches_of(self, kind: int, address: int, length: int) -> list[Watch]:
        key = WATCHES.get(kind), address, length
        return [w for w in self._watches if (w.kind, w.address, w.length) == key]

    def _watch(self, kind: str, address: int, length: int) -> None:
        used = {number for watch in self._watches for number in watch.comparators}
        free = [n for n in range(self.module.watchpoints) if n not in used]
        pieces = list(_pieces(address, length))
        if not pieces or len(pieces) > len(free):
            raise TargetError(
                f"{length} bytes need {len(pieces)} comparators, {len(free)} are free"
            )
        for number, (word, ignored, lanes) in zip(free, pieces, strict=False):
            self.module.set_watchpoint(
                number, word, ignored, lanes, kind != "watch", kind != "rwatch"
            )
        self._watches.append(Watch(kind, address, length, tuple(free[: len(pieces)])))

    def _drop(self, watch: Watch) -> None:
        for number in watch.comparators:
            self.module.set_watchpoint(number, 0, 0, 0, False, False)
        self._watches.remove(watch)

    def comparators(self) -> str:
        """What the comparators are set to, for people."""
        used = {number: watch for watch in self._watches for number in watch.comparators}
        lines = [
            f"breakpoint {n}: {'free' if at is None else f'0x{at:08x}'}"
            for n, at in enumerate(self._comparators)
        ]
        for n in range(self.module.watchpoints):
            watch = used.get(n)
            place = f"{watch.kind} 0x{watch.address:08x}, {watch.length} bytes" if watch else "free"
            lines.append(f"watchpoint {n}: {place}")
        return "\n".join(lines)

    def again(self) -> None:
        """Set the breakpoints of kind 0 again, in a memory that was loaded."""
        for address in self._saved:
            (self._saved[address],) = self.module.read_words(address, 1)
            self.module.write_words(address, [BREAKPOINT])


def _pieces(address: int, length: int) -> Iterator[tuple[int, int, int]]:
    """Bytes as few comparators see them: byte address of a word, bits not compared, lanes."""
    end = address + length
    while address < end:
        word = address & ~3
        size = 4
        if address == word:
            while not address & (2 * size - 1) and address + 2 * size <= end:
                size *= 2
        upto = min(end, word + size)
        lanes = 15 if size > 4 else sum(1 << byte - word for byte in range(address, upto))
        yield word, size - 4, lanes
        address = upto
