# SPDX-License-Identifier: Apache-2.0
"""What the drives are to reach, and what of it is measured: the rows of build/drive.json."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.bench.drive import draws, speed
from sim.bench.drive.chain import ORDER_FILTER
from sim.bench.drive.current_loop import loop_program, rise_and_overshoot
from sim.bench.drive.delays import delays
from sim.bench.drive.plant import NAMES
from sim.bench.drive.position import SHOWN, PositionLoops, position_loops
from sim.bench.drive.recording import KINDS
from sim.bench.drive.response import NOISE, Response, distortion, responses, steps
from sim.bench.drive.sample import SETTLED, SKIP, Sample, samples
from sim.bench.drive.whole import Whole, path_of, whole
from sim.laws.drive.current_law import Setting
from sim.report.goals import Goal, at_least, at_most, not_measured
from sim.robot.drives import Drives
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints
from sim.rtl.processes import processes

SMALL = 0.03  # of i_max: a step that the bus voltage allows; it limits the rise of larger ones
CYCLES = {"small": 700, "fast": 220}
DISTORTION = 5.0
PATH_TARGETS = (("leg", "um", 1e6, 1.5), ("tool", "um", 1e6, 7.0), ("table", "urad", 1e6, 75.0))
SHORT, FULL = 30_000, None  # ticks of the A-G-H path
SAMPLE, LONG = 0.2, 2.0  # s of the path of reversals, every clock
BELIEVED = (1.0, 0.8, 1.2)  # of the friction, by a law
LAWS = (
    ("none", 1.0),
    *((kind, share) for kind in ("feed-forward", "adaptive") for share in BELIEVED),
)
OF = "share of without"
HALVED = 0.5
GROUPS = {"leg": slice(3), "table": slice(3, 5)}  # of the axes
MINUTES = 30  # of a processor, each simulation
JOBS = 2
NOISE_ABOVE = 1.25  # of what is measured
EQUAL = (0.2, 20.0)  # um of a leg, urad of a table axis: largest errors, averaged and every clock
SAME_CURRENT = 4e-3  # A rms: averaged inverters with orders and motion of every clock


FULL_RUN = "microtick drive --full"


@dataclass(frozen=True)
class Loops:
    """i_q of the step (halves, 5) [A], frequency responses of the axes."""

    step: NDArray[np.float64]
    responses: list[Response]


@dataclass(frozen=True)
class Shown:
    """What the page draws: current and position loops, the path with each law's errors, the RTL
    samples."""

    loops: Loops
    positions: PositionLoops
    path: SetPoints
    laws: dict[tuple[str, float], Whole]
    samples: dict[str, Sample]


class Rows(list[Goal]):
    """The goals in the order of their measurement; a value None was not measured."""

    def most(self, name: str, value: float | None, unit: str, target: float) -> None:
        """A value that may be `target` at most."""
        self.append(
            not_measured(name, f"<= {target:g}", unit, FULL_RUN)
            if value is None
            else at_most(name, value, target, unit)
        )

    def least(self, name: str, value: float | None, unit: str, target: float) -> None:
        """A value that must be `target` at least."""
        self.append(
            not_measured(name, f">= {target:g}", unit, FULL_RUN)
            if value is None
            else at_least(name, value, target, unit)
        )


def measure_loops(robot: Robot, drives: Drives, rows: Rows, report: Callable[[str], None]) -> Loops:
    """The rows of the current loops alone, in some minutes. Raises StartUpError."""
    chain = Setting(robot.resolution, order_filter=ORDER_FILTER)
    for configuration, target in CYCLES.items():
        report(f"program of five axes on {configuration}")
        found = loop_program(drives, chain, configuration).cycles
        rows.most(f"five current loops on {configuration}", found, "cycles", target)
    setting = Setting(robot.resolution)  # the loops after the order filter
    report("step of the current, every clock")
    step, noise = steps(robot, drives, SMALL)
    rises, overshoots = zip(
        *(rise_and_overshoot(i_q, setting.period) for i_q in step[9:].T), strict=True
    )
    about = "every clock, dead time, noise"
    rows.most(f"step of the current, 10 % to 90 %, {about}", 1e6 * max(rises), "us", 100)
    rows.most(f"step of the current, overshoot, {about}", 100 * max(overshoots), "%", 15)
    rows.most(
        "noise of a sensed current, what averaged inverters take", 1e3 * noise, "mA", 1e3 * NOISE
    )
    rows.most("the same, of the measured noise", NOISE / noise, "1", NOISE_ABOVE)
    report("frequency response, every clock")
    loops = responses(robot, drives, setting)
    bandwidth, margin = min(r.bandwidth for r in loops), min(r.margin for r in loops)
    loop = "closed current loop after the command filter"
    rows.least(f"{loop}, -3 dB, {about}", bandwidth, "Hz", 5000)
    rows.least(f"{loop}, phase margin, {about}", margin, "degrees", 45)
    report("dead time, every clock")
    name = "dead-time distortion at 5 % of rated current, compensated, every clock, noise"
    for sensing, text in ((False, name), (True, f"{name}, errors of the sensing")):
        without = distortion(robot, drives, replace(setting, compensation=0.0), sensing)
        gain = float((without / distortion(robot, drives, setting, sensing)).min())
        rows.least(text, gain, "times", DISTORTION)
    return Loops(step, loops)


def measure_path(
    robot: Robot, drives: Drives, full: bool, rows: Rows, report: Callable[[str], None]
) -> tuple[SetPoints, dict[tuple[str, float], Whole]]:
    """The rows of the A-G-H path on averaged inverters, each law in a run of its own, two at the
    same time. Raises ControllerFault."""
    words = path_of(robot, FULL if full else SHORT)
    what = "whole path" if full else f"first {SHORT * robot.T_s:g} s of the path"
    report(f"{what}, averaged inverters, {len(LAWS)} laws of friction")
    with processes(JOBS) as pool:
        work = {law: pool.submit(_timed, robot, drives, words, *law) for law in LAWS}
        done = {law: one.result() for law, one in work.items()}
    found = {law: run for law, (run, _) in done.items()}
    best, plain = found["feed-forward", 1.0], found["none", 1.0]
    for name, unit, scale, target in PATH_TARGETS:
        rows.most(f"{what}, {name}", scale * getattr(best.tracking, name), unit, target)
    for name in ("leg", "table"):
        share = getattr(best, f"reversal_{name}") / getattr(plain, f"reversal_{name}")
        rows.most(f"{what}, {name} at reversals with feed-forward, {OF}", share, "1", HALVED)
    for share in BELIEVED:
        told = f"{share:g} of the friction"
        for kind in ("feed-forward", "adaptive"):
            if (run := found[kind, share]) is not best:
                left = run.reversal_leg / plain.reversal_leg
                name = f"{what}, leg at reversals, {kind} with {told}, {OF}"
                rows.most(name, left, "1", HALVED)
    fed, adapted = (
        max(found[kind, share].reversal_leg for share in BELIEVED)
        for kind in ("feed-forward", "adaptive")
    )
    name = f"{what}, leg at reversals, the worst of these beliefs, adaptive of feed-forward"
    rows.most(name, adapted / fed, "1", 1.0)
    minutes = max(seconds for _, seconds in done.values()) / 60
    name = "whole path with averaged inverters, processor time"
    rows.most(name, minutes if full else None, "minutes", MINUTES)
    return words, found


def _timed(
    robot: Robot, drives: Drives, words: SetPoints, kind: str, share: float
) -> tuple[Whole, float]:
    begin = time.process_time()
    return whole(robot, drives, words, kind, share), time.process_time() - begin


def measure_chain(
    robot: Robot, drives: Drives, full: bool, rows: Rows, report: Callable[[str], None]
) -> dict[str, Sample]:
    """The rows of the chain's RTL on the path of reversals. Raises ControllerFault,
    StartUpError."""
    seconds = LONG if full else SAMPLE
    what = f"{seconds:g} s of every clock"
    report(f"{what} of the chain")
    kinds = KINDS if full else ("feed-forward",)
    found = samples(robot, drives, round(seconds / robot.T_s), kinds, JOBS)
    best, plain = found["feed-forward"], found.get("none")
    largest = best.largest
    errors = largest[:3].max(), best.tool[SETTLED:].max(), largest[3:].max()
    for error, (name, unit, scale, target) in zip(errors, PATH_TARGETS, strict=True):
        rows.most(f"{what}, {name}", scale * float(error), unit, target)
    for name, axes in GROUPS.items():
        share = None
        if plain is not None:
            share = float(best.at_reversals[axes].max() / plain.at_reversals[axes].max())
        text = f"{LONG:g} s of every clock, {name} at reversals with feed-forward, {OF}"
        rows.most(text, share, "1", HALVED)
    name = f"averaged inverters against {what}, current of the same orders and motion"
    apart = [piece.current for piece in found.values()]
    rms = max(float(np.sqrt((each**2).mean(axis=0)).max()) for each in apart)
    rows.most(f"{name}, rms", rms, "A", SAME_CURRENT)
    ticks = round(SAMPLE / robot.T_s) - 2  # what `same_currents` has of so many commands
    report(f"{SAMPLE:g} s of the current loops, every clock, two draws of the noise")
    noise = float(np.abs(draws.apart(robot, drives, best.rtl, ticks)).max())
    most = float(np.abs(best.current[: ticks - SKIP]).max())
    text = f"averaged inverters against RTL, largest current difference in the first {SAMPLE:g} s"
    rows.most(f"{text}; target: between two RTL runs with other noise", most, "A", noise)
    for (name, axes), unit, most in zip(GROUPS.items(), ("um", "urad"), EQUAL, strict=True):
        off = 1e6 * max(float(piece.difference[axes].max()) for piece in found.values())
        text = f"averaged inverters against {what}, largest error of each {name}"
        rows.most(text, off, unit, most)
    both = sum(int(piece.rtl.shoot_through) for piece in found.values())
    rows.most("edges of gates with both of a phase on", both, "1", 0)
    minutes = max(float(piece.rtl.seconds) for piece in found.values()) * LONG / seconds / 60
    name = f"every clock of the chain for {LONG:g} s of the path, processor time"
    rows.most(name + ("" if full else f", from {seconds:g} s"), minutes, "minutes", MINUTES)
    return found


@dataclass
class Job:
    """What to measure; shown: fields of `Shown` by name, as far as this run has measured them."""

    robot: Robot
    drives: Drives
    full: bool
    report: Callable[[str], None]
    shown: dict[str, Any] = field(default_factory=dict)


Part = Callable[[Job, Rows], Mapping[str, Any]]
"""Adds its rows; further fields of build/drive.json. Raises ControllerFault, StartUpError."""


def loops_part(job: Job, rows: Rows) -> Mapping[str, Any]:
    """The current loops alone."""
    loops = measure_loops(job.robot, job.drives, rows, job.report)
    job.shown["loops"] = loops
    return {"delays": delays(job.robot, job.drives)}


def speeds_part(job: Job, rows: Rows) -> Mapping[str, Any]:
    """Speeds from time stamps and observers."""
    rows += speed.goals(*speed.compare(job.robot, job.full, job.report))
    return {}


def path_part(job: Job, rows: Rows) -> Mapping[str, Any]:
    """The A-G-H path and the position loops, averaged inverters."""
    words, laws = measure_path(job.robot, job.drives, job.full, rows, job.report)
    job.report("frequency response of the position loops, averaged inverters")
    positions = position_loops(job.robot, job.drives)
    job.shown |= {"path": words, "laws": laws, "positions": positions}
    names = (NAMES[n] for n in SHOWN)
    return {"position_loops": dict(zip(names, positions.bandwidth, strict=True))}


def chain_part(job: Job, rows: Rows) -> Mapping[str, Any]:
    """The chain's RTL; a full run simulates `LONG` seconds of it."""
    job.shown["samples"] = measure_chain(job.robot, job.drives, job.full, rows, job.report)
    return {}


PARTS: dict[str, Part] = {
    "loops": loops_part,
    "speeds": speeds_part,
    "path": path_part,
    "chain": chain_part,
}
PATHS = ("speeds", "path", "chain")
