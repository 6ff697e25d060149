# SPDX-License-Identifier: Apache-2.0
"""How long the main job will take: ticks of every task, and what a tick cost in the last run."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path

from asip_asm.files import write_text
from asip_asm.project import BUILD
from sim.bench.run import nios
from sim.bench.run.workers import PROCESSES

AS_PRINTED, OPTIMISED, OBSERVER = "as printed", "optimised", "observer"
STAMPS = "stamps"
LAW = "law in double precision"
COMPARISON = "comparison"
PLATFORMS = ("fpga1", "fpga2", "fpga3")
# Seconds per tick until a run has measured its own: on an idle x86-64 processor of 2021.
TYPICAL = {
    AS_PRINTED: 5e-4,
    OPTIMISED: 3.5e-4,
    OBSERVER: 3.7e-4,
    STAMPS: 5e-4,
    LAW: 1.5e-4,
    "fpga1 beginning": 8e-3,
    "fpga1": 8e-3,
    "fpga2 beginning": 2.5e-3,
    "fpga2": 2.5e-3,
    COMPARISON: 5e-5,
}
TELLING = 10_000  # a run of at least this many ticks updates the cost of a tick
FILE = BUILD / "run_costs.json"


def beginning(platform: str) -> str:
    """Name of the task that runs a platform in closed loop over its first ticks."""
    return f"{platform} beginning"


def work(
    ticks: int, platforms: Iterable[str], full: bool, programs: Iterable[str] = ()
) -> dict[str, int]:
    """Ticks of every task for a path of so many; full: FPGA1 and FPGA2 take every tick; programs:
    those of FPGA3 besides the two that always run there."""
    platforms = set(platforms)
    found = {}
    for name in (AS_PRINTED, OPTIMISED, *programs) if "fpga3" in platforms else (LAW,):
        found[name] = ticks
    for platform in sorted(platforms & set(nios.SAMPLES)):
        found[beginning(platform)] = nios.beginning_ticks(platform, ticks)
        found[platform] = nios.window_ticks(platform, ticks, full)
    return found | {COMPARISON: ticks}


def costs(file: Path = FILE) -> dict[str, float]:
    """Seconds per tick of every task: of the last run, else typical ones."""
    try:
        measured = json.loads(file.read_text(encoding="utf-8"))
        known = {name: float(measured[name]) for name in TYPICAL if name in measured}
    except (OSError, ValueError, TypeError):
        return dict(TYPICAL)
    return TYPICAL | {name: cost for name, cost in known.items() if cost > 0.0}


def keep(measured: Mapping[str, float], file: Path = FILE) -> None:
    """Keep the seconds per tick of a run for the next estimate."""
    file.parent.mkdir(parents=True, exist_ok=True)
    write_text(file, json.dumps(costs(file) | dict(measured), indent=2) + "\n")


def seconds(ticks: Mapping[str, int], cost: Mapping[str, float]) -> float:
    """Time of the tasks `ticks`, spread over the worker processes as well as they can be."""
    alone = {name: count * cost[name] for name, count in ticks.items()}
    comparing = alone.pop(COMPARISON)
    return max(max(alone.values()), sum(alone.values()) / PROCESSES) + comparing
