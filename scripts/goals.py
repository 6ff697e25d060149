# SPDX-License-Identifier: Apache-2.0
"""Measure goals: what each part of the project should reach, and what it reaches today.

    make goals                       list the names
    make goals T=workbench           measure one of them, in its quick form
    make goals T=workbench RUN=full  measure to full depth
    python -m scripts.goals motion --docs   the table of its page, from build/motion.json
    make goals T="workbench area"    only the producers whose name contains one of the further words

The goals go to the terminal and to build/NAME.json. Goals of producers that a run leaves out keep
the values of the file. A goal that a quick run measured on a sample only, or whose tool is missing,
is neither met nor missed. The exit status is 1 if a goal is missed.
"""

from __future__ import annotations

import importlib
import json
import logging
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from asip_asm.command import command, command_parser
from asip_asm.project import ROOT
from sim.report.goals import Goal, markdown_table, merged, missed, terminal_table, write_goals
from sim.report.marks import write_between_marks

BUILD = ROOT / "build"


@dataclass(frozen=True)
class Area:
    """A part of the project that has goals.

    producers: name -> "module:function", a function `rows(full: bool) -> Iterator[Goal]`.
    command: "module:main" of a command that measures and writes build/NAME.json by itself; parts:
    its words are names of producers.
    page, mark: the page below docs and the marks there between which `--docs` puts the table of
    the producers named in `shown`, of all without any.
    """

    about: str
    producers: dict[str, str] = field(default_factory=dict)
    command: str = ""
    parts: bool = False
    page: str = ""
    mark: str = ""
    shown: tuple[str, ...] = ()


AREAS: dict[str, Area] = {
    "bus": Area(
        "EtherCAT slave: masters, cycles, clocks, area, and a path over the bus.",
        command="scripts.bus:main",
        parts=True,
    ),
    "drive": Area(
        "Motor drives in closed loop, their hardware, and their proofs.",
        command="scripts.drive:main",
        parts=True,
    ),
    "hardware": Area(
        "RTL for other tools, cocotb tests, coverage, area and clock.",
        {
            "other tools": "scripts.hardware_goals:rows",
            "functional coverage": "tests.cocotb.functional:rows",
            "code coverage": "scripts.code_coverage:rows",
            "planted faults": "tests.cocotb.planted:rows",
            "plain Verilog": "scripts.plain_goals:rows",
            "clock": "scripts.clock_goals:hardware",
        },
    ),
    "linuxcnc": Area(
        "LinuxCNC drives the machine; G-code reader against it; PROGRAMS=FOLDER adds programs.",
        {
            "machine": "scripts.linuxcnc_rows:rows",
            "samples": "sim.bench.motion.goals_linuxcnc:samples",
            "programs": "sim.bench.motion.goals_linuxcnc:programs",
        },
        page="ethercat.md",
        mark="linuxcnc",
        shown=("machine",),
    ),
    "matrix": Area(
        "Matrix laws: streams, laws on fast, predictive control, policies.",
        {
            "matrix product": "sim.bench.matrix_goals:rows",
            "laws on fast": "sim.bench.matrix_law_goals:rows",
            "predictive control": "sim.bench.stream_law_goals:predictive_control",
            "landing": "sim.bench.stream_law_goals:landing",
            "drive loops": "sim.bench.observer_goals:drive_loops",
            "observer": "sim.bench.observer_goals:rows",
            "policies": "sim.bench.stream_law_goals:policies",
            "area and clock": "scripts.clock_goals:matrix",
        },
        page="your_robot.md",
        mark="goals",
    ),
    "motion": Area(
        "Motion front-end: planner, look-ahead, pulses, interpolators, drives.",
        {
            "planner": "sim.bench.motion.goals_planner:rows",
            "pulses and steps": "sim.bench.motion.goals_rtl:rows",
            "paths": "sim.bench.motion.goals_lookahead:paths",
            "random programs": "sim.bench.motion.goals_lookahead:random_paths",
            "long part": "sim.bench.motion.goals_lookahead:parts",
            "drives": "sim.bench.motion.goals_drive:rows",
        },
        page="motion.md",
        mark="goals",
    ),
    "nios": Area(
        "Nios II systems: protocols, C programs of others, figures per MHz.",
        {
            "sequences": "tests.conformance.goals:sequences",
            "DAP fields": "tests.conformance.goals:dap_fields",
            "clients of others": "tests.conformance.goals:others_clients",
            "preemption": "tests.conformance.goals:preemption",
            "GCC tests": "tests.conformance.goals:execution_tests",
            "per MHz": "tests.conformance.goals:per_mhz",
            "clock": "scripts.clock_goals:nios",
            "first prompt": "tests.conformance.goals:first_prompt",
        },
    ),
    "robots": Area(
        "Laws compiled from robot descriptions: proofs, certificates, cycles.",
        {
            "URDF files": "sim.bench.shown_robots.campaign:rows",
            "planted mistakes": "tests.model_compiler.planted:rows",
            "cycles": "sim.bench.shown_robots.cycles:rows",
            "best options": "sim.bench.best_goals:rows",
            "mutated files": "tests.fuzz.__main__:rows",
            "certificate": "sim.bench.certificate_goals:rows",
        },
    ),
    "security": Area(
        "Hostile files, ports, packets, signals, caches and environments.",
        {
            "ports": "tests.security.campaign_ports:rows",
            "files": "tests.security.campaign_files:rows",
            "caches": "tests.security.campaign_caches:rows",
            "environments": "tests.security.campaign_environments:rows",
            "kills": "tests.security.campaign_kills:rows",
        },
    ),
    "silicon": Area(
        "Netlists against RTL, bitstreams, area and clock.", command="scripts.silicon:main"
    ),
    "upsets": Area(
        "Single flipped bits in whole ticks of the core.", command="tests.upsets.__main__:main"
    ),
    "workbench": Area(
        "Debug block, debugger, scope and GDB.",
        {
            "same runs": "tests.debug.rows:same_runs",
            "halted runs": "tests.debug.rows:halted_runs",
            "live parameters": "tests.debug.rows:live_parameters",
            "scope": "tests.debug.rows:scope",
            "area": "scripts.workbench_area:rows",
            "formal": "scripts.workbench_area:proofs",
            "asip-scope": "sim.debug.scope.goals:rows",
            "nios-gdb": "tests.gdb.goals:rows",
            "asip-dbg": "tests.debugger.goals:rows",
        },
    ),
}


def write_table(name: str) -> None:
    """Puts the goals of build/NAME.json into the area's page. Raises ValueError, MarksError."""
    area, file = AREAS[name], BUILD / f"{name}.json"
    if not area.page:
        pages = ", ".join(each for each, found in AREAS.items() if found.page)
        raise ValueError(f"goals '{name}' have no table in a page here; {pages} have")
    if not file.exists():
        raise ValueError(f"there is no build/{name}.json: run make goals T={name}")
    goals = _earlier(file)["goals"]
    shown = [goal for goal in goals if not area.shown or goal["producer"] in area.shown]
    write_between_marks(ROOT / "docs" / area.page, {area.mark: markdown_table(shown)})


def measure(name: str, place: str, full: bool) -> list[Goal]:
    """Goals of a producer; a producer that fails is a goal that is missed."""
    module, _, function = place.partition(":")
    try:
        return list(getattr(importlib.import_module(module), function)(full))
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        return [Goal(name, None, "", "measured", False, reason)]


def wanted(area: Area, words: Sequence[str]) -> list[str]:
    """Names of the producers that contain one of the words. Raises ValueError without any."""
    found = [name for name in area.producers if not words or any(word in name for word in words)]
    if not found:
        known = ", ".join(area.producers)
        raise ValueError(f"no producer with {' or '.join(words)}; there are {known}")
    return found


def _earlier(output: Path) -> dict[str, Any]:
    """What earlier runs wrote; nothing where there is no file."""
    return json.loads(output.read_text()) if output.exists() else {}


def _depth(full: bool) -> str:
    return "full" if full else "quick"


def measure_area(name: str, words: Sequence[str], full: bool, console: Console) -> int:
    """Measure the producers of an area; the exit status. Raises ValueError for unknown words."""
    producers = AREAS[name].producers
    names = wanted(AREAS[name], words)
    output = BUILD / f"{name}.json"
    goals: list[dict] = []
    for n, producer in enumerate(names, 1):
        earlier = _earlier(output).get("seconds", {}).get(f"{producer}, {_depth(full)}")
        wait = f" (it took {earlier:.0f} s before)" if earlier else ""
        console.print(f"[{n}/{len(names)}] {producer} ...{wait}", markup=False)
        begun = time.monotonic()
        rows = measure(producer, producers[producer], full)
        passed = time.monotonic() - begun
        console.print(f"[{n}/{len(names)}] {producer}: {passed:.0f} s", markup=False)
        # Written after each producer: a run that is stopped loses nothing.
        content, goals = merged(output, producer, rows, list(producers))
        seconds = content.get("seconds", {}) | {f"{producer}, {_depth(full)}": round(passed, 1)}
        write_goals(output, goals, full=full, seconds=seconds)
    Console().print(terminal_table(goals))
    names_missed = missed(goal for goal in goals if goal["producer"] in names)
    if names_missed:
        console.print(f"missed: {', '.join(names_missed)}", style="red", markup=False)
    return int(bool(names_missed))


@command("make goals")
def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = command_parser("make goals", __doc__)
    parser.add_argument(
        "name", nargs="?", metavar="NAME", help="goals to measure; without it, list the names"
    )
    parser.add_argument("words", nargs="*", help="only producers whose name contains one of these")
    parser.add_argument("--full", action="store_true", help="measure to full depth")
    parser.add_argument(
        "--docs", action="store_true", help="write the table of the page from build/NAME.json"
    )
    options = parser.parse_args(arguments)
    console = Console(stderr=True, soft_wrap=True)
    if options.name is None:
        listing = Table("name", "what is measured", box=None)
        for name, area in AREAS.items():
            listing.add_row(name, area.about)
        Console().print(listing)
        return 0
    try:
        if options.name not in AREAS:
            raise ValueError(f"no goals '{options.name}'; there are {', '.join(AREAS)}")
        area = AREAS[options.name]
        if options.docs:
            write_table(options.name)
            return 0
        logging.getLogger("asip_asm").setLevel(logging.ERROR)  # Random programs cause warnings.
        if area.command:
            if options.words and not area.parts:
                raise ValueError(f"goals '{options.name}' are measured as a whole; leave out words")
            module, _, function = area.command.partition(":")
            run = getattr(importlib.import_module(module), function)
            return run([*options.words, *(["--full"] if options.full else [])])
        return measure_area(options.name, options.words, options.full, console)
    except ValueError as error:
        console.print(f"error: {error}", style="red", markup=False)
        return 2


if __name__ == "__main__":
    sys.exit(main())
