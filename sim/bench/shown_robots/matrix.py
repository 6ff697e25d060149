# SPDX-License-Identifier: Apache-2.0
"""Laws that `microtick robots` shows after the robots: a rocket that lands, an observer, and five
drive loops that meet a load. Each is compiled, proved, and runs in closed loop.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from asip_asm.model.program import Built
from sim.bench.drive.current_loop import loop_program
from sim.bench.drive.load_step import Loaded
from sim.bench.observer_goals import LOOPS
from sim.bench.observer_goals import MOST as OBSERVER
from sim.bench.shown_robots.job import COMPILE_SECONDS, RATIO, Row
from sim.bench.stream_law_goals import LANDING
from sim.laws.closed_loop import ClosedLoop, Loop, close_loop
from sim.laws.drive.current_law import AXES, current_law, observed
from sim.laws.mpc import build_mpc
from sim.laws.mpc_proof import prove_mpc
from sim.laws.observer import build_observer, follow, observer, prove_observer
from sim.laws.prove_program import COUNT, Proof, prove
from sim.laws.rocket_landing import Landing, descent, land_core, land_reference, rocket_problem
from sim.report.goals import Goal, at_least, at_most, exactly
from sim.robot.drives import Drives
from sim.robot.parameters import Robot

PERIOD = 1e-3  # s of the observer
LEAST = {"rocket": 5.0, "observer": 0.9, "drives": 0.03}
"""Seconds of closed loop that a shown law runs at least."""
DEFAULT = {"observer": 2.0, "drives": 0.04}
"""Seconds of closed loop without an option. The rocket's run ends on the ground."""
MOST = {"rocket": LANDING["stream"], "observer": OBSERVER["wide"], "drives": LOOPS["fast"]}
"""Cycles of a tick at most."""


def rocket(folder: Path, inputs: int, seconds: float | None, seed: int) -> Row:
    """Landing under predictive control with a thrust cone. Errors: distance from the reference."""
    problem = rocket_problem()
    begin = time.monotonic()
    built, _ = build_mpc(problem, folder / "rocket.s", "stream")
    passed = time.monotonic() - begin
    found = prove_mpc(problem, built.compiled, built.image, inputs, seed)
    landing, cycles = land_core(problem, built.image)
    proof = Proof(
        inputs_tried=found.ticks,
        bits_equal=not found.difference and not found.other_cycles and cycles == {built.cycles},
        first_difference=found.difference, worst_fraction_of_bound=found.share,
        worst_result="an input of the plant", unbounded=0,
        largest_error=dict.fromkeys(problem.inputs, found.error), within={}, seed=seed,
    )  # fmt: skip
    double = land_reference(problem)
    ticks = min(len(landing.states), len(double.states))
    wanted = np.array([descent(k * problem.sample_time) for k in range(ticks)])

    def flown(one: Landing) -> Loop:
        return Loop(one.states[:ticks] - wanted, one.inputs[:ticks])

    axes = dict(zip(problem.states, ("m",) * 3 + ("m/s",) * 3, strict=True))
    held = round(double.held * len(double.states))
    loop = ClosedLoop(ticks, flown(landing), flown(double), axes, held)
    return _row("rocket", built, passed, proof, loop, 1 / problem.sample_time, problem.inputs)


def watching(folder: Path, inputs: int, seconds: float | None, seed: int) -> Row:
    """Observer of 24 states, from recorded inputs of a nonlinear chain. Errors: of estimates."""
    system = observer()
    begin = time.monotonic()
    built = build_observer(system, folder / "observer.s", "wide")
    passed = time.monotonic() - begin
    found = prove_observer(system, built, inputs, seed=seed)
    proof = Proof(
        inputs_tried=found.ticks, bits_equal=not found.unequal and not found.other_cycles,
        first_difference=f"{found.unequal} words differ" if found.unequal else "",
        worst_fraction_of_bound=found.share, worst_result="an estimate", unbounded=0,
        largest_error=dict.fromkeys(system.states, found.error), within={}, seed=seed,
    )  # fmt: skip
    ticks = round((seconds or DEFAULT["observer"]) / PERIOD)
    seen = follow(system, built.image, ticks)
    double = seen.estimates - seen.core + seen.double
    axes = dict.fromkeys(system.states, "m")
    loop = ClosedLoop(ticks, Loop(seen.core, seen.estimates), Loop(seen.double, double), axes, 0)
    return _row("observer", built, passed, proof, loop, 1 / PERIOD, system.states)


def drives(folder: Path, inputs: int, seconds: float | None, seed: int) -> Row:
    """Current loops of five axes with disturbance observers, and a load on all five at once.
    Errors: displacements.
    """
    motors, setting = Drives.load(), observed(Robot.load())
    begin = time.monotonic()
    built = loop_program(motors, setting)
    passed = time.monotonic() - begin
    (folder / "drives.s").write_text(built.compiled.text, encoding="utf-8")
    proof = prove(built.compiled, built.image, count=inputs, seed=seed)
    ticks = round((seconds or DEFAULT["drives"]) / setting.period)
    machine = Loaded(motors, setting, {n: setting.moved[n] for n in AXES}, ticks)
    loop = close_loop(current_law(motors, setting), built.image, machine)
    names = [port.name for port in built.compiled.law.of_kind("output")]
    return _row("drives", built, passed, proof, loop, 1 / setting.period, names)


def _row(
    name: str, built: Built, seconds: float, proof: Proof, loop: ClosedLoop, rate: float,
    outputs: Sequence[str],
) -> Row:  # fmt: skip
    about = {"rocket": rocket, "observer": watching, "drives": drives}[name].__doc__ or ""
    text = " ".join(about.split())
    return Row(name, built, None, seconds, proof, loop, rate, about=text, outputs=tuple(outputs))


MATRIX: dict[str, Callable[[Path, int, float | None, int], Row]] = {
    "rocket": rocket,
    "observer": watching,
    "drives": drives,
}
"""What makes a row: folder of the program, inputs of the proof, seconds of motion or None, seed."""


def goals(rows: Sequence[Row]) -> list[Goal]:
    """Goals of these laws."""
    found: list[Goal] = []
    for row in rows:
        name, proof, loop = row.name, row.proof, row.loop
        worst = proof.worst_fraction_of_bound
        axis = f"{name}, error to double, worst {loop.worst}"
        found += [
            at_most(f"{name}, tick", row.built.cycles, MOST[name], "cycles"),
            at_most(f"{name}, compiled in", row.seconds, COMPILE_SECONDS, "s"),
            Goal(f"{name}, error/bound", worst, "", "< 1", worst < 1),
            exactly(f"{name}, without a bound", proof.unbounded, 0, "results"),
            at_least(f"{name}, inputs tried", proof.inputs_tried, COUNT, ""),
            exactly(f"{name}, bits unequal", float(not proof.bits_equal), 0, ""),
            at_least(f"{name}, closed loop", loop.ticks / row.rate, LEAST[name], "s"),
            at_most(axis, loop.ratio, RATIO, ""),
        ]
    return found
