# SPDX-License-Identifier: Apache-2.0
"""Goals of LinuxCNC that drives the machine: `make goals T=linuxcnc`.

A quick run plays the first moments of A-G-H; RUN=full plays all of it, hours, and the four faults.
Results are cached in build/bus for the sources that they were measured with.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from typing import Any

from asip_asm.project import BUILD, ROOT
from scripts.bus_rows import (
    BENCH,
    DEVICE,
    PROGRAM,
    ROBOT,
    TOOL_UM,
    cached,
    fingerprint,
    rtl_of,
    versions,
)
from sim.bus.linuxcnc.__main__ import FAULTS
from sim.bus.linuxcnc.config import missing
from sim.report.goals import Goal, at_most, exactly, not_measured

QUICK_S = 0.5
FULL = "make goals T=linuxcnc RUN=full"
# LinuxCNC's state, the slave's AL state and code, and the longest time until the brakes close [ms].
STATES = {
    "estop": ("ESTOP", 0x08, 0x0000, 40),
    "drive": ("ESTOP_RESET", 0x08, 0x0000, 40),
    "cable": ("ESTOP", 0x14, 0x001A, 40),
    "master": ("ESTOP", 0x14, 0x001A, 40),
}


def played(options: Sequence[str]) -> dict[str, Any]:
    """Report of `microtick linuxcnc` with these options, of this run or of an earlier one."""
    name = "linuxcnc_" + ("_".join(options).replace("--", "") or "whole")
    output = BUILD / "linuxcnc_run" / name

    def work() -> dict[str, Any]:
        words = [sys.executable, "-m", "sim.bus.linuxcnc", *options, "--output", str(output)]
        job = subprocess.run(words, cwd=ROOT, stdout=subprocess.DEVNULL)
        report = output / "linuxcnc.json"
        if job.returncode and not report.exists():
            raise RuntimeError(f"microtick linuxcnc {' '.join(options)} gave no result")
        return json.loads(report.read_text(encoding="utf-8"))

    ours = [f"sim/bus/linuxcnc/*.{kind}" for kind in ("py", "comp", "hal", "ini", "sh")]
    files = [*BENCH, *PROGRAM, *ROBOT, *ours, "sim/paths/agh.ngc", *rtl_of("asip")]
    return cached(name, fingerprint(DEVICE, files, *options, *versions("pysoem")), work)


def defined(report: dict[str, Any], fault: str) -> bool:
    """Whether LinuxCNC, slave and brakes are as the page says of the fault."""
    state, al_state, al_code, limit_ms = STATES[fault]
    after = report["after_fault"]
    brakes = after["brakes_after"]
    return (
        (after["linuxcnc"], report["al_state"], report["al_code"]) == (state, al_state, al_code)
        and brakes is not None
        and brakes <= 10 * limit_ms
        and (fault == "estop" or bool(after["messages"]))
    )


def rows(full: bool) -> Iterator[Goal]:
    """A-G-H from LinuxCNC to the robot, and the four faults."""
    part = "whole path" if full else f"first {QUICK_S:g} s"
    about = f"A-G-H from LinuxCNC over bus, slave, drives and law in RTL, {part}"
    states = "faults after which LinuxCNC, drives and slave are in defined states"
    if lack := missing():
        yield not_measured(f"{about}, tool error", f"<= {TOOL_UM}", "um", lack)
        yield not_measured(states, f"{len(FAULTS)}", "faults", lack)
        return
    report = played([] if full else ["--seconds", f"{QUICK_S:g}"])
    yield at_most(f"{about}, tool error", round(1e6 * report["tool_error"], 3), TOOL_UM, "um")
    yield exactly(f"{about}, following-error faults", report["following_faults"], 0, "faults")
    yield exactly(f"{about}, servo periods lost", report["lost"], 0, "periods")
    if not full:
        yield not_measured(states, f"{len(FAULTS)}", "faults", FULL)
        return
    good = [fault for fault in FAULTS if defined(played(["--fault", fault]), fault)]
    yield exactly(states, len(good), len(FAULTS), "faults", ", ".join(good))
