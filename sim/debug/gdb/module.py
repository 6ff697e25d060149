# SPDX-License-Identifier: Apache-2.0
"""The debug module of a Nios II system: registers of rtl/nios/debug_regmap.rdl, by accesses alone.

A halted core is looked into by instructions that it executes. They go through `bt` and `et`, whose
contents are held here until the program goes on. Nothing here knows that the core is simulated:
the same accesses through a bridge to the module's Avalon-MM agent debug a board.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from sim.rtl.gen.n2_debug_regmap import REGMAP
from sim.rtl.n2_lockstep_isa import default_isa

Access = tuple[int, int | None]  # register, word to write or None to read
CTL_DEBUG = 31  # n2_pkg::CTL_DEBUG
ET, BT, BA = 24, 25, 30
LINES = 0x2000  # words in reach of one base address, of the 16-bit offset of a load
STATUS = REGMAP.registers["STATUS"].fields
CONTROL = REGMAP.registers["CONTROL"]


class DebugModule:
    """Primitives of a halted core. `access` performs accesses in order and returns what was read.

    `run` lets the core run, for a number of clock cycles or until it halts, and says whether it
    has halted.
    """

    def __init__(
        self, access: Callable[[Sequence[Access]], list[int]], run: Callable[[int], bool]
    ) -> None:
        self._access, self.run = access, run
        self._isa = default_isa().instructions
        self._kept: dict[int, int] = {}
        (config,) = self._access([self._read("CONFIG")])
        fields = REGMAP.registers["CONFIG"].fields
        self.breakpoints = fields["breakpoints"].of(config)
        self.watchpoints = fields["watchpoints"].of(config)

    # ------------------------------------------------------------------ accesses
    def _read(self, register: str) -> Access:
        return REGMAP.address(register), None

    def _write(self, register: str, value: int, index: int = 0) -> Access:
        return REGMAP.address(register) + index, value

    def _instruction(self, name: str, *operands: int, **flags: int) -> Access:
        return self._write("INSTRUCTION", self._isa[name].encode(*operands, **flags))

    def _execute(self, accesses: Sequence[Access]) -> None:
        """Let the core execute instructions; return when the last has written its result.

        INSTRUCTION is posted: its write ends before the core has executed the instruction. A read
        of DATA waits until the pipeline is empty, stores included.
        """
        self._access([*accesses, self._read("DATA")])

    def _load(self, register: int, value: int) -> list[Access]:
        return [self._write("DATA", value), self._instruction("rdctl", register, CTL_DEBUG)]

    def _fetch(self, register: int) -> list[Access]:
        return [self._instruction("wrctl", CTL_DEBUG, register), self._read("DATA")]

    # ------------------------------------------------------------------ run control
    def control(self, **fields: int) -> None:
        """Set CONTROL: enable, freeze, mask_interrupts."""
        self._access([self._write("CONTROL", CONTROL.word(**fields))])

    def request_halt(self) -> None:
        """Halt before the next instruction; in reset, before the first."""
        self._access([self._write("HALT", REGMAP.registers["HALT"].word(now=1))])

    def halted(self) -> int:
        """To be called when the core has halted: keeps `bt` and `et`; address where it is."""
        self._kept = dict(
            zip((BT, ET), self._access(self._fetch(BT) + self._fetch(ET)), strict=True)
        )
        return self.register(BA) - 4 & 0xFFFF_FFFC

    def _restore(self) -> list[Access]:
        """Accesses that give `bt` and `et` the program's values again."""
        return [a for register, value in self._kept.items() for a in self._load(register, value)]

    def restore(self) -> None:
        """Give the halted core all registers of the program, before a reset, which leaves them."""
        self._execute(self._restore())

    def leave(self, pc: int, step: bool) -> None:
        """Let the program go on at an address, for one instruction if `step`."""
        accesses = self._load(BA, pc) + self._restore()
        if step:
            accesses.append(self._write("HALT", REGMAP.registers["HALT"].word(now=1)))
        self._execute([*accesses, self._instruction("bret")])

    def watch_hits(self) -> list[int]:
        """Numbers of the watchpoints hit since the program went on."""
        (status,) = self._access([self._read("STATUS")])
        hits = STATUS["watch_hits"].of(status)
        return [number for number in range(self.watchpoints) if hits >> number & 1]

    def set_breakpoint(self, number: int, address: int | None) -> None:
        """Set a comparator to the address of an instruction, or switch it off."""
        record = REGMAP.registers["BREAKPOINT"]
        word = 0 if address is None else record.word(enable=1, address=address // 4)
        self._access([self._write("BREAKPOINT", word, number)])

    def set_watchpoint(
        self, number: int, address: int, ignored: int, lanes: int, read: bool, write: bool
    ) -> None:
        """Set a comparator to words: byte address, address bits not compared, bytes of the word."""
        control = REGMAP.registers["WATCH_CONTROL"].word(lanes=lanes, read=read, write=write)
        mask = REGMAP.registers["WATCH_MASK"].word(ignored=ignored // 4)
        words = REGMAP.registers["WATCH_ADDRESS"].word(address=address // 4)
        self._access(
            [
                self._write("WATCH_CONTROL", 0, number),
                self._write("WATCH_ADDRESS", words, number),
                self._write("WATCH_MASK", mask, number),
                self._write("WATCH_CONTROL", control, number),
            ]
        )

    # ------------------------------------------------------------------ registers
    def register(self, number: int) -> int:
        """General register of the program."""
        return self.registers([number])[0]

    def registers(self, numbers: Sequence[int]) -> list[int]:
        """General registers of the program."""
        asked = [n for n in numbers if n not in self._kept]
        values = dict(
            zip(asked, self._access([a for n in asked for a in self._fetch(n)]), strict=True)
        )
        return [self._kept[n] if n in self._kept else values[n] for n in numbers]

    def set_register(self, number: int, value: int) -> None:
        """Write a general register of the program; r0 stays 0."""
        if number in self._kept:
            self._kept[number] = value
        elif number:
            self._execute(self._load(number, value))

    def control_registers(self, numbers: Sequence[int]) -> list[int]:
        """Control registers, as the halted core has them."""
        return self._access(
            [a for n in numbers for a in (self._instruction("rdctl", BT, n), *self._fetch(BT))]
        )

    def set_control_register(self, number: int, value: int) -> None:
        """Write a control register of the halted core."""
        self._execute([*self._load(BT, value), self._instruction("wrctl", number, BT)])

    def custom_read(self, n: int, a: int, b: int, **flags: int) -> int:
        """Result of a custom instruction that reads only registers of its own; see
        `Instruction.encode` for `flags`.
        """
        custom = self._instruction("custom", n, BT, a, b, **flags)
        return self._access([custom, *self._fetch(BT)])[0]

    def custom_write(self, n: int, c: int, first: int, second: int, **flags: int) -> None:
        """Execute a custom instruction on two words."""
        accesses = self._load(BT, first) + self._load(ET, second)
        self._execute([*accesses, self._instruction("custom", n, c, BT, ET, **flags)])

    # ------------------------------------------------------------------ memory
    def read_words(self, address: int, count: int) -> list[int]:
        """Words from an address on, a multiple of 4, in memory or I/O."""
        found = []
        for first in range(0, count, LINES):
            accesses = self._load(BT, address + 4 * first)
            for i in range(min(LINES, count - first)):
                accesses += [self._instruction("ldwio", ET, 4 * i, BT), *self._fetch(ET)]
            found += self._access(accesses)
        return found

    def write_words(self, address: int, words: Sequence[int]) -> None:
        """Write words from an address on, a multiple of 4, in memory or I/O."""
        for first in range(0, len(words), LINES):
            accesses = self._load(BT, address + 4 * first)
            for i, word in enumerate(words[first : first + LINES]):
                accesses += [*self._load(ET, word), self._instruction("stwio", ET, 4 * i, BT)]
            self._execute(accesses)
