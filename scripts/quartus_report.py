# SPDX-License-Identifier: Apache-2.0
"""Figures of the Quartus reports of asip_de3, into build/synth.json under key "stratix3".

Reads <revision>.map.rpt, .fit.rpt and .sta.rpt of one folder. A report is a text of tables: a
title line `; Fitter Summary ;` between rules `+---+`, then rows `; name ; value ;`. Counts are
written as `1,234 / 113,600 ( 1 % )` or alone. Other keys of build/synth.json stay.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

from asip_asm.command import command
from asip_asm.files import write_text

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "build/quartus"
RESULT = ROOT / "build/synth.json"
REVISION = "asip_de3"
KEY = "stratix3"
CORE_CLOCK = "clk[0]"  # end of the PLL output's name, the clock of the ASIP
# Names of the summary rows of family Stratix III.
ROWS = {
    "aluts": "Combinational ALUTs",
    "memory_aluts": "Memory ALUTs",
    "registers": "Total registers",
    "dsp_18x18": "DSP block 18-bit elements",
    "memory_bits": "Total block memory bits",
}


class ReportError(ValueError):
    """A report is missing or lacks a figure; the message names both."""


def rows_of(text: str, title: str) -> list[list[str]]:
    """Cells of the rows below the table title `title`, up to the end of that table.

    Indentation and trailing blanks are dropped. Raises ReportError if there is no such table.
    """
    lines = iter(text.splitlines())
    for line in lines:
        if re.fullmatch(rf";\s*{re.escape(title)}\s*;", line.strip()):
            break
    else:
        raise ReportError(f'no table "{title}"')
    rows: list[list[str]] = []
    for line in lines:
        line = line.strip()
        if line.startswith(";"):
            rows.append([cell.strip() for cell in line.strip(";").split(";")])
        elif not line.startswith("+"):
            break
    return rows


def count(text: str) -> int:
    """`1,234 / 113,600 ( 1 % )` -> 1234. Raises ReportError if no number leads."""
    found = re.match(r"[\d,]+", text)
    if not found:
        raise ReportError(f'no count in "{text}"')
    return int(found[0].replace(",", ""))


def resources(text: str, title: str, names: tuple[str, ...] = tuple(ROWS)) -> dict[str, int]:
    """Counts of the summary table `title`; ReportError names the row that is not there."""
    table = {row[0]: row[1] for row in rows_of(text, title) if len(row) > 1}
    missing = [ROWS[name] for name in names if ROWS[name] not in table]
    if missing:
        raise ReportError(f'no row "{missing[0]}" in table "{title}"')
    return {name: count(table[ROWS[name]]) for name in names}


def fmax(text: str) -> dict[str, float]:
    """Fmax in MHz of the core clock per slow timing model, e.g. "Slow 1100mV 85C Model".

    Taken is the restricted Fmax, which heeds the toggle limits of clock network and memories too.
    Raises ReportError for a model without the clock, or no slow model.
    """
    models = dict.fromkeys(re.findall(r"^;\s*(Slow .*? Model) Fmax Summary", text, re.M))
    speeds = {}
    for model in models:
        found = [
            row
            for row in rows_of(text, f"{model} Fmax Summary")
            if len(row) > 2 and row[2].endswith(CORE_CLOCK)
        ]
        if not found:
            raise ReportError(f'no clock "*{CORE_CLOCK}" under "{model} Fmax Summary"')
        speeds[model] = min(float(row[1].split()[0]) for row in found)
    if not speeds:
        raise ReportError("no table of Fmax of a slow model")
    return speeds


def _read(folder: Path, revision: str, stage: str) -> str:
    path = folder / f"{revision}.{stage}.rpt"
    if not path.is_file():
        raise ReportError(f"no {stage} report: {path.name} in {folder}")
    return path.read_text(encoding="utf-8", errors="replace")


def figures(folder: Path, revision: str = REVISION) -> dict:
    """Figures of a finished build: fitted counts as in ROWS, those after synthesis, slow Fmax.

    `fmax_mhz` is the lowest slow corner. Raises ReportError with the report's name.
    """
    stage = "fit"
    try:
        fit = _read(folder, revision, stage)
        header = {row[0]: row[1] for row in rows_of(fit, "Fitter Summary") if len(row) > 1}
        fitted = resources(fit, "Fitter Summary")
        stage = "map"
        mapped = resources(
            _read(folder, revision, stage),
            "Analysis & Synthesis Summary",
            ("aluts", "registers", "dsp_18x18", "memory_bits"),
        )
        stage = "sta"
        speeds = fmax(_read(folder, revision, stage))
    except ReportError as error:
        raise ReportError(f"{revision}.{stage}.rpt: {error}") from error
    corner = min(speeds, key=speeds.__getitem__)
    version = re.search(r"^Quartus .*Version.*$", fit, re.M)
    return {
        "measured": "Quartus II fitter and TimeQuest; bus ports are virtual pins, not timed",
        "tool": version[0].strip() if version else "unknown",
        "device": header.get("Device", "unknown"),
        **fitted,
        "after_synthesis": mapped,
        "fmax_mhz": speeds[corner],
        "fmax_corner": corner,
        "fmax_corners_mhz": speeds,
    }


def store(result: dict, path: Path = RESULT) -> None:
    """Put `result` under key "stratix3" of the JSON file; everything else in it stays."""
    data = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    data[KEY] = result
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, json.dumps(data, indent=2) + "\n")


def table(result: dict) -> Table:
    """One row per figure."""
    view = Table(f"{REVISION} on {result['device']}", "fitted", "after synthesis")
    for name, row in ROWS.items():
        view.add_row(row, str(result[name]), str(result["after_synthesis"].get(name, "-")))
    view.add_row(f"Fmax, {result['fmax_corner']}", f"{result['fmax_mhz']:.1f} MHz", "-")
    return view


@command("scripts/quartus_report.py")
def main(argv: list[str] | None = None) -> int:
    """Command line; exit 0 stored, 1 for a report that is missing or has no such figure."""
    parser = argparse.ArgumentParser(
        description=__doc__.splitlines()[0],
        epilog="example: python scripts/quartus_report.py build/quartus",
    )
    parser.add_argument("folder", nargs="?", type=Path, default=FOLDER, help="folder of the *.rpt")
    parser.add_argument("--output", type=Path, default=RESULT, help="JSON file to update")
    options = parser.parse_args(argv)
    console = Console()
    try:
        result = figures(options.folder)
    except ReportError as error:
        console.print(f"error: {error}", style="red", markup=False, soft_wrap=True)
        return 1
    store(result, options.output)
    console.print(table(result))
    return 0


if __name__ == "__main__":
    sys.exit(main())
