# SPDX-License-Identifier: Apache-2.0
"""A simulated Nios II system as a debugger has it: the core, its program, time."""

from __future__ import annotations

from sim.debug.gdb.module import DebugModule
from sim.debug.gdb.target import HALT_CYCLES, Target, TargetError
from sim.rtl.nios_image import Program
from sim.rtl.nios_rtl import NiosRtl


class NiosSystem:
    """A simulated system under a debugger, halted before the first instruction of its program.

    None: there is no program, the debugger is to load one.
    """

    def __init__(self, core: NiosRtl, program: Program | None) -> None:
        self.core, self.program = core, program
        self.spent = 0  # clock cycles of the running program
        core.guard()
        self.target = Target(core.platform, core.map, DebugModule(core.debug, self.run))
        self.reset()

    def run(self, cycles: int) -> bool:
        """Let the core run; whether it has halted."""
        before = self.core.cycles
        halted = self.core.until_halt(cycles)
        self.spent += self.core.cycles - before
        return halted

    def reset(self) -> str:
        """Reset the core, halted before its first instruction; what is to be said of it."""
        program = None if self.target.code_written else self.program
        if self.core.halted:
            self.target.module.restore()
        if program is not None:
            self.core.load(program)
        else:
            self.core.hold()
        self.target.module.request_halt()
        self.core.start()
        if not self.run(HALT_CYCLES):
            raise TargetError("the core did not halt after its reset")
        self.target.halted()
        self.spent = 0
        if program is not None:
            self.target.again()
            return f"{program.name} is loaded, the core is at its reset vector"
        return "the core is at its reset vector; memories are as they were: `load` again"
