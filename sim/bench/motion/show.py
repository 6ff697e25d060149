# SPDX-License-Identifier: Apache-2.0
"""Measure and show the motion front-end: `microtick motion`.

It redraws figures of two papers (docs/law.md), runs the drive and feed-forward study, runs the
front-end as RTL on a move of the S-curve paper and on a G64 program. It writes a table,
results.json and one page with plots. `make goals T=motion` measures the goals.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from asip_asm.command import command, command_parser
from asip_asm.files import write_text
from sim.bench.cnc import figures as drive_figures
from sim.bench.cnc.robot import PAYLOAD
from sim.bench.motion import show_page, show_path, show_rtl
from sim.bench.run.progress import TickProgress
from sim.motion.command import add_robot_option, interruptible
from sim.motion.lookahead import figures as lookahead_figures
from sim.motion.planner import figures as planner_figures
from sim.motion.planner.figures import Result, printed
from sim.robot.parameters import ParameterError, Robot
from sim.rtl.build import BuildError
from sim.rtl.motion_rtl import MotionError

ROOT = Path(__file__).resolve().parents[3]
# Their `figures(output)` gives results with the fields of planner.figures.Result, or a document
# that has an entry in READERS.
FIGURES = {"planner": planner_figures, "lookahead": lookahead_figures, "drive": drive_figures}
LOOKAHEAD_PATH = lookahead_figures.PATH_FILE
LOOKAHEAD_CORNER = lookahead_figures.CORNER_FILE
# Names of the papers on the page and in docs/law.md, by the beginning of a picture's name.
PAPERS = {"cnc": "CNC", "scurve": "S-curve"}
WIDTH = 160  # of a log
CAPTION = (
    "Every number that the papers print, or that follows from them, beside ours. “is”: stated in "
    "the paper's text; derived by hand from its formulas; theory; an estimate; a goal of our own; "
    "or what LinuxCNC does with the same program. docs/motion.md says why a number differs. Signs: "
    "L path length, tr acceleration time, tm time in which the acceleration grows, v'm speed "
    "reached, L_alpha and L_beta shortest lengths with full speed and with any acceleration, am "
    "greatest acceleration, J jerk, Sk and Tk way and time of phase k."
)


class ShowError(RuntimeError):
    """A figure function does not keep to the common form; the message says which and how."""


def rows_of(module: str, results: Iterable[Any] | dict[str, Any]) -> list[dict[str, Any]]:
    """Results as dictionaries with their paper. Raises ShowError naming what is missing."""
    rows = []
    if isinstance(results, dict):
        try:
            found: Iterable[Any] = READERS[module](results)
        except KeyError as error:
            raise ShowError(f"{module}.figures: its document has no {error}") from None
    else:
        found = results
    for result in found:
        row = asdict(result)
        missing = {"figure", "name", "unit", "published", "ours", "agrees", "file"} - set(row)
        if missing:
            raise ShowError(
                f"{module}.figures: a result has no {', '.join(sorted(missing))}; expected the "
                "fields of sim.motion.planner.figures.Result"
            )
        row["paper"] = PAPERS.get(row["file"].split("_")[0], "CNC" if module == "lookahead" else "")
        rows.append(row)
    return rows


def read_lookahead(document: dict[str, Any]) -> list[Result]:
    """Figures 4 to 6 of the CNC paper from the document of its figures. Raises KeyError."""
    found = []
    # As printed: "almost 5 s" and "about 1.5 s", with trapezoids; there is none with limited jerk.
    for key, text in (("without blending [s]", "5"), ("with blending [s]", "1.5")):
        times, name = document["figures 4 and 5"][key], key.removesuffix(" [s]")
        steps, smooth = times["steps of acceleration"], times["jerk limited"]
        theirs = lookahead_figures.LINUXCNC[key]
        beside = (f"<= {theirs}", "LinuxCNC", steps, bool(steps <= theirs))
        for what, *rest in (
            ("trapezoid", text, "stated", steps, printed(text, steps)),
            ("trapezoid, beside LinuxCNC", *beside),
            ("jerk-limited", "", "", smooth, True),
        ):
            published, source, our, agrees = rest
            label = f"{name}, {what}"
            found.append(Result("5", label, "s", published, source, our, agrees, LOOKAHEAD_PATH))
    for corner in document["figure 6"]:
        limit, ours = corner["P [mm]"], corner["apex of the set-points [mm]"]
        name, apex = f"G64 P{limit:g}: apex of the set-points", lookahead_figures.LINUXCNC_APEX_MM
        for label, text, source, most in (
            (name, f"<= {limit:g}", "stated", limit),
            (f"{name}, beside LinuxCNC", f"<= {apex[limit]}", "LinuxCNC", apex[limit]),
        ):
            agrees = ours <= most
            found.append(Result("6", label, "mm", text, source, ours, agrees, LOOKAHEAD_CORNER))
    return found


READERS = {"lookahead": read_lookahead}


def table_of(rows: list[dict[str, Any]]) -> Table:
    """Figure, quantity, the published value or our goal and which of the two it is, ours."""
    table = Table(
        title="Motion front-end: published figures and ours",
        box=box.SIMPLE_HEAD,
        padding=(0, 1),
        caption=CAPTION,
        caption_justify="left",
    )
    for title in ("paper, figure", "quantity", "published", "is", "ours", ""):
        right = title in ("published", "ours")
        table.add_column(title, justify="right" if right else "left", no_wrap=title != "quantity")
    for row, following in zip(rows, [*rows[1:], None], strict=True):
        table.add_row(
            f"{row['paper']} {row['figure']}".strip(),
            escape(f"{row['name']} [{row['unit']}]" if row["unit"] else row["name"]),
            row["published"],
            row.get("source", ""),
            f"{row['ours']:.6g}",
            ("agrees" if row["agrees"] else "[red]DIFFERS[/]") if row["published"] else "",
            end_section=following is None or following["file"] != row["file"],
        )
    return table


def _figure_modules(output: Path, console: Console) -> list[dict[str, Any]]:
    rows = []
    for name, module in FIGURES.items():
        found = rows_of(name, module.figures(output))
        console.print(f"      {name}: {len(found)} figures")
        rows += found
    return rows


def _robot(robot: Robot, output: Path, full: bool, console: Console) -> list[dict[str, Any]]:
    with TickProgress(console) as bars:
        done: dict[str, int] = {}

        def advance(name: str, ticks: int, total: int) -> None:
            if name not in done:
                bars.add(name, total)
            bars.advance(name, ticks - done.get(name, 0))
            done[name] = ticks

        found = drive_figures.robot_figures(output, full, advance, robot)
        return rows_of("drive", found)


def _rtl(output: Path, console: Console) -> list[dict[str, Any]]:
    moves = {}
    with TickProgress(console) as bars:
        for mode in show_rtl.MODES:
            moves[mode] = show_rtl.run(mode, bars.add(mode, show_rtl.ticks()))
    show_rtl.draw(moves, output)
    return rows_of("show_rtl", show_rtl.results(moves))


def _path(robot: Robot, output: Path, console: Console) -> list[dict[str, Any]]:
    console.print(f"      {show_path.FILE}: a G64 program on five axes, clock by clock")
    run = show_path.run(robot=robot)
    show_path.draw(run, output)
    return rows_of("show_path", show_path.results(run))


def run(arguments: argparse.Namespace, console: Console) -> None:
    """The whole job; writes below arguments.output."""
    robot = Robot.load(arguments.robot)
    out: Path = arguments.output
    out.mkdir(parents=True, exist_ok=True)
    console.print("[bold]1/3[/] figures of the papers: planner, look-ahead, drive")
    rows = _figure_modules(out, console)
    strokes = f"{len(drive_figures.STROKES)} strokes (--full: the whole path)"
    console.print(
        f"[bold]2/3[/] robot in closed loop on AGH at 2 m/min, payload +{PAYLOAD:g} kg, "
        f"{'the whole path' if arguments.full else strokes}"
    )
    if not arguments.no_robot:
        rows += _robot(robot, out, arguments.full, console)
    console.print(
        f"[bold]3/3[/] front-end as RTL, figure 12 of the S-curve paper at "
        f"{show_rtl.PULSES_PER_MM} pulses/mm (us of 100 clocks)"
    )
    if not arguments.no_rtl:
        rows += _rtl(out, console)
        rows += _path(robot, out, console)
    table = table_of(rows)
    console.print()
    console.print(table)
    differ = [row for row in rows if not row["agrees"]]
    console.print(f"{len(rows)} figures, {len(differ)} differ; docs/motion.md says why")
    document = {"full": arguments.full, "figures": rows}
    write_text(out / "results.json", json.dumps(document, indent=2) + "\n")
    show_page.write(out, [table])
    console.print(f"plots and page: {out / 'index.html'}")
    console.print(f"figures:        {out / 'results.json'}")


@command("python -m sim.bench.motion.show")
def main(argv: list[str] | None = None) -> int:
    """Command line; returns the exit code."""
    example = "example: python -m sim.bench.motion.show --no-rtl --output build/motion"
    parser = command_parser("python -m sim.bench.motion.show", __doc__, example)
    parser.add_argument(
        "--output", type=Path, default=ROOT / "build/motion", help="folder of everything written"
    )
    add_robot_option(parser, "motion")
    parser.add_argument(
        "--full", action="store_true", help="the robot on the whole AGH path, not on four strokes"
    )
    parser.add_argument("--no-rtl", action="store_true", help="without simulated RTL")
    parser.add_argument("--no-robot", action="store_true", help="without the robot")
    arguments = parser.parse_args(argv)
    console = Console()
    if not console.is_terminal:
        console = Console(width=WIDTH)
    try:
        run(arguments, console)
    except ParameterError as error:
        console.print(str(error), markup=False, highlight=False)
        return 1
    except (ShowError, BuildError, MotionError) as error:
        console.print(f"error: {error}", markup=False, highlight=False)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(interruptible(main))
