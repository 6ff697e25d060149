# SPDX-License-Identifier: Apache-2.0
"""Image and report of a compiled law, by the assembler."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from asip_asm.assemble import build_program, encode
from asip_asm.debug_map import DebugMap
from asip_asm.debug_values import debug_map
from asip_asm.diagnostics import AssemblyError
from asip_asm.files import open_output
from asip_asm.image import Image
from asip_asm.ir import Program
from asip_asm.loops import region_loops
from asip_asm.machine import Machine
from asip_asm.model.compiler import DIVIDE, Compiled
from asip_asm.model.read import ModelError
from asip_asm.report import Report, report_program
from asip_asm.search import Progress


@dataclass(frozen=True)
class Built:
    """A program ready to run; bound_cycles: the largest lower bound of the report, with loops what
    the slots need.
    """

    compiled: Compiled
    image: Image
    report: Report
    map: DebugMap
    bound_cycles: int

    @property
    def cycles(self) -> int:
        """Of a program with loops as the assembler announces it, else with the report's bound."""
        looped = len(self.report.sections) > 1
        return (self.image.cycles if looped else None) or self.report.sections[0].cycles


def build(
    compiled: Compiled, path: Path, progress: Callable[[Progress], None] | None = None
) -> Built:
    """Write the source text to `path` and assemble it; `progress` is called during the search for a
    schedule. Raises AssemblyError, OSError; ModelError where the program meets a limit of the core.
    """
    with open_output(path) as file:
        file.write(compiled.text)
    try:
        program, machine = build_program(
            path, configuration=compiled.options.configuration, progress=progress
        )
        image = encode(program, machine, path)
    except AssemblyError as error:
        limits = [found.message for found in error.diagnostics if found.place is None]
        if not limits:
            raise
        reason = limits[0].removeprefix(f"{path}: ")
        raise ModelError(f"{compiled.law.title}: {reason}; {DIVIDE}") from None
    found, report = debug_map(program, machine, image), report_program(program, machine)
    bound = report.sections[0].bound if len(report.sections) == 1 else _least(program, machine)
    return Built(compiled, image, report, found, bound)


def _least(program: Program, machine: Machine) -> int:
    """Cycles of a run that the slots need for the operations of a program with loops."""
    loops = region_loops(program)
    total = 0
    for number, region in enumerate(program.regions):
        rounds = math.prod(loop.rounds for loop in loops if loop.first <= number <= loop.last)
        operations = [op for bundle in region.bundles or () for op in bundle.operations]
        counts = Counter(tuple(machine.slots_of(op)) for op in operations if op.mnemonic != "nop")
        total += rounds * max((-(-n // len(slots)) for slots, n in counts.items()), default=0)
    return total
