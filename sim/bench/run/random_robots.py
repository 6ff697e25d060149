# SPDX-License-Identifier: Apache-2.0
"""Random robots within the limits of the parameters, each in a short closed loop on every platform.

Robot number k of a seed is always the same. Every output of every tick is held against its derived
bound (sim/bench/run/bounds.py).
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console

from asip_asm.assemble import assemble
from asip_asm.command import command, command_parser
from asip_asm.diagnostics import AssemblyError
from sim.bench.run import nios
from sim.bench.run.results import compare, worst_of_bound
from sim.core import closed_loop
from sim.core.controller import AsipController, ControllerFault
from sim.report.marks import write_between_marks
from sim.robot.parameters import ParameterError, Robot
from sim.robot.records import SetPoints
from sim.rtl.build import BuildError
from sim.rtl.nios_image import ImageError

ROOT = Path(__file__).resolve().parents[3]
PROGRAMS = ROOT / "asip_asm/programs"
PAGE = ROOT / "docs/numerics.md"
OPTIMISED = "FPGA3 optimised"
ASIP = {"FPGA3 as printed": "tracking_as_printed", OPTIMISED: "tracking_optimised"}
PERIODS = (1e-4, 5e-5, 2e-4)  # s, of robots 0, 1, 2, 3, ...
TICKS = 200
SEED, COUNT = 1, 20
EXCEEDED = 3  # exit status


def draw(seed: int, number: int) -> Robot:
    """A valid robot; every third has the same control period. One in eight of some values is 0."""
    rng = np.random.default_rng((seed, number))
    while True:
        try:
            return Robot(**_values(rng, PERIODS[number % len(PERIODS)]))
        except ParameterError:
            continue


def _values(rng: np.random.Generator, period: float) -> dict[str, float]:
    def linear(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    def ratio(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    def maybe(value: float) -> float:
        return 0.0 if rng.integers(8) == 0 else value

    radius, period_counts = ratio(0.15, 1.2), int(rng.integers(20, 400))
    low = radius * linear(0.3, 1.5)
    return Robot.load().values() | {  # limits for planners stay
        "R": radius,
        "h": maybe(linear(0.0, 0.2)),
        "x_max": radius * linear(0.05, 0.7),
        "y_max": radius * linear(0.05, 0.7),
        "z_min": low,
        "z_max": (high := low + radius * linear(0.1, 0.8)),
        "z_start": (low + high) / 2,
        "rotation_min": -8 * math.pi,
        "rotation_max": 8 * math.pi,
        "m_s": maybe(ratio(0.1, 100.0)),
        "m_p": ratio(0.5, 100.0),
        "J_a": maybe(ratio(0.01, 20.0)),
        "l_c": maybe(linear(0.05, 1.2)),
        "mr_c": maybe(ratio(0.1, 30.0)),
        "J_44": ratio(0.05, 50.0),
        "J_55": ratio(0.05, 50.0),
        "m_4": maybe(ratio(1.0, 300.0)),
        "r_4": maybe(ratio(1e-3, 0.2)),
        "g": maybe(linear(1.0, 25.0)),
        "T_s": period,
        "f_legs": ratio(5.0, 90.0),
        "f_table": ratio(2.0, 40.0),
        "s_max_legs": maybe(ratio(1e-7, 1e-4)),
        "s_max_table": maybe(ratio(1e-5, 1e-3)),
        "xi_c": linear(1.0, 8.0),
        "T_c": period_counts * period,
        "e_c_legs": maybe(ratio(1e-7, 1e-5)),
        "e_c_table": maybe(ratio(1e-6, 2e-4)),
        "F_max": ratio(300.0, 3e4),
        "tau_max_4": ratio(30.0, 2e3),
        "tau_max_5": ratio(10.0, 1e3),
        "friction_legs": maybe(ratio(0.1, 30.0)),
        "friction_table": maybe(ratio(0.01, 2.0)),
        "encoder_legs": ratio(1e-7, 5e-6),
        "turn_table": float(rng.integers(1 << 14, 1 << 21)),
    }


def motion(robot: Robot, seed: int, number: int, ticks: int = TICKS) -> SetPoints:
    """Binary32 set-points: every axis swings from rest, 1/4 (1 - cos)^2, at a rate of its own.

    Around a point of the workspace; the amplitudes keep the accelerations at some m/s^2, rad/s^2.
    """
    rng = np.random.default_rng((seed, number, 1))
    low = np.array((-robot.x_max, -robot.y_max, robot.z_min, -3.0, -3.0))
    high = np.array((robot.x_max, robot.y_max, robot.z_max, 3.0, 3.0))
    start = low + (high - low) * rng.uniform(0.1, 0.9, 5)
    cycle = rng.uniform(0.4, 1.2, 5) * ticks * robot.T_s
    rate = 2.0 * np.pi / cycle
    amplitude = rng.uniform(0.5, 5.0, 5) * rng.choice((-1.0, 1.0), 5) / rate**2
    amplitude = np.clip(amplitude, 0.9 * (low - start), 0.9 * (high - start))
    angle = rate * (np.arange(ticks) * robot.T_s)[:, None]
    one, sin = 1.0 - np.cos(angle), np.sin(angle)
    place = start + amplitude * one**2 / 4
    speed = amplitude * rate * one * sin / 2
    change = amplitude * rate**2 * (sin**2 + one * np.cos(angle)) / 2
    parts = (place[:, :3], speed[:, :3], change[:, :3], place[:, 3:], speed[:, 3:], change[:, 3:])
    words = np.concatenate(parts, axis=1).astype(np.float32)
    return SetPoints.from_words(words.astype(np.float64))


@dataclass(frozen=True)
class Outcome:
    """One robot: platform -> largest error of an output as a fraction of its bound."""

    number: int
    robot: Robot
    fractions: dict[str, float]

    @property
    def kept(self) -> bool:
        """Whether every bound holds; an error that is no number does not."""
        return all(value <= 1.0 for value in self.fractions.values())


def examine(seed: int, number: int, ticks: int = TICKS) -> Outcome:
    """Closed loop of one robot on each platform. Raises ControllerFault, BuildError."""
    robot = draw(seed, number)
    path = motion(robot, seed, number, ticks)
    fractions = {}
    for name, program in ASIP.items():
        image = assemble(PROGRAMS / f"{program}.s", configuration="fast", defines=robot.values())
        fractions[name] = _worst(robot, path, AsipController(image), name == OPTIMISED)
    for platform in nios.SAMPLES:
        controller = nios.NiosController(platform, robot)
        fractions[platform.upper()] = _worst(robot, path, controller, False)
    return Outcome(number, robot, fractions)


def _worst(
    robot: Robot,
    path: SetPoints,
    controller: AsipController | nios.NiosController,
    optimised: bool,
) -> float:
    recording = closed_loop.run(robot, path, controller, lambda ticks: None)
    controller.core.close()
    comparison = compare(robot, path, recording.counts)
    found = worst_of_bound(robot, comparison, recording.ticks, optimised)
    return float(np.max(list(found.values())))  # NaN stays NaN


def replay(seed: int, number: int) -> str:
    """Command that repeats one robot."""
    return f"python -m sim.bench.run.random_robots --seed {seed} --first {number} --count 1"


def rows(outcomes: Iterable[Outcome]) -> list[str]:
    """Lines of Markdown: platforms, robots whose bounds hold, worst fraction per control period."""
    outcomes = list(outcomes)
    periods = sorted({outcome.robot.T_s for outcome in outcomes})
    head = ["platform", "bounds hold", *(f"worst at {period * 1e6:g} us" for period in periods)]
    lines = [head, ["---"] + ["--:"] * (len(head) - 1)]
    for platform in outcomes[0].fractions:
        held = sum(outcome.fractions[platform] <= 1.0 for outcome in outcomes)
        worst = [
            max(o.fractions[platform] for o in outcomes if o.robot.T_s == period)
            for period in periods
        ]
        lines.append(
            [platform, f"{held} of {len(outcomes)} robots", *(f"{value:.3f}" for value in worst)]
        )
    return ["| " + " | ".join(line) + " |" for line in lines]


@command("python -m sim.bench.run.random_robots")
def main(argv: list[str] | None = None) -> int:
    """Command line; returns the exit status."""
    status = "exit status: 0 every bound holds, 1 a run has failed, 3 a bound is exceeded"
    parser = command_parser("python -m sim.bench.run.random_robots", __doc__, status)
    parser.add_argument("--seed", type=int, default=SEED, help="(%(default)s)")
    parser.add_argument("--first", type=int, default=0, metavar="K", help="first robot (0)")
    parser.add_argument("--count", type=int, default=COUNT, help="robots (%(default)s)")
    parser.add_argument("--docs", action="store_true", help=f"write the table to {PAGE.name}")
    arguments = parser.parse_args(argv)
    if min(arguments.seed, arguments.first) < 0 or arguments.count < 1:
        parser.error("--seed and --first must be at least 0, --count at least 1")
    console = Console(highlight=False, soft_wrap=True)
    outcomes = []
    for number in range(arguments.first, arguments.first + arguments.count):
        try:
            outcome = examine(arguments.seed, number)
        except (BuildError, ControllerFault, AssemblyError, ImageError) as error:
            console.print(f"error: robot {number}: {error}", markup=False)
            return 1
        shown = ", ".join(f"{name} {value:.3f}" for name, value in outcome.fractions.items())
        text = "bounds hold" if outcome.kept else f"BEYOND; {replay(arguments.seed, number)}"
        console.print(f"robot {number}, T_s {outcome.robot.T_s * 1e6:g} us: {shown}: {text}")
        outcomes.append(outcome)
    table = "\n".join(rows(outcomes))
    console.print(table)
    if arguments.docs:
        write_between_marks(PAGE, {"random robots": table + "\n"})
    return 0 if all(outcome.kept for outcome in outcomes) else EXCEEDED


if __name__ == "__main__":
    sys.exit(main())
