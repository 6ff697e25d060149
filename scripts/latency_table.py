# SPDX-License-Identifier: Apache-2.0
"""Latencies of every operation, measured on the core, as docs/latency.md.

For each operation and configuration two programs run on the RTL: a *chain*, in which every
operation reads the result of the one before, and a *stream* of independent ones. What one more
operation adds to CYCLES is the distance of dependent operations and the interval of independent
ones. `python scripts/latency_table.py` writes the page, `--check` refuses a page that differs
from what the core does.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.files import write_text
from asip_asm.isa import OperationRecord, default_isa
from asip_asm.machine import load_machine
from scripts.generated import run, template
from sim.rtl.asip_bus import register_address
from sim.rtl.asip_rtl import AsipRtl

SCRIPT = "scripts/latency_table.py"
LENGTHS = (4, 8)  # operations of the two runs whose difference is taken
CHAINED = ("a1", "c1")  # registers of the chains, by bank
BRANCH_TESTS = {"jmp": "", "bz": "zero, ", "bnz": "k0, "}  # operand that makes each branch taken


@dataclass(frozen=True)
class Row:
    """What the core did with one operation; distances in cycles."""

    mnemonic: str
    unit: str
    latency: int
    distance: int
    interval: int


def chain(operation: OperationRecord, bank: str, count: int) -> list[str]:
    """`count` operations, each reading the register that the one before wrote.

    Registers start at 0, on which every operation is legal (data address 0 included).
    """
    return [_line(operation, f"{bank}1", f"{bank}1")] * count


def stream(operation: OperationRecord, bank: str, count: int) -> list[str]:
    """`count` operations that depend on nothing, each with its own destination."""
    return [_line(operation, f"{bank}{10 + i}", "zero") for i in range(count)]


def branches(mnemonic: str, count: int) -> list[str]:
    """`count` taken branches, each to the bundle after it."""
    return [f"{mnemonic} {BRANCH_TESTS[mnemonic]}t{i}\nt{i}:" for i in range(count)]


def _line(operation: OperationRecord, destination: str, source: str) -> str:
    operands = ["base" if name == "address" else name for name in operation.operands]
    words = {"dst": destination, "base": f"0[{source}]"}
    return f"{operation.name} " + ", ".join(words.get(name, source) for name in operands)


class Bench:
    """Runs lists of lines on one core and counts."""

    def __init__(self, configuration: str, folder: Path) -> None:
        self.configuration = configuration
        self.core = AsipRtl(configuration)
        self.source = folder / "latency.s"

    def cycles(self, lines: list[str]) -> int:
        """CYCLES of a run of the lines, one operation per bundle."""
        text = ".const one = 1.0, pin k0\n.data table: int = 0\n"
        text += "\n".join(lines) + "\nhalt\n"
        write_text(self.source, text)
        self.core.load(assemble(self.source, configuration=self.configuration, optimise=False))
        for register in CHAINED:
            self.core.write(register_address(register), 0)
        result = self.core.run([], np.zeros((1, 0), dtype=np.uint32), [])
        if result.fault != "NONE":
            raise SystemExit(f"latency_table: {lines[0]!r} ended in {result.fault}")
        return int(result.cycles[0])

    def slope(self, programs: tuple[list[str], list[str]]) -> int:
        """Cycles that one more operation costs."""
        short, long = (self.cycles(lines) for lines in programs)
        slope, rest = divmod(long - short, LENGTHS[1] - LENGTHS[0])
        if rest:
            raise SystemExit(f"latency_table: {programs[0][0]!r} has no constant cost")
        return slope


def measure(configuration: str) -> tuple[list[Row], dict[str, int]]:
    """Rows of all operations with a result, and the cost of each taken branch."""
    machine = load_machine(configuration)
    isa = default_isa()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(configuration, Path(folder))
        for mnemonic, operation in isa.operations.items():
            unit = machine.units[operation.unit]
            if not operation.writes or unit.name == "lanes":
                continue
            bank = "a" if unit.bank == "pipe" else "c"
            short, long = LENGTHS
            distance, interval = (
                bench.slope((form(operation, bank, short), form(operation, bank, long)))
                for form in (chain, stream)
            )
            rows.append(Row(mnemonic, unit.name, unit.ranks, distance, interval))
        taken = {
            name: bench.slope((branches(name, LENGTHS[0]), branches(name, LENGTHS[1])))
            for name in BRANCH_TESTS
        }
    return rows, taken


def page(configurations: dict[str, tuple[list[Row], dict[str, int]]]) -> str:
    """Text of docs/latency.md. Raises SystemExit if branches differ between configurations."""
    (_, taken), *others = configurations.values()
    if any(other_taken != taken for _, other_taken in others):
        raise SystemExit("latency_table: the configurations differ in branches")

    def shown(values: Sequence[int]) -> str:
        """The number of all configurations, or that of each."""
        if len(set(values)) == 1:
            return str(values[0])
        named = zip(values, configurations, strict=True)
        return ", ".join(f"{value} in {name}" for value, name in named)

    units: dict[tuple[str, str, str, str], list[str]] = {}
    for same in zip(*(rows for rows, _ in configurations.values()), strict=True):
        numbers = zip(*((row.latency, row.distance, row.interval) for row in same), strict=True)
        latency, distance, interval = map(shown, numbers)
        key = (same[0].unit, latency, distance, interval)
        units.setdefault(key, []).append(f"`{same[0].mnemonic}`")
    lines = []
    for (unit, latency, distance, interval), names in units.items():
        lines.append(f"| {' '.join(names)} | {unit} | {latency} | {distance} | {interval} |")
    cost = ", ".join(f"`{name}` {cycles}" for name, cycles in taken.items())
    return template("latency.md.j2").render(
        script=SCRIPT, configurations=" and ".join(configurations), rows=lines, cost=cost
    )


def generate() -> dict[str, str]:
    """Text of the page by its path."""
    measured = {name: measure(name) for name in default_isa().without_streams}
    return {"docs/latency.md": page(measured)}


if __name__ == "__main__":
    sys.exit(run(SCRIPT, __doc__.splitlines()[0], generate))
