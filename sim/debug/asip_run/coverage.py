# SPDX-License-Identifier: Apache-2.0
"""What all runs of a program did together: cycles of each run, executions and cycles by line."""

from __future__ import annotations

import csv
from collections import defaultdict
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from asip_asm.files import open_output
from asip_asm.image import Image
from asip_asm.profile import Trace


@dataclass(frozen=True)
class Line:
    """A source line with operations: its executions, and cycles, in all runs."""

    executions: int
    cycles: float


class Coverage:
    """Sums over runs that ended without a fault."""

    def __init__(self, image: Image) -> None:
        self._image = image
        self._issued = [0] * len(image.sources)
        self._spent = [0] * len(image.sources)
        self.cycles: list[int] = []
        self._runs: list[int] = []  # numbers of these runs, from 1

    def add(self, run: int, trace: Trace) -> None:
        """Count a run. A bundle's cycles are those up to the issue of the next one; the last one
        has the rest.
        """
        total, issues = trace.counters["CYCLES"], list(trace.issues)
        rest = total
        for (cycle, address), (after, _) in pairwise(issues):
            self._issued[address] += 1
            self._spent[address] += after - cycle
            rest -= after - cycle
        self._issued[issues[-1][1]] += 1
        self._spent[issues[-1][1]] += rest
        self.cycles.append(total)
        self._runs.append(run)

    def summary(self) -> str:
        """Cycles over all runs, in a line."""
        if not self.cycles:
            return "no run without a fault\n"
        longest = max(self.cycles)
        where = self._runs[self.cycles.index(longest)]
        mean = sum(self.cycles) / len(self.cycles)
        return (
            f"{len(self.cycles)} runs: {min(self.cycles)} to {longest} cycles, mean {mean:.1f}; "
            f"the longest is run {where}\n"
        )

    def lines(self) -> dict[tuple[str, int], Line]:
        """By file and line. Lines whose operations share a bundle share its cycles equally."""
        executions: dict[tuple[str, int], int] = defaultdict(int)
        cycles: dict[tuple[str, int], float] = defaultdict(float)
        for bundle, entries in enumerate(self._image.sources):
            places = {(entry.file, entry.line) for entry in entries}
            for place in places:
                executions[place] = max(executions[place], self._issued[bundle])
                cycles[place] += self._spent[bundle] / len(places)
        return {place: Line(executions[place], cycles[place]) for place in sorted(executions)}

    def covered(self) -> str:
        """How many lines were executed, in a line."""
        lines = self.lines().values()
        executed = sum(line.executions > 0 for line in lines)
        return f"{executed} of {len(lines)} lines with operations were executed\n"

    def write(self, file: Path) -> None:
        """Write the table as CSV, and next to it a listing of the sources, .lst.

        Reads the files that the image names as its sources: the image must be one that was
        assembled here.
        """
        found, runs = self.lines(), max(len(self.cycles), 1)
        file.parent.mkdir(parents=True, exist_ok=True)
        with open_output(file) as output:
            table = csv.writer(output, lineterminator="\n")
            table.writerow(["file", "line", "executions", "cycles_per_run"])
            for (source, number), each in found.items():
                table.writerow([source, number, each.executions, f"{each.cycles / runs:.3f}"])
        with open_output(file.with_suffix(".lst")) as output:
            output.write(self.summary() + self.covered())
            for source in sorted({source for source, _ in found}):
                output.write(f"\n{source}\n{'executions':>10} {'cycles/run':>10}\n")
                text_of = Path(source).read_text(encoding="utf-8-sig").splitlines()
                for number, text in enumerate(text_of, 1):
                    line = found.get((source, number))
                    figures = f"{line.executions:>10} {line.cycles / runs:>10.2f}" if line else ""
                    missed = "#" if line and not line.executions else " "
                    output.write(f"{figures:21} {missed}{number:>5}  {text}".rstrip() + "\n")
