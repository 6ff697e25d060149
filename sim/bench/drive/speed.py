# SPDX-License-Identifier: Apache-2.0
"""Where the tracking law takes the speeds of the axes from, and what that does to the forces.

    python -m sim.bench.drive.speed           the first 3 s of the A-G-H path, a minute
    python -m sim.bench.drive.speed --full    the whole path, some minutes
    python -m sim.bench.drive.speed --docs    write docs/law.md and its plot from build/speed.json

Each program runs as RTL in closed loop with the rigid-body plant of the main job. `microtick drive`
measures the same rows. Exit status: 0 if every goal is met, 1 if one is missed, 2 wrong command
line.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from asip_asm.assemble import assemble
from asip_asm.command import command, script_parser
from asip_asm.files import replaced
from asip_asm.project import BUILD, ROOT
from sim.bench.drive.whole import path_of
from sim.core import closed_loop
from sim.core.controller import AsipController, ControllerFault
from sim.motion.command import add_robot_option
from sim.report.goals import Goal, as_json, at_most, missed, terminal_table, write_goals
from sim.report.marks import write_between_marks
from sim.robot.errors import RIPPLE_ABOVE, ripple
from sim.robot.observer import SPEEDS, gains
from sim.robot.parameters import ROBOT_TOML, ParameterError, Robot
from sim.robot.records import OUTPUTS, SetPoints
from sim.robot.stamps import StampedPlant
from sim.robot.tracking import run
from sim.rtl.build import BuildError
from sim.rtl.processes import processes

PROGRAMS = {
    "difference": "tracking_optimised",
    "observer": "tracking_observer",
    "stamps": "tracking_stamps",
}
SHORT = 30_000  # ticks of the A-G-H path
RIPPLE, ERROR = 0.1, 1.0  # of what differences of counts give
SHOWN = slice(6000, 6400)  # ticks of the plot
JOBS = 2
PAGE, PLOT = ROOT / "docs/law.md", ROOT / "docs/speed.svg"
COMMAND = "python -m sim.bench.drive.speed"


@dataclass(frozen=True)
class Measured:
    """A program over the path: cycles of a tick, ripple (5,) [N, N m], largest errors of leg, tool
    [m], table [rad], delay of the legs' speeds [s], phase margins of leg and table loop [degrees],
    forces (N, 5)."""

    cycles: int
    ripple: NDArray[np.float64]
    tracking: closed_loop.Tracking
    delay: float
    margins: tuple[float, float]
    outputs: NDArray[np.floating]


def measured(robot: Robot, path: SetPoints, speed: str) -> Measured:
    """One program on the core over a path. Raises ControllerFault."""
    source = ROOT / f"asip_asm/programs/{PROGRAMS[speed]}.s"
    image = assemble(source, configuration="fast", defines=robot.values())
    controller = AsipController(image, intermediates=False)
    begin = tuple(path.position[0]), tuple(path.table_position[0])
    plant = StampedPlant(robot, *begin) if speed == "stamps" else None
    done = closed_loop.run(robot, path, controller, lambda _: None, plant=plant)
    law = run(robot, path, done.counts, speed)
    return Measured(
        int(done.ticks.cycles.max()),
        ripple(done.ticks.outputs, robot.T_s),
        closed_loop.tracking_error(robot, path, law.position_d, done),
        delay(robot.T_s, done.joints, law.velocity, law.acceleration_d),
        (margin(robot, 0, speed), margin(robot, 3, speed)),
        done.ticks.outputs,
    )


def delay(
    period: float,
    joints: NDArray[np.float64],
    velocity: NDArray[np.float64],
    acceleration: NDArray[np.float64],
) -> float:
    """By how much measured speeds of the legs are late [s]: least squares of true less measured
    speed on the desired acceleration, which no noise of the loop is in. period: of a tick [s];
    joints: exact ones; all (N, 5) or more columns than the legs'."""
    true = np.gradient(joints[:, :3], period, axis=0)
    late, of = true - velocity[:, :3], acceleration[:, :3]
    return float(np.sum(late * of) / np.sum(of * of))


def margin(robot: Robot, axis: int, speed: str) -> float:
    """Phase margin [degrees] of the law around the double integrator that computed forces leave of
    an axis, sampled and held, from the transfer functions. Stamps: at many counts a tick, where
    they give the mean speed of a tick as differences do."""
    period, k_p, k_v, k_i = robot.T_s, robot.K_P[axis], robot.K_V[axis], robot.K_I[axis]
    w = np.geomspace(1e-3, 1.0, 20_000) * math.pi / period
    z = np.exp(1j * w * period)
    law = k_p + k_i * period * z / (z - 1)
    if speed != "observer":
        law = law + k_v * (1 - 1 / z) / period
    else:
        # States x after the correction, of a position z^k: the law asks for -rest - taken x, and
        # the prediction less the step of the count is corrected. `rest` is the law without x.
        gain = gains(robot)[axis]
        correct = np.array([[gain.kept, 0, 0], [-gain.speed, 1, 0], [-gain.pull, 0, 1.0]])
        predict = np.array([[1, period, period**2 / 2], [0, 1, period], [0, 0, 1.0]])
        less, taken = np.array([period**2 / 2, period, 0.0]), np.array([0.0, k_v, gain.share])
        system = z[:, None, None] * np.eye(3) - correct @ (predict - np.outer(less, taken))
        step = (z - 1)[:, None] * np.array([1.0, 0, 0]) + law[:, None] * less
        states = np.linalg.solve(system, -(step @ correct.T)[:, :, None])[:, :, 0]
        law = law + states @ taken
    loop = law * period**2 / 2 * (z + 1) / (z - 1) ** 2
    crossing = np.flatnonzero((np.abs(loop[:-1]) > 1) & (np.abs(loop[1:]) <= 1))
    return float(np.degrees(np.angle(-loop[crossing])).min())


def compare(
    robot: Robot, full: bool, report: Callable[[str], None]
) -> tuple[str, dict[str, Measured]]:
    """What was run, and each program's figures, two at the same time. Raises ControllerFault."""
    path = path_of(robot, None if full else SHORT)
    what = "whole path" if full else f"first {SHORT * robot.T_s:g} s of the path"
    report(f"{what}, speeds from {', '.join(PROGRAMS)}")
    with processes(JOBS) as pool:
        work = {speed: pool.submit(measured, robot, path, speed) for speed in PROGRAMS}
        return what, {speed: one.result() for speed, one in work.items()}


def goals(what: str, found: dict[str, Measured]) -> list[Goal]:
    """Ripple and errors of every method, of those with differences of counts."""
    paper = found[SPEEDS[0]]
    rows = []
    for speed, each in found.items():
        if each is paper:
            continue
        share = float((each.ripple / paper.ripple).max())
        name = f"{what}, forces above {RIPPLE_ABOVE:g} Hz with {speed}, of those with differences"
        rows.append(at_most(name, share, RIPPLE, "1"))
        for part in ("tool", "leg", "table"):
            error = getattr(each.tracking, part) / getattr(paper.tracking, part)
            name = f"{what}, error of {part} with {speed}, of that with differences"
            rows.append(at_most(name, error, ERROR, "1"))
    return rows


def as_document(robot: Robot, found: dict[str, Measured]) -> dict[str, Any]:
    """What the page needs."""
    return {
        speed: {
            "cycles": each.cycles,
            "ripple": dict(zip(OUTPUTS, each.ripple.tolist(), strict=True)),
            "tracking": vars(each.tracking),
            "delay": each.delay,
            "margins": list(each.margins),
            "first": SHOWN.start * robot.T_s,
            "period": robot.T_s,
            "force": each.outputs[SHOWN, 0].astype(float).tolist(),
        }
        for speed, each in found.items()
    }


def table(document: dict[str, Any]) -> str:
    """Methods as Markdown."""
    rows = [
        ("cycles of a tick on `fast`", lambda m: f"{m['cycles']}"),
        ("F1 .. F3 above 1 kHz, rms, N", lambda m: _list(m, OUTPUTS[:3])),
        ("tau4, tau5 above 1 kHz, rms, N m", lambda m: _list(m, OUTPUTS[3:])),
        ("largest error of the tool, µm", lambda m: f"{1e6 * m['tracking']['tool']:.2f}"),
        ("largest error of a leg, µm", lambda m: f"{1e6 * m['tracking']['leg']:.2f}"),
        ("largest error of a table axis, µrad", lambda m: f"{1e6 * m['tracking']['table']:.1f}"),
        ("delay of a leg's speed, µs", lambda m: f"{1e6 * m['delay']:.0f}"),
        (
            "phase margin, leg, table, degrees",
            lambda m: ", ".join(f"{a:.0f}" for a in m["margins"]),
        ),
    ]
    methods = document["methods"]
    lines = ["| | " + " | ".join(methods) + " |", "| --- |" + " --- |" * len(methods)]
    lines += [f"| {name} | " + " | ".join(map(of, methods.values())) + " |" for name, of in rows]
    return "\n".join(lines) + "\n"


def _list(method: dict[str, Any], names: Sequence[str]) -> str:
    return ", ".join(f"{method['ripple'][name]:.2f}" for name in names)


def plot(document: dict[str, Any], file: Path) -> None:
    """The force of a leg with each method, over the ticks `SHOWN`."""
    import matplotlib  # here: the tests load it only to draw

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    matplotlib.rcParams["svg.hashsalt"] = "microtick"  # the same file from the same data
    methods = document["methods"]
    figure, rows = plt.subplots(
        len(methods), 1, figsize=(7.5, 2.0 * len(methods) + 0.6), sharex=True, sharey=True,
        layout="constrained", squeeze=False,
    )  # fmt: skip
    for (speed, each), plane in zip(methods.items(), rows[:, 0], strict=True):
        t = 1e3 * (each["first"] + each["period"] * np.arange(len(each["force"])))
        plane.plot(t, each["force"], lw=0.8)
        plane.set(ylabel="F1 [N]", title=f"speeds from {_NAMES[speed]}")
        plane.grid(alpha=0.3)
    rows[-1, 0].set_xlabel("time [ms]")
    with replaced(file) as new:
        figure.savefig(new, metadata={"Date": None})
    plt.close(figure)


_NAMES = {
    "difference": "differences of counts",
    "observer": "observers",
    "stamps": "time stamps",
}


def write_page(file: Path = BUILD / "speed.json") -> None:
    """docs/law.md and the plot. Raises OSError, MarksError."""
    document = json.loads(file.read_text(encoding="utf-8"))
    write_between_marks(PAGE, {"speeds": table(document)})
    plot(document, PLOT)


@command(COMMAND)
def main(argv: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = script_parser(__doc__, f"{COMMAND} --full", COMMAND)
    add_robot_option(parser, "drive")
    parser.add_argument("--results", type=Path, default=BUILD / "speed.json", help="file written")
    parser.add_argument("--full", action="store_true", help="the whole path")
    parser.add_argument("--docs", action="store_true", help="write the page from the results")
    options = parser.parse_args(argv)
    if options.docs:
        write_page(options.results)
        return 0
    console = Console()
    try:
        robot = Robot.load(options.robot)
        what, found = compare(robot, options.full, console.print)
    except (ParameterError, ControllerFault, BuildError) as error:
        console.print(f"error: {error}", style="red", markup=False, soft_wrap=True)
        return 1
    rows = as_json(goals(what, found))
    whole = options.full and options.robot.resolve() == ROBOT_TOML.resolve()
    write_goals(options.results, rows, whole=whole, methods=as_document(robot, found))
    console.print(terminal_table(rows))
    console.print(f"written: {options.results}")
    return int(bool(missed(rows)))


if __name__ == "__main__":
    sys.exit(main())
