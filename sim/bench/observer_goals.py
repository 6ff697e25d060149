# SPDX-License-Identifier: Apache-2.0
"""Observer of 24 states, and drive loops that observe their load: rows of `make goals T=matrix`."""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from asip_asm.model.certificate import EFFORT, certify
from asip_asm.model.compiler import compile_law
from asip_asm.model.law import Law
from sim.bench.drive.current_loop import OPTIONS, loop_program
from sim.bench.drive.load_step import load_step
from sim.laws.drive.current_law import AXES, current_law, observed
from sim.laws.observer import build_observer, observer, prove_observer, recording, watch
from sim.laws.prove_program import prove
from sim.report.goals import Goal, at_most, depth, exactly
from sim.robot.drives import Drives
from sim.robot.parameters import Robot

MOST = {"wide": 200, "stream": 300}
"""Cycles of a tick."""
LOOPS = {"fast": 210, "wide": 210}
LOADED, LASTING = (0, 3), 10.0
"""Axes that get a load; per cent of the displacement that it leaves without observers."""
COUNT, QUICK = 10_000, 500
WATCHED = {False: 1000, True: 10_000}
SECONDS = 60.0  # of one processor
RATIO = 1.001
LARGEST = 10.0
"""Error of the estimates by the size of the states, per cent: the plant is nonlinear."""
CURE = "make goals T=matrix RUN=full"


def rows(full: bool) -> Iterator[Goal]:
    """Cycles, bits, certificate, and errors of estimates of a nonlinear plant."""
    system = observer()
    for configuration, most in MOST.items():
        name = f"observer 24/5/3 on {configuration}"
        begin = time.process_time()
        with tempfile.TemporaryDirectory() as folder:
            built = build_observer(system, Path(folder) / "observer.s", configuration)
        seconds = time.process_time() - begin
        yield at_most(f"{name}, tick", built.cycles, most, "cycles")
        yield at_most(f"{name}, compile time", seconds, SECONDS, "s of a processor")
        proof = prove_observer(system, built, COUNT if full else QUICK)
        other = "runs with a cycle count other than announced"
        yield exactly(f"{name}, {other}", proof.other_cycles, 0, "")
        yield exactly(f"{name}, words that differ from the interpreter", proof.unequal, 0, "")
        note = f"{proof.error:.2g} m; the bound holds in every tick"
        yield at_most(
            f"{name}, error as a fraction of its certified bound", proof.share, 1, "1", note
        )
        yield depth(f"{name}, ticks tried", proof.ticks, COUNT, "1", CURE)
        ticks = WATCHED[full]
        seen = watch(system, built.image, ticks)
        size = float(np.sqrt((recording(ticks)[0] ** 2).mean()))
        note = f"{1000 * seen.double:.3g} mm in doubles, {ticks} ticks of a nonlinear chain"
        ratio = seen.core / seen.double
        what = "estimation error relative to double precision"
        yield at_most(f"{name}, {what}", ratio, RATIO, "1", note)
        yield at_most(
            f"{name}, estimation error relative to the states", 100 * seen.core / size, LARGEST, "%"
        )


def _certified(name: str, law: Law, axis: int) -> Goal:
    """Whether all results of an axis have an error bound for every input within its limits."""

    def progress(text: str) -> None:
        print(f"certificate of axis {axis}: {text}", file=sys.stderr, flush=True)

    found = certify(compile_law(law, OPTIONS).graph, law, EFFORT, progress)
    without = sum(not np.isfinite(each.bound) for each in found.bounds.values())
    pwm = max(each.bound for key, each in found.bounds.items() if key.startswith("pwm"))
    note = found.fault.text() if found.fault else f"pwm within {pwm:.2g} counts"
    return exactly(f"{name}, axis {axis}: results without a certificate", without, 0, "1", note)


def drive_loops(full: bool) -> Iterator[Goal]:
    """Current loops of five axes with a disturbance observer, and a load on two of them."""
    name, drives = "five drive loops with observers", Drives.load()
    setting = observed(Robot.load())
    for configuration, most in LOOPS.items():
        where = f"{name} on {configuration}"
        begin = time.process_time()
        built = loop_program(drives, setting, configuration)
        seconds = time.process_time() - begin
        yield at_most(f"{where}, tick", built.cycles, most, "cycles")
        yield at_most(f"{where}, compile time", seconds, SECONDS, "s of a processor")
        proof = prove(built.compiled, built.image, count=COUNT if full else QUICK)
        yield exactly(f"{where}, bits differ from the interpreter", not proof.bits_equal, 0, "1")
        yield exactly(f"{where}, results without a bound", proof.unbounded, 0, "")
        worst = proof.worst_fraction_of_bound
        yield at_most(
            f"{where}, error as a fraction of its bound", worst, 1, "1", proof.worst_result
        )
        yield depth(f"{where}, inputs tried", proof.inputs_tried, COUNT, "1", CURE)
    for axis in AXES if full else ():
        yield _certified(name, current_law(drives, setting, [axis]), axis)
    plain = replace(setting, observer=(0.0,) * 5)
    for axis in LOADED:
        mass = setting.moved[axis]
        with_it, without = (load_step(drives, each, axis, mass) for each in (setting, plain))
        share = 100 * with_it.lasting / without.lasting
        note = f"{1e6 * without.lasting:.3g} um or urad without, {1e6 * with_it.peak:.3g} at most"
        what = "lasting displacement under load, relative to that without the observer"
        yield at_most(f"{name}, axis {axis}: {what}", share, LASTING, "%", note)
        yield exactly(
            f"{name}, axis {axis}: different cycle counts of a tick", len(with_it.cycles), 1, ""
        )
