# SPDX-License-Identifier: Apache-2.0
"""Programs under the debugger, and a session whose answers a test reads."""

from __future__ import annotations

from pathlib import Path

from sim.core.backends import Backend, IssBackend
from sim.debug.asip_dbg.commands import Commands
from sim.debug.asip_dbg.program import DebuggedProgram
from sim.debug.asip_dbg.session import Session

LEG, LOOP, ENDLESS, STORES, LANES = (
    Path(__file__).with_name(f"{name}.s") for name in ("leg", "loop", "endless", "stores", "lanes")
)
INPUTS = {"x": 0.3, "y": 0.1, "z": 0.2, "l": 0.45}
"""Of leg.s."""
VALUES = INPUTS | {"scale": 2.0, "x0": 1.0, "x1": 2.0}
"""Of all the programs."""


class Debugger:
    """A session with inputs that answers `tell(line)` with what the command wrote."""

    def __init__(self, program: Path, target: Backend | None = None) -> None:
        self.session = Session(DebuggedProgram(program), target or IssBackend())
        self.lines: list[str] = []
        self.commands = Commands(self.session, self.lines.append)
        self.session.log = self.lines.append
        if not self.session.target.driven:
            for name in self.session.values.inputs:
                self.session.values.set(name, None, VALUES[name])

    def tell(self, *lines: str) -> str:
        self.lines.clear()
        for line in lines:
            self.commands.execute(line)
        return "\n".join(self.lines)
