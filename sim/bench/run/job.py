# SPDX-License-Identifier: Apache-2.0
"""The stages of the main job: plan the path, build the systems, simulate, compare, write."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from asip_asm.assemble import assemble
from asip_asm.files import write_text
from asip_asm.image import Image
from asip_asm.project import ROOT
from sim.bench.run import checks, estimate, nios, page, scoped, tables
from sim.bench.run.estimate import AS_PRINTED, LAW, OBSERVER, OPTIMISED, STAMPS
from sim.bench.run.progress import TickProgress, duration
from sim.bench.run.results import Comparison, ProgramRun, compare, results, worst_of_bound
from sim.bench.run.workers import Workers
from sim.core import closed_loop
from sim.core.backends import RtlBackend
from sim.core.controller import AsipController, LawController
from sim.debug.scope.process import ScopeProcess
from sim.debug.scope.tap import Place, TapSource
from sim.motion.gcode.interpreter import stream_file
from sim.motion.gcode.tools import NO_TOOLS, Tool, tool_file
from sim.motion.geometry.moves import Item, Move, from_line
from sim.motion.geometry.override import AS_PROGRAMMED, overridden
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.trajectory.program import ProgramPath, plan_stream, set_points
from sim.motion.trajectory.windows import Place as WindowPlace
from sim.robot import float32
from sim.robot.observer import SPEEDS
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints, TrackingResult
from sim.robot.stamps import StampedPlant
from sim.robot.tracking import joint_path
from sim.rtl.asip_rtl import AsipRtl
from sim.rtl.nios_rtl import NiosRtl

PROGRAMS = ROOT / "asip_asm/programs"
MANY_STOPS = 20  # the run suggests G64 from this many stops on
# Task that runs a program of FPGA3 -> key in results.json; source in PROGRAMS: tracking_<key>.s.
KEYS = {AS_PRINTED: "as_printed", OPTIMISED: "optimised", OBSERVER: "observer", STAMPS: "stamps"}


class PathError(ValueError):
    """The program or its path cannot be run; the text says where and why."""


@dataclass(frozen=True)
class Order:
    """What to do. line: begin there; ticks: only the first so many; seconds: only the motion
    between two times; platforms: of estimate.PLATFORMS; all_ticks: FPGA1 and FPGA2 take every tick
    too; tools: LinuxCNC's table; plan_only: stop before anything is built or written; speed: one of
    `observer.SPEEDS`, all but the first run a third program of FPGA3."""

    gcode: Path
    robot: Path
    output: Path
    line: int | None = None
    ticks: int | None = None
    seconds: tuple[float, float] | None = None
    platforms: Sequence[str] = estimate.PLATFORMS
    all_ticks: bool = False
    tools: Path | None = None
    plots: bool = True
    plan_only: bool = False
    override: float = AS_PROGRAMMED  # percent of the feeds
    scope: bool = False  # show the loop of `looked_at` in the browser while it runs
    speed: str = "difference"

    @property
    def programs(self) -> tuple[str, ...]:
        """Tasks of FPGA3 besides the two that always run."""
        return () if self.speed == SPEEDS[0] else (self.speed,)

    @property
    def looked_at(self) -> str:
        """The program of FPGA3 that scope and page show first."""
        return self.programs[0] if self.programs else OPTIMISED


@dataclass(frozen=True)
class _Job:
    """An order with what it is about: path, programs of FPGA3 by task, ticks of every task and
    seconds that a tick of it is expected to take."""

    order: Order
    robot: Robot
    console: Console
    planned: ProgramPath
    path: SetPoints
    images: dict[str, Image]
    work: dict[str, int]
    cost: dict[str, float]


@dataclass
class _Measured:
    """Runs of FPGA3 by key, counts that FPGA1 and FPGA2 are given and their float32 answer, their
    runs, seconds per tick of every task."""

    counts: NDArray[np.int32]
    single: TrackingResult
    programs: dict[str, ProgramRun] = field(default_factory=dict)
    nios: list[tuple[nios.Beginning, nios.NiosRun]] = field(default_factory=list)
    costs: dict[str, float] = field(default_factory=dict)
    wall: float = 0.0


def _run_program(
    robot: Robot, path: SetPoints, image: Image, place: Place | None, progress: Any
) -> ProgramRun:
    """A program of FPGA3 in closed loop; place: of the scope that looks at it."""
    controller = AsipController(image, watched=scoped.watched(image) if place else ())
    tap = scoped.LoopTap(place, path, controller) if place else None
    begin = tuple(path.position[0]), tuple(path.table_position[0])
    plant = StampedPlant(robot, *begin) if "stamp1" in controller.inputs else None
    recording = closed_loop.run(robot, path, controller, progress, tap, plant)
    touched = tap.end() if tap else ()
    assert isinstance(controller.core, RtlBackend)
    rtl = controller.core.rtl
    issued = rtl.issued(len(image.bundles))
    runs = len(path) + 1  # priming runs the program once
    return ProgramRun(image, recording, issued, runs, rtl.cycles, touched)


def _run_law(robot: Robot, path: SetPoints, progress: Any) -> NDArray[np.int32]:
    """Counts of the tracking law in double precision in closed loop."""
    return closed_loop.run(robot, path, LawController(robot), progress).counts


def _planned(order: Order, robot: Robot, console: Console) -> ProgramPath:
    try:
        tools = NO_TOOLS if order.tools is None else tool_file(order.tools)
        with console.status("reading") as status:
            # All mistakes of the program are reported before anything is planned.
            total = sum(isinstance(item, Move) for item in _items(order, tools, robot))
            path = plan_stream(
                _items(order, tools, robot),
                str(order.gcode),
                robot,
                order.ticks,
                order.seconds,
                lambda moves, time: status.update(
                    f"planning: {moves} of {total} moves, {time:.0f} s of motion"
                ),
            )
    except ValueError as error:
        raise PathError(str(error)) from error
    corners = path.corners
    console.print(
        f"      path time {path.time:.4g} s"
        + ("" if path.whole else " of a longer program")
        + f"; {len(path)} ticks of {robot.T_s * 1e6:g} µs; {path.count} moves"
        + (f"; feed override {order.override:g} %" if order.override != AS_PROGRAMMED else "")
    )
    for place in path.windows:
        begin = max(0, place.planned - path.rest) * robot.T_s
        console.print(
            f"      window of {place.ticks * robot.T_s:.4g} s at {begin:.4f} s: {place.why}",
            soft_wrap=True,
        )
    hint = corners.stops > MANY_STOPS and not any(move.exact_stop for move in path.moves)
    meetings = corners.rounded + corners.smooth + corners.stops
    console.print(
        f"      {meetings} places where moves meet: {corners.rounded} rounded, {corners.smooth} "
        f"smooth, {corners.stops} stops"
        + (f"; {corners.rest:g} s of rests" if corners.rest else "")
        + ("; G64 P0.01 in the program would round corners" if hint else ""),
        soft_wrap=True,
    )
    return path


def _items(order: Order, tools: Mapping[int, Tool], robot: Robot) -> Iterator[Item]:
    """Moves and rests of the program, from the chosen line on, at the override of the feeds."""
    items = stream_file(order.gcode, tools=tools, robot=robot)
    if order.line is not None:
        items = from_line(items, order.line, str(order.gcode))
    return overridden(items, order.override, MachineLimits.of(robot).tool.speed)


def _images(order: Order, robot: Robot, console: Console) -> dict[str, Image]:
    images = {}
    for name in (AS_PRINTED, OPTIMISED, *order.programs) if "fpga3" in order.platforms else ():
        key = KEYS[name]
        source = PROGRAMS / f"tracking_{key}.s"
        images[name] = image = assemble(source, configuration="fast", defines=robot.values())
        image.save(order.output / f"{source.stem}.asip.json")
        console.print(
            f"      {source.stem}: {len(image.bundles)} bundles, {image.cycles} cycles expected"
        )
    return images


def _build(order: Order) -> None:
    if "fpga3" in order.platforms:
        AsipRtl("fast").close()
    for platform in nios.SAMPLES:
        if platform in order.platforms:
            NiosRtl(platform).close()


def _scope(job: _Job) -> AbstractContextManager[ScopeProcess | None]:
    """The scope of a program's loop, if it is wanted."""
    order, robot = job.order, job.robot
    if not order.scope:
        return nullcontext()
    name = order.looked_at
    image, title = job.images[name], f"{order.gcode.name} on {name}"
    tuner = scoped.RobotTuner(robot, PROGRAMS / f"tracking_{KEYS[name]}.s", image)
    about = scoped.description(title, robot, order.robot, job.path, image, tuner)
    return ScopeProcess(TapSource(about, tuner), job.console)


def _simulate(job: _Job, bars: TickProgress, place: Place | None) -> _Measured:
    """Everything that the worker processes do. The longest task begins first."""
    begin = time.perf_counter()
    order, robot, path, n = job.order, job.robot, job.path, len(job.path)
    systems = [platform for platform in nios.SAMPLES if platform in order.platforms]
    with Workers(bars) as workers:
        runs = {
            name: workers.submit(
                name,
                n,
                *(_run_program, robot, path, image),
                place if name == order.looked_at else None,
            )
            for name, image in job.images.items()
        }
        law = None if runs else workers.submit(LAW, n, _run_law, robot, path)
        beginnings = {
            platform: workers.submit(
                estimate.beginning(platform),
                nios.beginning_ticks(platform, n),
                *(nios.follow_beginning, robot, path, platform),
            )
            for platform in systems
        }
        programs = {}
        if law is None:
            programs["as_printed"] = workers.result(runs[AS_PRINTED])
            counts = programs["as_printed"].recording.counts
        else:
            counts = workers.result(law)
        measured = _Measured(counts, float32.run(robot, path, counts), programs)
        windows = {
            platform: workers.submit(
                platform,
                nios.window_ticks(platform, n, order.all_ticks),
                *(nios.run, robot, path, counts, measured.single, platform, order.all_ticks),
            )
            for platform in systems
        }
        if law is None:
            for name in (OPTIMISED, *order.programs):
                programs[KEYS[name]] = workers.result(runs[name])
        measured.nios += [
            (workers.result(beginnings[platform]), workers.result(windows[platform]))
            for platform in systems
        ]
        measured.costs = {name: s / job.work[name] for name, s in workers.seconds.items()}
    measured.wall = time.perf_counter() - begin
    return measured


def _simulation(measured: _Measured) -> dict[str, float]:
    """Clock cycles and time of the programs of FPGA3."""
    cycles = sum(run.cycles for run in measured.programs.values())
    spent = sum(
        measured.costs[name] * len(measured.counts)
        for name, key in KEYS.items()
        if key in measured.programs
    )
    nios_cycles = sum(b.simulated + run.simulated for b, run in measured.nios)
    return {
        "cycles": cycles,
        "nios_cycles": nios_cycles,
        "wall_s": measured.wall,
        "cycles_per_second": cycles / measured.wall,
        "cycles_per_second_per_process": cycles / spent if spent else 0.0,
    }


def _lines(path: ProgramPath, place: WindowPlace) -> list[int]:
    """First and last line of the program that a window runs, none in a rest at the start."""
    numbers = path.move[place.tick : place.tick + place.ticks]
    lines = [path.moves[n].line for n in np.unique(numbers[numbers >= 0]).tolist()]
    return [min(lines), max(lines)] if lines else []


def _path_data(path: ProgramPath) -> dict[str, Any]:
    """Moves, corners and what bounded the speed, for results.json."""
    corners = path.corners
    return {
        "whole": path.whole,
        "moves": path.count,
        "corners_rounded": corners.rounded,
        "joints_smooth": corners.smooth,
        "stops": corners.stops,
        "rests_s": corners.rest,
        "speed_limited_by": path.limited_by,
        "windows": [
            {
                "why": place.why,
                "first_tick": place.tick,
                "ticks": place.ticks,
                "at_s": max(0, place.planned - path.rest) * path.period,
                "lines": _lines(path, place),
            }
            for place in path.windows
        ],
        "slowest_corners": [
            {
                "line": joint.line,
                "angle_deg": math.degrees(joint.angle),
                "tolerance_mm": joint.tolerance * 1e3 if math.isfinite(joint.tolerance) else None,
                "apex_mm": joint.apex * 1e3,
                "speed_mm_s": joint.speed * 1e3,
            }
            for joint in corners.slowest
        ],
    }


def run(order: Order, console: Console) -> dict[str, Any]:
    """The whole job; writes below order.output and returns the content of results.json."""
    if order.scope and "fpga3" not in order.platforms:
        raise PathError("the scope looks at the ASIP: add fpga3 to the platforms")
    if order.programs and "fpga3" not in order.platforms:
        raise PathError(
            f"speed {order.speed!r} is of a program of the ASIP: add fpga3 to the platforms"
        )
    robot = Robot.load(order.robot)
    console.print(f"[bold]1/6[/] path of {order.gcode}", highlight=False)
    planned = _planned(order, robot, console)
    path = set_points(planned)
    work = estimate.work(len(path), order.platforms, order.all_ticks, order.programs)
    cost = estimate.costs()
    console.print(
        f"      estimated time of the simulation: {duration(estimate.seconds(work, cost))} on "
        "two idle processors"
    )
    if order.plan_only:
        return {}
    order.output.mkdir(parents=True, exist_ok=True)

    console.print("[bold]2/6[/] assembling the tracking programs")
    job = _Job(order, robot, console, planned, path, _images(order, robot, console), work, cost)

    console.print("[bold]3/6[/] building the Verilated systems (once per change of the RTL)")
    _build(order)

    with _scope(job) as scope:
        return _track(job, scope)


def _track(job: _Job, scope: ScopeProcess | None) -> dict[str, Any]:
    """Everything from the first tick on."""
    order, robot, console, path = job.order, job.robot, job.console, job.path
    sampled = "" if order.all_ticks else "; FPGA1 and FPGA2 take a sample (RUN=full: every tick)"
    console.print(f"[bold]4/6[/] closed loop: counts from the plant, forces from the RTL{sampled}")
    with TickProgress(console, {name: (n, job.cost[name]) for name, n in job.work.items()}) as bars:
        measured = _simulate(job, bars, scope.source.place if scope else None)
    touched = [entry for run in measured.programs.values() for entry in run.touched]
    if touched:
        _tell_touched(order.looked_at, touched, console)
        return {}
    console.print("[bold]5/6[/] comparing with double precision and printed float32")
    begin = time.perf_counter()
    data = _compared(robot, path, measured)
    data |= {
        "gcode": str(order.gcode),
        "path_time_s": job.planned.time,
        "feed_override_percent": order.override,
        "robot": {"file": str(order.robot), "values": robot.values()},
        "path": _path_data(job.planned),
        "simulation": _simulation(measured),
    }
    published = (
        checks.is_published(robot, order.gcode)
        and order.override == AS_PROGRAMMED
        and not job.planned.windows
        and order.line is None
    )
    checks.enter(data, published)
    data["goals"] = checks.goals(data, published)
    measured.costs[estimate.COMPARISON] = (time.perf_counter() - begin) / len(path)
    if len(path) >= estimate.TELLING:
        estimate.keep(measured.costs)

    console.print(f"[bold]6/6[/] writing below {order.output}", highlight=False)
    _write(job, measured, data)
    return data


def _tell_touched(name: str, touched: Sequence[str], console: Console) -> None:
    """A loop that somebody has changed is not the one that the bounds are about."""
    console.print(f"{name} was changed while it ran:", highlight=False)
    for entry in touched:
        console.print(f"      {entry}", highlight=False, soft_wrap=True)
    console.print(
        "The run is not compared, and no results are written. Put the parameters into a copy of "
        "the robot's file, then: make run ROBOT=FILE",
        soft_wrap=True,
    )


def _compared(robot: Robot, path: SetPoints, measured: _Measured) -> dict[str, Any]:
    """Each program against double precision on the counts that it saw."""
    common: Comparison = compare(robot, path, measured.counts)
    comparisons = {
        key: common
        if key == "as_printed"
        else compare(robot, path, run.recording.counts, key if key in SPEEDS else SPEEDS[0])
        for key, run in measured.programs.items()
    }
    data = results(robot, path, measured.programs, comparisons, common, measured.single)
    nios.add_results(data, measured.nios, path, common.reference, measured.single)
    for _, found in measured.nios:
        fractions = worst_of_bound(robot, common, found.results, False, found.ticks)
        data["worst_fraction_of_bound"][found.platform] = fractions
    return data


def _write(job: _Job, measured: _Measured, data: dict[str, Any]) -> None:
    """results.json, tables, page and plots."""
    console, out = job.console, job.order.output
    write_text(out / "results.json", json.dumps(data, indent=2) + "\n")
    written = list(tables.all_tables(data))
    for table in written:
        console.print()
        console.print(table)
    console.print()
    described = data["path"]
    bounds = list(described["speed_limited_by"].items())[:4]
    console.print(
        f"{described['corners_rounded']} corners rounded, {described['stops']} stops"
        + ("; speed limited by " if bounds else "")
        + ", ".join(f"{name} {share:.0%} of the time" for name, share in bounds),
        soft_wrap=True,
    )
    simulation = data["simulation"]
    if simulation["cycles"]:
        console.print(
            f"{simulation['cycles']:,} clock cycles simulated in {simulation['wall_s']:.0f} s: "
            f"{simulation['cycles_per_second'] / 1e6:.2f} M cycles/s"
        )
    if job.order.plots:
        shown = page.Shown(
            gcode=job.order.gcode,
            robot=job.robot,
            path=job.path,
            desired=joint_path(job.robot, job.path)[0],
            drawing=job.planned.drawing,
            recordings={
                name: measured.programs[KEYS[name]].recording
                for name in dict.fromkeys((job.order.looked_at, OPTIMISED, AS_PRINTED))
                if KEYS[name] in measured.programs
            },
            results=data,
            tables=written,
            robot_file=job.order.robot,
        )
        page.write(out, shown)
        console.print(f"page and plots: {out / 'index.html'}", highlight=False)
    console.print(f"figures:        {out / 'results.json'}", highlight=False)
    for entry in data["exceeded"]:
        console.print(f"error: {entry['text']}", markup=False, highlight=False)
