# SPDX-License-Identifier: Apache-2.0
"""Measure the goals of netlists, boards and clocks, to build/silicon.json.

Netlists are made and compared here; bitstreams, table 4 and clocks are taken from their last run
(`microtick bitstream`, `microtick synth`), or else from docs/data. Exit status 1 if a goal is
missed: what was never measured is neither met nor missed.
"""

from __future__ import annotations

import functools
import json
import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console

from asip_asm.command import command, command_parser
from asip_asm.files import write_text
from scripts.bitstream import BOARDS
from scripts.bitstream import OUTPUT as BOARD_RESULTS
from scripts.synth_unit import MAP_FILE
from sim.bench.run.tables import synthesised
from sim.core.fpbench import campaign
from sim.report import cache
from sim.report.goals import (
    Goal,
    as_json,
    at_least,
    depth,
    exactly,
    missed,
    not_measured,
    terminal_table,
    write_goals,
)
from tests.silicon import beside, lockstep, ticks
from tests.silicon.lockstep import Outcome
from tests.silicon.netlist import BUILD, NetlistError, prove_equivalent

ROOT = Path(__file__).resolve().parents[1]
OUTPUT = ROOT / "build/silicon.json"
OUTCOMES = BUILD / "outcomes"
COMPARED = (*(ROOT / name for name in ("asip_asm", "nios_sw", "rtl", "sim", "tests")), MAP_FILE)
KEPT_BOARDS = ROOT / "docs/data/boards.json"
TICKS = 10_000
FULL = "RUN=full measures it"
CLOCK, BOARD_CLOCK, MARGIN = 125.0, 100.0, 1.05  # MHz
UNITS = ("fp_cmp", "fp_i2f", "fp_f2i", "fp_mul", "quadrature_decoder")
PROVED = ("fp_i2f", "fp_cmp", "fp_f2i", "fp_add", "quadrature_decoder", "pulse_generator")
BLOCKS = (
    *("fp_fma", "fp_divsqrt", "fp_divsqrt_folded", "fp_sincos", "fp_sincos_overlapped"),
    *("n2_core", "motion_front_end", "drive_front_end", "pwm_bridge", "sinc3_filter"),
    *("biss_master", "axil_bridge"),
)
AT_WORK = {
    "n2_core_fpga1": (1000, "ticks of the tracking law in C"),
    "n2_core_fpga2": (2000, "ticks of the tracking law in C"),
    "motion_front_end": (300, "commands of lines and arcs on five axes, and a G64 program"),
    "ethercat_slave": (1000, "chains of datagrams"),
    "drive_front_end": (10, "control periods"),
}


def board_results() -> dict[str, Any]:
    """Result of each board's last `microtick bitstream`, else the one committed."""
    found = json.loads(KEPT_BOARDS.read_text()) if KEPT_BOARDS.is_file() else {}
    for name in BOARDS:
        file = BOARD_RESULTS / name / "result.json"
        if file.is_file():
            found[name] = json.loads(file.read_text())
    return found


def boards() -> Iterator[Goal]:
    """Core clock that the routed design reaches, next to what the board's top asks for."""
    fast_enough = 0
    results = board_results()
    for name, board in BOARDS.items():
        result = results.get(name, {"clocks": {"": {}}, "seed": ""})
        found = result["clocks"][str(result["seed"])].values()
        core = [c["achieved"] for c in found if abs(c["constraint"] - board.core_mhz) < 0.5]
        goal = (f"{name}: core clock", core[0] if core else None, "MHz", f">= {board.core_mhz}")
        if not core:
            yield Goal(*goal, None, f"not run at this clock; microtick bitstream {name}")
            continue
        met = bool(result["met"])
        yield Goal(*goal, met, f"seed {result['seed']}, commit {result['commit']}")
        fast_enough += met and board.core_mhz >= BOARD_CLOCK
    yield at_least(f"bitstreams of boards at {BOARD_CLOCK:g} MHz or above", fast_enough, 2, "")


def netlist_ticks(full: bool) -> Iterator[Goal]:
    """Whole ticks of both programs, core on the netlist next to core in RTL."""
    for configuration in ("small", "fast"):
        for program in ticks.PROGRAMS:
            name = f"ticks of {program} on the netlist of {configuration}"
            if configuration == "fast" and not full:
                yield not_measured(f"{name}, as RTL", f">= {TICKS}", "", FULL)
                continue
            done, first = netlist_run(program, configuration, TICKS if full else 100)
            row = depth(f"{name}, as RTL", done, TICKS, "", FULL)
            if first is not None:
                row = replace(row, met=False, note=f"tick {first} differs")
            yield row


def netlist_run(program: str, configuration: str, count: int) -> tuple[int, int | None]:
    """Ticks that agree in bits and cycles, and the first that does not. Raises NetlistError."""
    tasks = list(ticks.tasks_of(program, configuration, count))
    waiting = [task for task in tasks if cache.load(task) is None]

    def failed(task: ticks.Task, text: str) -> None:
        raise NetlistError(f"{task.name}: {text}")

    campaign.run(waiting, lambda task, result: None, failed, 1, work=ticks.execute)
    results = [result for task in tasks if (result := cache.load(task)) is not None]
    wrong = [result["differs"] for result in results if result["differs"] is not None]
    return (min(wrong), min(wrong)) if wrong else (sum(r["ticks"] for r in results), None)


def netlist_units(full: bool) -> Iterator[Goal]:
    """Modules next to their netlists with random inputs."""
    for top in (*UNITS, *BLOCKS):
        name = f"clocks of {top} whose outputs differ from its netlist's"
        if top in BLOCKS and not full:
            yield not_measured(name, "0", "", FULL)
            continue
        clocks = 1_000_000 if full else 100_000
        outcome = outcome_of(f"{top}-random-{clocks}", partial(lockstep.run, top, clocks=clocks))
        yield compared(name, f"{clocks} clocks", outcome)


def at_work(full: bool) -> Iterator[Goal]:
    """Modules next to their netlists in the models that existing tests run."""
    for work, (count, unit) in AT_WORK.items():
        name = f"clocks of {work} at work whose outputs differ from its netlist's"
        if full:
            outcome = outcome_of(f"{work}-{count}", partial(beside.run, work, count))
            yield compared(name, f"{count} {unit}", outcome)
        else:
            yield not_measured(name, "0", "", FULL)


@functools.cache
def fingerprint(places: tuple[Path, ...] = COMPARED) -> str:
    """Changes with the files and folders that a comparison compares, runs or is made with."""
    locks = ROOT.glob("requirements*.lock")
    return cache.fingerprint([*places, *locks], os.environ.get("SEED", ""))


def outcome_of(
    key: str, compare: Callable[[], Outcome], places: tuple[Path, ...] = COMPARED
) -> Outcome:
    """The outcome cached for the present files of `places`, else that of `compare`.

    Raises NetlistError.
    """
    entry = cache.Entry(OUTCOMES / f"{key}.json", fingerprint(places))
    found = cache.result_of(entry, lambda: asdict(compare()))
    return Outcome(found["first"], found["bits"], tuple(found["still"]))


def compared(name: str, what: str, outcome: Outcome) -> Goal:
    """Goal of an outcome; not met with a difference or if no output ever changed."""
    moved = outcome.bits - len(outcome.still)
    note = f"{what}, {moved} of {outcome.bits} output bits changed"
    if outcome.first is not None:
        note = f"from clock {outcome.first} on"
    row = exactly(name, int(outcome.first is not None), 0, "", note)
    return replace(row, met=row.met and moved > 0)


def proofs(full: bool) -> Iterator[Goal]:
    """Units proved equal to their netlists by induction."""
    for top in PROVED if full else PROVED[:1]:
        proved, points = prove_equivalent(top)
        name = f"points of {top} not proved equal to its netlist's"
        yield exactly(name, points - proved, 0, "", f"of {points}, by induction")


def clocks() -> Iterator[Goal]:
    """Table 4 and the clock of both configurations on ECP5-85 grade 8."""
    tops = synthesised()["tops"]
    for name, limit in (("asip_small", CLOCK), ("asip_fast", CLOCK * MARGIN)):
        top = tops[name]
        seeds = top["fmax_mhz"].get("runs") or len(top["fmax_mhz"]["seeds"])
        note = f"median of {seeds} seeds, commit {top['commit']}"
        yield at_least(f"{name}: clock", top["fmax_mhz"]["median"], limit, "MHz", note)
    for name in ("fpga1", "fpga2"):
        top = tops.get(name)
        value, note = (None, "not run") if top is None else (top["aluts"], top["commit"])
        yield Goal(
            f"{name}: whole system placed and routed", value, "ALUTs", "measured", bool(top), note
        )


PRODUCERS = {
    "boards": lambda full: boards(),
    "clocks and table 4": lambda full: clocks(),
    "units": netlist_units,
    "at work": at_work,
    "proofs": proofs,
    "ticks": netlist_ticks,
}


def measured(name: str, full: bool) -> Iterator[Goal]:
    """Rows of a producer; where its netlist cannot be made or run, the last one says so."""
    try:
        yield from PRODUCERS[name](full)
    except NetlistError as error:
        yield Goal(f"{name}, all", None, "", "measured", False, str(error).splitlines()[0])


@command("microtick silicon")
def main(arguments: list[str] | None = None) -> int:
    """Command line; exit 0 if every goal is met, 1 if one is missed."""
    parser = command_parser("microtick silicon", __doc__)
    parser.add_argument("--full", action="store_true", help="every netlist, 10 000 ticks")
    parser.add_argument(
        "--only",
        nargs="+",
        choices=tuple(PRODUCERS),
        default=list(PRODUCERS),
        metavar="ROWS",
        help=f"{', '.join(PRODUCERS)} (all)",
    )
    parser.add_argument(
        "--keep-boards", action="store_true", help="write docs/data/boards.json from build/boards"
    )
    options = parser.parse_args(arguments)
    if options.keep_boards:
        write_text(KEPT_BOARDS, json.dumps(board_results(), indent=2) + "\n")
        return 0
    console = Console(stderr=True, soft_wrap=True)
    goals: list[dict[str, Any]] = []
    for name in options.only:
        console.print(f"{name} ...", markup=False)
        goals += as_json(measured(name, options.full))
        write_goals(OUTPUT, goals, full=options.full)
    Console().print(terminal_table(goals))
    console.print(f"goals: {OUTPUT.relative_to(ROOT)}", markup=False)
    return int(bool(missed(goals)))


if __name__ == "__main__":
    sys.exit(main())
