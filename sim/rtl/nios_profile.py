# SPDX-License-Identifier: Apache-2.0
"""Where the cycles of a tick go on FPGA1 or FPGA2: by function and by kind of instruction.

An instruction that leaves the pipeline during a control tick counts the clock cycles since the one
before it left. So cycles in which it waits for operands are its own.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from asip_asm.project import ROOT
from sim.rtl.n2_lockstep_isa import OP_CUSTOM, default_isa
from sim.rtl.nios_image import Program
from sim.rtl.nios_rtl import NiosRtl

CUSTOM_TOML = ROOT / "nios_sw/custom.toml"
# Kinds of n2_lockstep_isa's units as they appear in the table.
KINDS = {
    "alu": "integer and moves",
    "shift": "shifts",
    "mul": "integer multiply",
    "div": "integer divide",
    "load": "loads",
    "store": "stores",
    "branch": "branches",
    "jump": "calls and returns",
}


@dataclass(frozen=True)
class Line:
    """One row: name, cycles and instructions per tick."""

    name: str
    cycles: float
    instructions: float


@dataclass(frozen=True)
class Profile:
    """Rows in descending order of cycles, and the mean cycles of a tick by the tick counter."""

    functions: list[Line]
    kinds: list[Line]
    tick_cycles: float


def custom_names(platform: str) -> dict[int, str]:
    """Number of a custom instruction -> its name in custom.toml."""
    records = tomllib.loads(CUSTOM_TOML.read_text(encoding="utf-8"))[platform]["instructions"]
    names: dict[int, str] = {}
    for name, record in records.items():
        names.setdefault(record["n"], name)
    return names


def kind_of(word: int, names: dict[int, str]) -> str:
    """Row of an instruction word in the table of kinds."""
    if word & 63 == OP_CUSTOM:
        number = word >> 6 & 255
        return f"custom {names.get(number, number)}"
    instruction = default_isa().find(word)
    return KINDS.get(instruction.unit, "other") if instruction else "illegal"


def _lines(totals: dict[str, tuple[int, int]], ticks: int) -> list[Line]:
    lines = [Line(name, c / ticks, n / ticks) for name, (c, n) in totals.items()]
    return sorted(lines, key=lambda line: (-line.cycles, line.name))


def profile(core: NiosRtl, program: Program, ticks: int, tick_cycles: float) -> Profile:
    """Sum up what `core.profiled` holds after `ticks` ticks (or one run of a program)."""
    spent, completed = core.profiled()
    code = core.map.memories["itcm"]
    names = custom_names(core.platform)
    by_function: dict[str, tuple[int, int]] = {}
    by_kind: dict[str, tuple[int, int]] = {}
    for index in np.flatnonzero(completed).tolist():
        function = program.function_at(code.base + 4 * index)
        kind = kind_of(program.memories["itcm"][index], names)
        for totals, key in ((by_function, function), (by_kind, kind)):
            cycles, count = totals.get(key, (0, 0))
            totals[key] = (cycles + int(spent[index]), count + int(completed[index]))
    return Profile(_lines(by_function, ticks), _lines(by_kind, ticks), tick_cycles)


def tables(result: Profile, title: str, rows: int | None = None) -> list[Table]:
    """The two tables for a terminal, with so many rows at most."""
    written = []
    for head, lines in (("function", result.functions), ("instructions", result.kinds)):
        table = Table(title=f"{title}: {result.tick_cycles:.0f} cycles, by {head}")
        table.add_column(head)
        for column in ("cycles", "share", "instructions", "cycles each"):
            table.add_column(column, justify="right")
        total = sum(line.cycles for line in lines)
        for line in lines[:rows]:
            table.add_row(
                line.name,
                f"{line.cycles:.0f}",
                f"{line.cycles / total:.1%}",
                f"{line.instructions:.0f}",
                f"{line.cycles / line.instructions:.2f}",
            )
        written.append(table)
    return written
