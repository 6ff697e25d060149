# SPDX-License-Identifier: Apache-2.0
"""Latencies of every operation, measured on the core, as docs/latency.md.

For each operation and configuration two programs run on the RTL: a *chain*, in which every
operation reads the result of the one before, and a *stream* of independent ones. What one more
operation adds to CYCLES is the distance of dependent operations and the interval of independent
ones. `python scripts/latency_table.py` writes the page, `--check` refuses a page that differs
from what the core does.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.isa import OperationRecord, default_isa
from asip_asm.machine import load_machine
from sim.harness.asip_rtl import AsipRtl, register_address

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/latency.md"
COMMAND = "python scripts/latency_table.py"
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
    """`count` taken branches, each to the bundle behind it."""
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
        self.source.write_text(text, encoding="utf-8")
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
            if not operation.writes:
                continue
            unit = machine.units[operation.unit]
            bank = "a" if unit.bank == "pipe" else "c"
            distance, interval = (
                bench.slope(tuple(form(operation, bank, n) for n in LENGTHS))
                for form in (chain, stream)
            )
            rows.append(Row(mnemonic, unit.name, unit.latency, distance, interval))
        taken = {
            name: bench.slope(tuple(branches(name, n) for n in LENGTHS)) for name in BRANCH_TESTS
        }
    return rows, taken


def page(configurations: dict[str, tuple[list[Row], dict[str, int]]]) -> str:
    """Text of docs/latency.md. Raises SystemExit if the configurations differ."""
    (rows, taken), *others = configurations.values()
    if any(other != (rows, taken) for other in others):
        raise SystemExit("latency_table: the configurations have different latencies")
    units: dict[tuple[str, int, int, int], list[str]] = {}
    for row in rows:
        key = (row.unit, row.latency, row.distance, row.interval)
        units.setdefault(key, []).append(f"`{row.mnemonic}`")
    lines = [
        f"<!-- GENERATED by {COMMAND} from runs of the core - do not edit. -->",
        "# Latencies, measured",
        "",
        f"Cycles on the RTL, the same in configurations {' and '.join(configurations)}. *Latency* is",
        "what the machine description says of the unit; *dependent after* is how many cycles behind its",
        "producer an operation that reads the result issues, *independent after* how many cycles behind one",
        "that does not. No latency depends on operands.",
        "",
        "| operations | unit | latency | dependent after | independent after |",
        "| --- | --- | --- | --- | --- |",
    ]
    for (unit, latency, distance, interval), names in units.items():
        lines.append(f"| {' '.join(names)} | {unit} | {latency} | {distance} | {interval} |")
    cost = ", ".join(f"`{name}` {cycles}" for name, cycles in taken.items())
    return "\n".join(
        [
            *lines,
            "",
            f"A taken branch and the fetch behind it, cycles to the next bundle's issue: {cost}.",
            "",
            "Exceptions to the rule:",
            "",
            "- A write to bank C waits if another unit's result reaches the bank's only port in the same cycle",
            "  (counted as STALL_PORT); the scheduler avoids it.",
            "- A second write to a register waits for the first like a reader does.",
            "- The sine unit takes one operation at a time; the next waits for the result (STALL_UNIT).",
            "- Outputs can't be read back by a program, so a write to one delays nothing.",
            "",
        ]
    )


def main(argv: list[str] | None = None) -> int:
    """Command line; exit 0 written or equal, 1 if the page differs."""
    parser = argparse.ArgumentParser(
        description=__doc__.splitlines()[0],
        epilog=f"example: {COMMAND} --check",
    )
    parser.add_argument("--check", action="store_true", help="compare with the page, write nothing")
    options = parser.parse_args(argv)
    text = page({name: measure(name) for name in default_isa().configurations})
    if not options.check:
        PAGE.write_text(text, encoding="utf-8")
        return 0
    if PAGE.is_file() and PAGE.read_text(encoding="utf-8") == text:
        return 0
    print(f"error: {PAGE.relative_to(ROOT)} differs from the core; help: {COMMAND}")
    return 1


if __name__ == "__main__":
    sys.exit(main())
