# SPDX-License-Identifier: Apache-2.0
"""Goals of the Nios II systems and the debuggers, with programs of others: `make goals T=nios`."""

from __future__ import annotations

import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from asip_asm.project import ROOT
from sim.report.goals import Goal, at_least, at_most, depth, exactly, not_measured
from sim.rtl.nios_dhrystone import measure as dhrystone
from sim.rtl.nios_image import IMAGES
from sim.rtl.nios_rtl import PLATFORMS
from tests.bench.seed import SEED
from tests.conformance import coremark, dap_sessions, gdb_suite, torture
from tests.conformance.machine import MACHINES
from tests.conformance.tools import ToolError, clean_environment
from tests.debugger.dap_client import dap_session
from tests.debugger.debugged import INPUTS, LEG
from tests.debugger.test_dap_fields import PARTS, REQUESTS, fields, others
from tests.gdb.test_sequences import differences

FULL = "make goals T=nios RUN=full"
SEQUENCES, QUICK_SEQUENCES = 10_000, 100
TICKS = 100_000  # of the preemptive example in 10 s
QUICK_TORTURE = "2000011*.c strcmp.c"
PROMPT_MINUTES = 8.0
COREMARK = 2.22  # the lowest level of an earlier run by others


def sequences(full: bool) -> Iterator[Goal]:
    """Random packets of GDB's protocol against a model."""
    number = SEQUENCES if full else QUICK_SEQUENCES
    found = differences(number, SEED)
    name = "GDB protocol: random write-then-act sequences"
    yield depth(name, number, SEQUENCES, "sequences", FULL)
    yield exactly(f"{name} that differ from a model", len(found), 0, "", "; ".join(found[:1]))


def dap_fields(full: bool) -> Iterator[Goal]:
    """Fields of the protocol's schema that are neither obeyed nor refused by name."""
    total, silent = 0, []
    with dap_session() as client:
        client.launch(LEG, iss=True, set=INPUTS, stopOnEntry=True)
        client.go("configurationDone")
        for command in REQUESTS:
            definition = f"{command[0].upper()}{command[1:]}Arguments"
            total += len(fields(definition))
            for name, value in others(command, definition):
                if command == "initialize" and name.startswith("supports"):
                    continue
                client.sequence += 1
                message = {"seq": client.sequence, "type": "request", "command": command}
                answer = client.exchange(message | {"arguments": {name: value}})
                if answer["success"] or f"'{name}' is not supported" not in answer["message"]:
                    silent.append(f"{command}.{name}")
    total += sum(len(fields(definition)) for definition in PARTS.values())
    name = "DAP: fields of the schema that are neither obeyed nor refused by name"
    yield exactly(name, len(silent), 0, "", f"of {total}" + "".join(f"; {s}" for s in silent[:1]))


def others_clients(full: bool) -> Iterator[Goal]:
    """VS Code's test client on the debug adapter, GDB's own tests on the stub."""
    name = "DAP: checks of sessions under VS Code's test client that fail"
    try:
        found = dap_sessions.measure(full)
    except ToolError as error:
        yield not_measured(name, "0", "", str(error))
    else:
        checks = [check for core in found.values() for check in core]
        failed = [check["check"] for check in checks if not check["passed"]]
        note = f"of {len(checks)} on {len(found)} cores" + "".join(f"; {f}" for f in failed[:1])
        yield exactly(name, len(failed), 0, "", note)
    name = "GDB: tests of its own test suite that fail without a reason in the table"
    try:
        rows = gdb_suite.measure([] if full else ["remote.exp", "compare-sections.exp"])
    except ToolError as error:
        yield not_measured(name, "0", "", str(error))
    else:
        passed = sum(row["counts"].get("PASS", 0) for row in rows)
        known = sum(len(row["explained"]) for row in rows)
        failed = [text for row in rows for text in row["failed"]]
        note = f"{passed} pass, {known} fail for a reason, {len(rows)} files"
        yield exactly(name, len(failed), 0, "", note)


def preemption(full: bool) -> Iterator[Goal]:
    """The preemptive example; in its quick form the committed image."""
    name = "preemptive example: wrong results"
    if full:
        with tempfile.TemporaryDirectory() as folder:
            command = ["make", "-s", "-C", ROOT / "nios_sw", f"BUILD={folder}", f"TICKS={TICKS}"]
            elfs = [Path(folder, f"tasks_{system}.elf") for system in PLATFORMS]
            done = subprocess.run([*command, *elfs], env=clean_environment())
            if done.returncode:
                yield not_measured(
                    name, "0", "results", "make tools T=nios-toolchain builds the compiler"
                )
                return
            texts = [tasks(elf, system) for elf, system in zip(elfs, PLATFORMS, strict=True)]
    else:
        texts = [tasks(IMAGES / "run/tasks_fpga2.elf", "fpga2")]
    found = [re.search(r"(\d+) results.* (\d+) wrong", text) for text in texts]
    ticks = [re.search(r"atexit, ticks (\d+)", text) for text in texts]
    if not all(found) or not all(ticks):
        yield Goal(name, None, "results", "0", False, "the program did not end well")
        return
    seconds = min(int(match[1]) for match in ticks) / 10_000
    yield depth("preemptive example: simulated time under a 10 kHz tick", seconds, 10, "s", FULL)
    results = sum(int(match[1]) for match in found)
    yield exactly(name, sum(int(match[2]) for match in found), 0, "", f"of {results} results")


def tasks(elf: Path, system: str) -> str:
    """What the example prints."""
    run = [Path(sys.executable).with_name("nios-run"), "--system", system]
    return subprocess.run(
        [*run, "--max-cycles", "1100000000", elf], stdout=subprocess.PIPE, text=True
    ).stdout


def execution_tests(full: bool) -> Iterator[Goal]:
    """GCC's own execution tests."""
    name = "GCC's execution tests that fail without a reason in the table"
    try:
        found = torture.measure(MACHINES) if full else torture.measure(["fpga2"], QUICK_TORTURE)
    except ToolError as error:
        yield not_measured(name, "0", "tests", str(error))
        return
    passed = sum(outcome.passed for outcome in found.values())
    excluded = sum(outcome.excluded.total() for outcome in found.values())
    failed = [text for outcome in found.values() for text in outcome.failed]
    note = (
        f"{passed} pass, {excluded} excluded, on {', '.join(found)} at {' '.join(torture.LEVELS)}"
    )
    yield exactly(name, len(failed), 0, "tests", note + "".join(f"; {f}" for f in failed[:1]))
    yield depth("GCC's execution tests that pass", passed, 14_000, "tests", FULL)


def per_mhz(full: bool) -> Iterator[Goal]:
    """Dhrystone and CoreMark on both systems."""
    for system in PLATFORMS:
        found = dhrystone(system)
        note = f"{found.cycles_per_run:.0f} cycles a run"
        yield at_least(f"Dhrystone, {system}", found.dmips_per_mhz, 1.11, "DMIPS/MHz", note)
    try:
        scores = coremark.measure()
    except ToolError as error:
        yield not_measured("CoreMark", f">= {COREMARK:g}", "1/MHz", str(error))
    else:
        for each in scores:
            name = f"CoreMark, {each.system}, {each.options}"
            yield at_least(name, each.per_mhz, COREMARK, "1/MHz", each.compiler)


def first_prompt(full: bool) -> Iterator[Goal]:
    """From a clone to GDB's prompt in a program, without the cross compiler."""
    name = "time from clone to the first GDB prompt, on 2 idle cores"
    target = f"<= {PROMPT_MINUTES:g}"
    if not full:
        yield not_measured(name, target, "min", FULL)
        return
    idle = os.getloadavg()[0] < 1
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        clone, cache = Path(folder, "clone"), Path(folder, "cache")
        environment = clean_environment() | {"NIOS2_TOOLCHAIN": str(cache), "JOBS": "2"}
        elf = "nios_sw/images/run/speed_debug_fpga2.elf"
        session = f"target remote | .venv/bin/nios-run --gdb - {elf}"
        gdb = [cache / "install/bin/nios2-elf-gdb", "-nx", "-batch"]
        build = "from sim.rtl.nios_rtl import NiosRtl; NiosRtl('fpga2', debug=True)"
        for command in (
            ["git", "clone", "-q", ROOT, clone],
            ["make", "-s", "-C", clone, "tools", "T=nios-gdb"],
            [clone / ".venv/bin/python", "-c", build],
            [*gdb, "-ex", session, "-ex", "break main", "-ex", "continue", elf],
        ):
            place = clone if clone.exists() else ROOT
            done = subprocess.run(
                command, cwd=place, env=environment, stdout=subprocess.PIPE, text=True
            )
            if done.returncode:
                yield Goal(name, None, "min", target, False, f"{Path(command[0]).name} fails")
                return
        reached = "Breakpoint 1, main ()" in done.stdout
    minutes = (time.monotonic() - begun) / 60
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    work = (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime) / 60
    note = f"{work:.1f} min of processor time"
    if not reached:
        yield Goal(name, minutes, "min", target, False, "GDB did not stop in main")
    elif idle or minutes <= PROMPT_MINUTES:
        yield at_most(name, minutes, PROMPT_MINUTES, "min", note)
    else:
        yield Goal(name, minutes, "min", target, None, f"{note}; the machine was not idle")
