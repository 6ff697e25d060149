# SPDX-License-Identifier: Apache-2.0
"""What `microtick dual` measures: cycles, time left, hand-over, set-points against the plan."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from asip_asm.files import write_text
from sim.bench.dual.loop import Loop
from sim.bench.run.results import CLOCK_MHZ
from sim.core.closed_loop import SETTLED_S, tracking_error
from sim.core.controller import ControllerFault
from sim.motion.geometry.override import AS_PROGRAMMED
from sim.report.marks import between_marks
from sim.report.provenance import commit
from sim.robot.parameters import ParameterError, Robot
from sim.robot.records import SET_POINTS, SetPoints
from sim.rtl.build import ROOT
from sim.rtl.dual_rtl import TOP
from sim.rtl.figures import rtl_mark
from sim.rtl.gen.dual_regmap import REGMAP

LONGEST_PERIOD = REGMAP.registers["PERIOD"].fields["value"].mask  # clocks
REGISTERS = (
    *("TRAJECTORY_MIN", "TRAJECTORY_MAX", "TRACKING_MIN", "TRACKING_MAX", "COMMAND_MAX"),
    *("COPY_MAX", "USED_MAX", "LEFT_MIN", "PERIODS", "UNDERRUNS", "OVERRUNS"),
)
PAGE = ROOT / "docs/two_processors.md"
DATA = ROOT / "docs/data/two_processors.json"
TRACKING = (("leg", 1e6, "um"), ("tool", 1e6, "um"), ("table", 1e6, "urad"))


class PageError(ValueError):
    """The results cannot be put on the page; says why and what to do."""


def nominal_clocks(robot: Robot) -> int:
    """Clocks of a control period. Raises ParameterError if the period timer cannot count them."""
    clocks = round(robot.T_s * CLOCK_MHZ * 1e6)
    if clocks > LONGEST_PERIOD:
        raise ParameterError(
            f"T_s = {robot.T_s} s: {clocks} clocks, the period timer counts {LONGEST_PERIOD}"
        )
    return clocks


def set_point_errors(path: SetPoints, made: NDArray[np.float32]) -> dict[str, float]:
    """Largest difference of each word to the planned path, (N, 15) against N ticks."""
    difference = np.abs(made.astype(np.float64) - path.words()).max(axis=0)
    return dict(zip(SET_POINTS, difference.tolist(), strict=True))


def spread(values: NDArray[np.integer]) -> dict[str, float]:
    """Least, median and most of at least one value."""
    return {
        "min": int(values.min()),
        "median": float(np.median(values)),
        "max": int(values.max()),
    }


def periods(loop: Loop, nominal: int) -> dict[str, dict[str, float]]:
    """Spread of the parts of a period over the ticks done, in clocks and cycles.

    Clocks count from the first one of a period. The work of a period does not depend on its length,
    what is longer is idle; so what is left is counted of `nominal` clocks, for each core from the
    clock in which its words have been handed over. A set-point waits from then to the commands made
    of it.
    """
    rows = loop.ticks["period"][: loop.done]
    made = np.append(loop.start["set_point_clock"], rows["set_point_clock"][:-1]).astype(np.int64)
    parts = {
        "trajectory_cycles": rows["cycles"][:, 0],
        "tracking_cycles": rows["cycles"][:, 1],
        "set_point_clock": rows["set_point_clock"],
        "command_clock": rows["command_clock"],
        "used": rows["used"],
        "left_trajectory": nominal - rows["set_point_clock"].astype(np.int64),
        "left_tracking": nominal - rows["command_clock"].astype(np.int64),
        "left": nominal - rows["used"].astype(np.int64),
        "set_point_to_command": nominal - made + rows["command_clock"],
    }
    return {name: spread(values) for name, values in parts.items()}


def checked_registers(loop: Loop) -> dict[str, int]:
    """The system's statistics. Raises ControllerFault if they are not what the run has seen."""
    clocks = {name.lower(): loop.controller.system.read(name) for name in REGISTERS}
    rows = np.append(loop.ticks["period"][: loop.done], loop.start)
    tracked = rows[rows["updates"] > 0]
    seen = {
        "periods": len(rows),
        "trajectory_min": rows["cycles"][:, 0].min(),
        "trajectory_max": rows["cycles"][:, 0].max(),
        "tracking_min": tracked["cycles"][:, 1].min(),
        "tracking_max": tracked["cycles"][:, 1].max(),
        "command_max": tracked["command_clock"].max(),
        "used_max": rows["used"].max(),
    }
    for name, value in seen.items():
        if clocks[name] != value:
            raise ControllerFault(
                f"register {name.upper()} says {clocks[name]}, the run has seen {value}"
            )
    return clocks


def results(
    robot: Robot,
    path: SetPoints,
    desired: NDArray[np.float64],
    loop: Loop,
    repeated: Sequence[range],
) -> dict[str, Any]:
    """The content of build/dual/results.json after the ticks done, at least one.

    desired: planned joints, (N, 5). Tracking is checked after 50 ms, before that it is None. Raises
    ControllerFault if the system's registers contradict the run.
    """
    controller, n, nominal = loop.controller, loop.done, nominal_clocks(robot)
    flags = controller.system.flags()
    recording = loop.recording()
    tracked = SetPoints.from_words(path.words()[:n])
    settled = n > round(SETTLED_S / robot.T_s)
    return {
        "commit": commit(),
        "rtl": rtl_mark(TOP),
        "complete": n == len(path),
        "ticks": len(path),
        "ticks_done": n,
        "clock_mhz": CLOCK_MHZ,
        "period_clocks_simulated": controller.system.read("PERIOD"),
        "period_clocks_nominal": nominal,
        "configuration": {n: image.configuration for n, image in controller.images.items()},
        "clocks": checked_registers(loop),
        "periods": periods(loop, nominal),
        "flags": flags,
        "repeated": {
            "period_clocks": nominal,
            "stretches": [[stretch.start, stretch.stop] for stretch in repeated],
            "ticks": sum(map(len, repeated)),
            "same_bits": True,  # else the run has stopped
        },
        "set_point_error": set_point_errors(tracked, loop.ticks["set_point"][:n]),
        "tracking": vars(tracking_error(robot, tracked, desired[:n], recording))
        if settled
        else None,
    }


def write(file: Path, data: dict[str, Any]) -> None:
    """Write the results; a reader sees the old ones or the new ones, whole."""
    file.parent.mkdir(parents=True, exist_ok=True)
    write_text(file, json.dumps(data, indent=2) + "\n")


# ---------------------------------------------------------------------- tables

PARTS = {
    "trajectory_cycles": "trajectory core, cycles of a run",
    "tracking_cycles": "tracking core, cycles of a run",
    "set_point_clock": "period start to set-point in the buffer",
    "command_clock": "period start to commands",
    "used": "all work",
    "left_trajectory": "left of {period} us, trajectory core",
    "left_tracking": "left of {period} us, tracking core",
    "left": "left of {period} us, both",
    "set_point_to_command": "set-point in the buffer to its commands, {period} us periods",
}


SPREAD = ("least", "median", "most", "median [us]")


def _timing(data: dict[str, Any]) -> Iterator[tuple[str, ...]]:
    """Part, least, median, most [clocks], median [us]."""
    period = f"{data['period_clocks_nominal'] / data['clock_mhz']:g}"
    for name, text in PARTS.items():
        part = data["periods"][name]
        median = part["median"]
        yield (
            text.format(period=period),
            str(part["min"]),
            f"{median:g}",
            str(part["max"]),
            f"{median / data['clock_mhz']:.2f}",
        )


def _tracking(data: dict[str, Any]) -> Iterator[tuple[str, ...]]:
    """Deviation, two processors, one processor; 'not run' where a run has ended before."""
    for name, scale, unit in TRACKING:
        both = (data.get(key) for key in ("tracking", "tracking_single_core"))
        yield (
            f"{name} [{unit}]",
            *(f"{errors[name] * scale:.4f}" if errors else "not run" for errors in both),
        )


def _events(data: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """What happened, how often."""
    clocks, repeated = data["clocks"], data["repeated"]
    yield "ticks tracked", f"{data['ticks_done']} of {data['ticks']}"
    yield "periods with work left from the one before (OVERRUNS)", str(clocks["overruns"])
    yield "periods without a new set-point (UNDERRUNS)", str(clocks["underruns"])
    yield "clocks of a period simulated", str(data["period_clocks_simulated"])
    if repeated["ticks"]:
        yield (
            f"ticks repeated with {repeated['period_clocks']} clocks, same bits",
            f"{repeated['ticks']} in {len(repeated['stretches'])} stretches",
        )
    if data.get("one_core"):
        yield (
            "commands that one core answers to the set-point of the period before, same bits",
            f"{data['one_core']['ticks_equal']} of {data['one_core']['ticks']}",
        )


def tables(data: dict[str, Any]) -> Iterator[Table]:
    """The figures of results.json as tables."""
    yield _table("two processors", ("", ""), _events(data))
    yield _table(f"clocks at {data['clock_mhz']} MHz", ("part of a period", *SPREAD), _timing(data))
    title = "set-points of the core against the plan in double precision"
    yield _table(title, ("word", "largest difference", "unit"), _handed_over(data))
    if data["tracking"]:
        title = "largest tracking error after 50 ms"
        yield _table(title, ("", "two processors", "one processor"), _tracking(data), names=False)


def _table(
    title: str, heads: Sequence[str], rows: Iterable[Sequence[str]], names: bool = True
) -> Table:
    """names: the first column is to the left."""
    table = Table(title=title)
    for place, head in enumerate(heads):
        table.add_column(head, justify="left" if names and not place else "right")
    for row in rows:
        table.add_row(*row)
    return table


def _handed_over(data: dict[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Word, largest difference, unit."""
    for name, value in data["set_point_error"].items():
        angle = name in ("alpha", "gamma") or "_" in name
        order = 0 if name in ("x", "y", "z", "alpha", "gamma") else 2 if name[0] in "ae" else 1
        yield name, f"{value:.3g}", ("rad" if angle else "m") + ("", "/s", "/s^2")[order]


# ---------------------------------------------------------------------- page


def block(data: dict[str, Any]) -> str:
    """Markdown of the figures for docs/two_processors.md."""

    def rows(head: Sequence[str], body: Iterator[tuple[str, ...]]) -> list[str]:
        lines = [head, ["---"] + ["--:"] * (len(head) - 1), *body]
        return ["| " + " | ".join(line) + " |" for line in lines] + [""]

    cores = ", ".join(f"{name} core `{kind}`" for name, kind in data["configuration"].items())
    lines = [
        "",
        f"Path A-G-H, {cores}, {data['clock_mhz']} MHz.",
        "",
        *rows(("over the whole path", "ticks"), _events(data)),
        *rows(("clocks", *SPREAD), _timing(data)),
        *rows(
            ("largest tracking error after 50 ms", "two processors", "one processor"),
            _tracking(data),
        ),
    ]
    return "\n".join(lines)


def replaced(text: str, data: dict[str, Any]) -> str:
    """The page with the figures of `data` between its marks. Raises MarksError without marks."""
    return between_marks(text, {"whole path": block(data)}, PAGE)


def publish(results_file: Path, page: Path = PAGE, kept: Path = DATA) -> None:
    """Put the figures of a complete run of A-G-H on the page and keep them next to it.

    Raises PageError for results of another path or of a part.
    """
    try:
        data = json.loads(results_file.read_text(encoding="utf-8"))
    except (FileNotFoundError, json.JSONDecodeError) as error:
        raise PageError(f"{results_file}: error: {error}; run `microtick dual` first") from error
    as_programmed = data.get("feed_override_percent", AS_PROGRAMMED) == AS_PROGRAMMED
    whole = data["complete"] and data["whole_path"] and as_programmed
    if not whole or data["path"] != "agh.ngc":
        raise PageError(
            f"{results_file}: error: {data['ticks_done']} of {data['ticks']} ticks of "
            f"{data['path']}; the page shows the whole path A-G-H: run `microtick dual`"
        )
    text = replaced(page.read_text(encoding="utf-8"), data)
    write(kept, data)
    write_text(page, text)
