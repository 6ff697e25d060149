# SPDX-License-Identifier: Apache-2.0
"""The main job: the ASIP, as RTL, tracks a G-code path in closed loop with the robot."""

from __future__ import annotations

import argparse
import json
import sys
import time
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures import wait as wait_for
from multiprocessing import Manager
from pathlib import Path
from queue import Empty, Queue

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from asip_asm.assemble import assemble
from asip_asm.diagnostics import AssemblyError
from asip_asm.image import Image
from sim.harness.asip_rtl import AsipRtl
from sim.harness.build import BuildError
from sim.harness.nios_image import ImageError
from sim.harness.nios_rtl import NiosRtl
from sim.model.parameters import ParameterError, Robot
from sim.model.records import SetPoints, TrackingResult
from sim.model.tracking import joint_path
from sim.motion.command import add_robot_option
from sim.motion.gcode import GcodeErrors, parse_file
from sim.motion.moves import Motion
from sim.motion.trajectory import MotionSettings, Trajectory, WorkspaceError, generate
from sim.run import closed_loop, nios, page, tables
from sim.run.controller import AsipController, ControllerFault, Ticks
from sim.run.progress import TickProgress
from sim.run.results import Comparison, ProgramRun, compare, results, row_errors

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ROOT / "asip_asm/programs"
AS_PRINTED, OPTIMISED, REPLAY = "as printed", "optimised", "optimised, same counts"


def _run_as_printed(
    robot: Robot, path: SetPoints, as_printed: Image, optimised: Image, queue: Queue
) -> tuple[ProgramRun, Ticks, int, float]:
    """As-printed program in closed loop, then the optimised one on the same counts."""
    begin = time.perf_counter()
    controller = AsipController(as_printed)
    recording = closed_loop.run(robot, path, controller, lambda n: queue.put((AS_PRINTED, n)))
    other = AsipController(optimised)
    ticks = closed_loop.replay(path, recording.counts, other, lambda n: queue.put((REPLAY, n)))
    cycles = controller.core.cycles + other.core.cycles
    return _measured(controller, recording), ticks, cycles, time.perf_counter() - begin


def _run_optimised(
    robot: Robot, path: SetPoints, optimised: Image, queue: Queue
) -> tuple[ProgramRun, int, float]:
    """Optimised program in closed loop."""
    begin = time.perf_counter()
    controller = AsipController(optimised)
    recording = closed_loop.run(robot, path, controller, lambda n: queue.put((OPTIMISED, n)))
    return _measured(controller, recording), controller.core.cycles, time.perf_counter() - begin


def _measured(controller: AsipController, recording: closed_loop.Recording) -> ProgramRun:
    issued = controller.core.issued(len(controller.image.bundles))
    runs = len(recording.counts) + 1  # priming runs the program once
    return ProgramRun(controller.image, recording, issued, runs)


def _simulate(
    robot: Robot, path: SetPoints, as_printed: Image, optimised: Image, console: Console
) -> tuple[ProgramRun, ProgramRun, Ticks, dict[str, float]]:
    begin = time.perf_counter()
    with Manager() as manager, ProcessPoolExecutor(2) as pool, TickProgress(console) as bars:
        queue = manager.Queue()
        jobs = [
            pool.submit(_run_as_printed, robot, path, as_printed, optimised, queue),
            pool.submit(_run_optimised, robot, path, optimised, queue),
        ]
        for name in (AS_PRINTED, OPTIMISED, REPLAY):
            bars.add(name, len(path))
        _show_progress(jobs, queue, bars)
        printed, replayed, printed_cycles, printed_time = jobs[0].result()
        better, better_cycles, better_time = jobs[1].result()
    cycles = printed_cycles + better_cycles
    return (
        printed,
        better,
        replayed,
        {
            "cycles": cycles,
            "wall_s": time.perf_counter() - begin,
            "cycles_per_second": cycles / (time.perf_counter() - begin),
            "cycles_per_second_per_process": cycles / (printed_time + better_time),
        },
    )


def _simulate_nios(
    robot: Robot,
    path: SetPoints,
    counts: NDArray[np.int32],
    comparison: Comparison,
    full: bool,
    console: Console,
) -> list[nios.NiosRun]:
    """FPGA1 and FPGA2, a process each, on the counts of the as-printed run."""
    with Manager() as manager, ProcessPoolExecutor(2) as pool, TickProgress(console) as bars:
        queue = manager.Queue()
        jobs = []
        for platform in nios.SAMPLES:
            bars.add(platform, nios.total_ticks(robot, platform, comparison.single, full))
            jobs.append(
                pool.submit(
                    _run_nios, robot, path, counts, comparison.single, platform, full, queue
                )
            )
        _show_progress(jobs, queue, bars)
        return [job.result() for job in jobs]


def _run_nios(
    robot: Robot,
    path: SetPoints,
    counts: NDArray[np.int32],
    single: TrackingResult,
    platform: str,
    full: bool,
    queue: Queue,
) -> nios.NiosRun:
    return nios.run(robot, path, counts, single, platform, full, lambda n: queue.put((platform, n)))


def _show_progress(jobs: list[Future], queue: Queue, bars: TickProgress) -> None:
    """Advance the bars until every job is done or one has failed."""
    while not all(job.done() for job in jobs) or not queue.empty():
        try:
            name, ticks = queue.get(timeout=0.2)
            bars.advance(name, ticks)
        except Empty:
            if any(job.done() and job.exception() for job in jobs):
                break
    wait_for(jobs)


def _drawing(trajectory: Trajectory, ticks: int) -> NDArray[np.bool_]:
    feed = np.array([block.move.motion is not Motion.RAPID for block in trajectory.blocks])
    return ((trajectory.block >= 0) & feed[trajectory.block])[:ticks]


def run(arguments: argparse.Namespace, console: Console) -> None:
    """The whole job; writes below arguments.output."""
    out: Path = arguments.output
    out.mkdir(parents=True, exist_ok=True)
    robot = Robot.load(arguments.robot)
    console.print(f"[bold]1/6[/] trajectory of {arguments.gcode}")
    trajectory = generate(parse_file(arguments.gcode), MotionSettings(robot))
    path = nios.set_points(trajectory, arguments.ticks)
    console.print(
        f"      {len(path)} ticks of {robot.T_s * 1e6:g} µs, {len(trajectory.blocks)} blocks"
    )

    console.print("[bold]2/6[/] assembling the tracking programs")
    images = []
    for name in ("tracking_as_printed", "tracking_optimised"):
        image = assemble(PROGRAMS / f"{name}.s", configuration="fast", defines=robot.values())
        image.save(out / f"{name}.asip.json")
        console.print(f"      {name}: {len(image.bundles)} bundles, {image.cycles} cycles expected")
        images.append(image)

    console.print("[bold]3/6[/] building the Verilated systems (once per change of the RTL)")
    AsipRtl("fast").close()
    for platform in nios.SAMPLES:
        NiosRtl(platform).close()

    console.print("[bold]4/6[/] closed loop: encoder counts from the plant, forces from the RTL")
    printed, better, replayed, simulation = _simulate(robot, path, *images, console)

    counts = printed.recording.counts
    comparison = compare(robot, path, counts)
    sampled = "every tick" if arguments.all_ticks else "a sample of the ticks (RUN=full: all)"
    console.print(f"[bold]5/6[/] Nios II systems FPGA1 and FPGA2: {sampled}")
    nios_runs = _simulate_nios(robot, path, counts, comparison, arguments.all_ticks, console)

    console.print("[bold]6/6[/] comparing with double precision and printed float32")
    data = results(robot, path, printed, better, replayed, comparison, simulation)
    data["robot"] = {"file": str(arguments.robot), "values": robot.values()}
    nios.add_results(data, nios_runs, path, comparison.reference, comparison.single, row_errors)
    (out / "results.json").write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    written = list(tables.all_tables(data))
    for table in written:
        console.print()
        console.print(table)
    speed = simulation["cycles_per_second"]
    console.print(
        f"\n{simulation['cycles']:,} clock cycles simulated in {simulation['wall_s']:.0f} s: "
        f"{speed / 1e6:.2f} M cycles/s"
    )
    if not arguments.no_plots:
        shown = page.Shown(
            gcode=arguments.gcode,
            robot=robot,
            path=path,
            desired=joint_path(robot, path)[0],
            drawing=_drawing(trajectory, len(path)),
            recordings={OPTIMISED: better.recording, AS_PRINTED: printed.recording},
            results=data,
            tables=written,
            robot_file=arguments.robot,
        )
        page.write(out, shown)
        console.print(f"page and plots: {out / 'index.html'}")
    console.print(f"figures:        {out / 'results.json'}")


def main(argv: list[str] | None = None) -> int:
    """Command line; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m sim.run",
        description=__doc__,
        epilog="example: python -m sim.run sim/paths/circle.ngc --output build/circle",
    )
    parser.add_argument(
        "gcode", type=Path, nargs="?", default=ROOT / "sim/paths/agh.ngc", help="path (RS-274)"
    )
    add_robot_option(parser)
    parser.add_argument("--ticks", type=int, help="only the first TICKS ticks of the path")
    parser.add_argument(
        "--all-ticks", action="store_true", help="FPGA1 and FPGA2 take every tick too (hours)"
    )
    parser.add_argument(
        "--output", type=Path, default=ROOT / "build", help="folder of results.json and index.html"
    )
    parser.add_argument("--no-plots", action="store_true", help="tables and results.json only")
    arguments = parser.parse_args(argv)
    if arguments.ticks is not None and arguments.ticks < 1:
        parser.error(f"--ticks {arguments.ticks} is not positive")
    console = Console()
    try:
        run(arguments, console)
    except (GcodeErrors, WorkspaceError, ParameterError, AssemblyError) as error:
        console.print(str(error), markup=False, highlight=False)
        return 1
    except (BuildError, ControllerFault, ImageError, OSError) as error:
        console.print(f"error: {error}", markup=False, highlight=False)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
