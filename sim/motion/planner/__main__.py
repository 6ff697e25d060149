# SPDX-License-Identifier: Apache-2.0
"""Command line: plan one move, print its phases, write plot and JSON, compare with the core."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from asip_asm.command import command, command_parser
from asip_asm.files import open_output, replaced
from sim.motion.command import failed, interruptible, output
from sim.motion.planner.optimal import Limits, time_optimal
from sim.motion.planner.phases import Phase, Profile
from sim.motion.planner.ramp_time import PHASE_NAMES, RampTimePlan, exact, ramp_time_plan
from sim.motion.planner.scurve import FloatArray, Samples, SCurveError

EPILOG = """examples:
  python -m sim.motion.planner --v0 100 --vm 600 --tr 0.6 --tm 0.15 --length 800
  python -m sim.motion.planner --v0 100 --vm 600 --tr 0.6 --tm 0.15 --length 120 --optimal \\
      --json build/motion/move.json --plot build/motion/move.svg
  python -m sim.motion.planner --v0 0 --vm 0.5 --tr 0.1 --tm 0.02 --length 0.3 --core fast
  python -m sim.motion.planner --figures build/motion

Lengths may be in any unit; speeds are in the same unit per second. Numbers are taken as written:
0.15 is 3/20. exit status: 0 done, 1 a parameter is refused or a file cannot be written,
2 wrong command line
"""
PLOT_POINTS = 2001
MOVE = ("v0", "vm", "tr", "tm", "length")
# Magnitudes of numbers other than 0; those of the processor's programs have the same bound.
LEAST, GREATEST = Fraction(1, 10**30), Fraction(10**30)


def rows(phases: Sequence[Phase[Any]], names: Sequence[str]) -> list[dict[str, Any]]:
    """Phases as shown, rounded to doubles once: times [s], lengths [unit] and their derivatives."""
    return [
        {
            "number": number,
            "name": name,
            "duration": float(phase.duration),
            "displacement": float(phase.displacement),
            "start_speed": float(phase.start.speed),
            "end_speed": float(phase.end.speed),
            "start_acceleration": float(phase.start.acceleration),
            "end_acceleration": float(phase.end.acceleration),
            "jerk": float(phase.jerk),
        }
        for number, (phase, name) in enumerate(zip(phases, names, strict=True), 1)
    ]


def optimal_names(profile: Profile) -> list[str]:
    """What each phase of a time-optimal profile does."""
    names = []
    for phase in profile.phases:
        middle = phase.start.after(phase.duration / 2, phase.jerk)
        rest = phase.jerk == 0.0 and abs(middle.acceleration) < 1e-12 * max(
            abs(p.end.acceleration) for p in profile.phases
        )
        what = {1: "jerk up", 0: "constant acceleration", -1: "jerk down"}
        sign = (phase.jerk > 0) - (phase.jerk < 0)
        names.append("cruise" if rest else what[sign])
    return names


def default_limits(plan: RampTimePlan) -> tuple[float | None, float | None]:
    """Acceleration and jerk with which tr and tm reach vm; None where there is none."""
    rise = plan.vm - plan.v0
    if rise == 0:
        return None, None
    acceleration = rise / (plan.tr - plan.tm)
    return float(acceleration), float(acceleration / plan.tm) if plan.tm else None


def _arguments() -> argparse.ArgumentParser:
    parser = command_parser(
        "python -m sim.motion.planner",
        "Plan one S-curve move: with set acceleration times as in the S-curve paper, "
        "or in the shortest time that limits of acceleration and jerk allow.",
        EPILOG,
    )
    for name, text in (
        ("v0", "start speed, and end speed unless --ve is given"),
        ("vm", "greatest speed"),
        ("tr", "total acceleration time [s]"),
        ("tm", "jerk time [s], at most tr/2"),
        ("length", "length of the move"),
    ):
        parser.add_argument(f"--{name}", metavar="NUMBER", help=text)
    parser.add_argument("--optimal", action="store_true", help="time-optimal instead of tr, tm")
    for name, text in (
        ("ve", "end speed"),
        ("acceleration", "limit; default: the one with which tr and tm reach vm"),
        ("jerk", "limit; default likewise"),
    ):
        parser.add_argument(f"--{name}", metavar="NUMBER", help=f"with --optimal: {text}")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write plan and phases")
    parser.add_argument(
        "--plot", type=Path, metavar="FILE", help="draw position, speed, acceleration (.png, .svg)"
    )
    parser.add_argument(
        "--core",
        choices=("fast", "small"),
        help="plan the move on the processor too: outputs, errors and clock cycles",
    )
    parser.add_argument(
        "--figures", type=Path, metavar="FOLDER", help="draw the paper's figures, with its numbers"
    )
    return parser


def bounded(name: str, text: str) -> Fraction:
    """As `exact`, 0 or of a magnitude for which every figure of a plan is a finite double."""
    number = exact(name, text)
    if number and not LEAST <= abs(number) <= GREATEST:
        raise SCurveError(
            f"S-curve parameter {name} = {text!r} is outside its limit: 0, or a magnitude of "
            f"{float(LEAST):g} to {float(GREATEST):g}; use another unit"
        )
    return number


def _plan(arguments: argparse.Namespace) -> tuple[RampTimePlan, Profile | None, Limits | None]:
    plan = ramp_time_plan(*(bounded(name, getattr(arguments, name)) for name in MOVE))
    if not arguments.optimal:
        return plan, None, None
    values = dict(zip(("acceleration", "jerk"), default_limits(plan), strict=True))
    found: dict[str, float] = {}
    for name, own in values.items():
        given = getattr(arguments, name)
        value = own if given is None else float(bounded(name, given))
        if value is None:
            raise SCurveError(
                f"the move has no {name} of its own (v0 = vm or tm = 0): give --{name}"
            )
        found[name] = value
    limits = Limits(float(plan.vm), found["acceleration"], found["jerk"])
    ve = arguments.v0 if arguments.ve is None else arguments.ve
    profile = time_optimal(float(plan.length), float(plan.v0), float(bounded("ve", ve)), limits)
    return plan, profile, limits


UNITS = ("speed [u/s]", "acceleration [u/s2]", "jerk [u/s3]")  # u: unit of the options


def _table(title: str, shown: Sequence[dict[str, Any]]) -> Table:
    table = Table(title=title)
    for name in (*("", "phase", "time [s]", "length [u]"), *UNITS):
        table.add_column(name, justify="left" if name == "phase" else "right", no_wrap=True)
    for row in shown:
        table.add_row(
            str(row["number"]),
            row["name"],
            *(f"{row[name]:.6g}" for name in ("duration", "displacement")),
            *(
                f"{row['start_' + n]:.6g} .. {row['end_' + n]:.6g}"
                for n in ("speed", "acceleration")
            ),
            f"{row['jerk']:.6g}",
        )
    return table


def _json(
    plan: RampTimePlan,
    profile: Profile | None,
    limits: Limits | None,
    shown: Sequence[dict[str, Any]],
) -> dict[str, Any]:
    parameters = {name: getattr(plan, name) for name in MOVE}
    forms = plan.forms
    document: dict[str, Any] = {
        "parameters": {name: float(value) for name, value in parameters.items()},
        "parameters_exact": {name: str(value) for name, value in parameters.items()},
        "phases": shown,
    }
    if profile is None:
        names = (
            *("total_time", "peak_speed", "peak_acceleration", "jerk"),
            *("cruise_critical_length", "acceleration_critical_length"),
        )
        figures = {name: getattr(forms, name) for name in names}
        document |= {"mode": "ramp time", "segments": forms.kind.value, "class": forms.kind.name}
        document |= {name: float(value) for name, value in figures.items()}
        document["exact"] = {name: str(value) for name, value in figures.items()}
    else:
        _, peak, acceleration, jerk = profile.extremes()
        document |= {
            "mode": "optimal",
            "limits": vars(limits),
            "end_speed": profile.end.speed,
            "total_time": profile.total_time,
            "peak_speed": peak,
            "peak_acceleration": acceleration,
            "jerk": jerk,
            "ramp_time_mode_time": float(plan.total_time),
        }
    return document


def _plot(file: Path, times: FloatArray, samples: Samples, title: str) -> None:
    from sim.report.pictures import pyplot

    plt = pyplot("planner")
    figure, axes = plt.subplots(3, 1, figsize=(8, 7), sharex=True)
    for axis, name in zip(axes, ("position", "velocity", "acceleration"), strict=True):
        axis.plot(times, getattr(samples, name))
        axis.set_ylabel(name)
        axis.grid(alpha=0.3)
    axes[0].set_title(title)
    axes[2].set_xlabel("time [s]")
    figure.tight_layout()
    file.parent.mkdir(parents=True, exist_ok=True)
    with replaced(file) as new:
        figure.savefig(new)
    plt.close(figure)


def _core_table(plan: RampTimePlan, configuration: str) -> tuple[Table, int]:
    # Verilator is needed here only.
    from sim.motion.planner.core import ERRORS, PARAMETERS, planner_program

    inputs = {
        name: np.array([float(getattr(plan, field))], dtype=np.float32)
        for name, field in zip(PARAMETERS, MOVE, strict=True)
    }
    run = planner_program("planner_scurve", configuration).batch(inputs)
    forms = ramp_time_plan(*(float(value[0]) for value in inputs.values())).forms
    want = {
        "class": forms.kind.value,
        "t1": forms.durations[0],
        "t2": forms.durations[1],
        "t4": forms.durations[3],
        **{f"s{k + 1}": forms.displacements[k] for k in range(4)},
        "vp": forms.peak_speed,
        "am": forms.peak_acceleration,
        "J": forms.jerk,
    }
    table = Table(title=f"on the core ({configuration})")
    for name in ("output", "core", "exact for the same binary32 inputs", "error"):
        table.add_column(name, justify="left" if name == "output" else "right", no_wrap=True)
    error = int(run.values["error"][0])
    table.add_row("error", str(error), ERRORS[error], "")
    for name, value in want.items():
        got = float(run.values[name][0])
        table.add_row(name, f"{got:.9g}", f"{float(value):.9g}", f"{got - float(value):.2g}")
    assert run.cycles is not None  # the RTL counts
    return table, int(run.cycles[0])


@command("python -m sim.motion.planner")
def main(argv: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parser = _arguments()
    arguments = parser.parse_args(argv)
    console = output()
    given = [name for name in MOVE if getattr(arguments, name) is not None]
    if not given and arguments.figures is None:
        parser.error("nothing to do: give the move (--v0 --vm --tr --tm --length) or --figures")
    missing = [f"--{name}" for name in MOVE if name not in given]
    if given and missing:
        parser.error(f"the move needs {' '.join(missing)} too")
    if not arguments.optimal:
        for name in ("ve", "acceleration", "jerk"):
            if getattr(arguments, name) is not None:
                parser.error(f"--{name} needs --optimal")
    try:
        if arguments.figures is not None:
            from sim.motion.planner.figures import figures, results_table

            console.print(results_table(figures(arguments.figures)))
        if given:
            _show(arguments, console)
    except ValueError as error:
        return failed(parser.prog, error)
    return 0


def _show(arguments: argparse.Namespace, console: Console) -> None:
    plan, profile, limits = _plan(arguments)
    if profile is None:
        shown = rows(plan.phases, PHASE_NAMES)
        total = float(plan.total_time)
        title = f"{plan.forms.kind.value}-segment profile"
    else:
        shown = rows(profile.phases, optimal_names(profile))
        total = profile.total_time
        title = "time-optimal profile"
    console.print(_table(title, shown))
    console.print(
        f"total time {total:.9g} s, length {float(plan.length):.9g} u "
        "(u: unit of length of the options)"
    )
    if profile is not None:
        console.print(f"with set times as in the S-curve paper: {float(plan.total_time):.9g} s")
    if arguments.json is not None:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        document = _json(plan, profile, limits, shown)
        with open_output(arguments.json) as file:
            file.write(json.dumps(document, indent=2) + "\n")
    if arguments.plot is not None:
        if not arguments.plot.suffix:
            raise ValueError(f"--plot {arguments.plot} has no suffix; expected .png or .svg")
        times = np.linspace(0.0, total, PLOT_POINTS)
        _plot(arguments.plot, times, (profile or plan).sample(times), title)
    if arguments.core is not None:
        table, cycles = _core_table(plan, arguments.core)
        console.print(table)
        console.print(f"{cycles} clock cycles")


if __name__ == "__main__":
    sys.exit(interruptible(main))
