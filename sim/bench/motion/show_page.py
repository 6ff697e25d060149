# SPDX-License-Identifier: Apache-2.0
"""The page of `microtick motion`: pictures with what they show, then the tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.table import Table

from sim.bench.cnc import figures as drive_figures
from sim.bench.motion import show_path, show_rtl
from sim.motion.lookahead import figures as lookahead_figures
from sim.report import pictures, provenance
from sim.report.document import Page

TITLE = "Microtick: from a program to motion"
LEAD = (
    "A machine tool reads a program of lines and arcs (G-code). Before anything moves, someone "
    "must decide how fast the tool goes at every moment, so that no drive is asked for more than "
    "it can do, and then make the drives follow. This page shows the project's parts that do "
    "this, on the examples of two published papers and on our own robot: first in pictures, then "
    "in numbers. Drag a rectangle in a picture to zoom, double-click to see everything again."
)
SOURCES = (
    "The CNC paper: M. Paprocki et al., Mechanik 4/2018, doi:10.17814/mechanik.2018.4.46. The "
    "S-curve paper: Journal of East China University of Science and Technology, "
    "doi:10.14135/j.cnki.1006-3080.20200824003. LinuxCNC is a free machine controller that many "
    "use; it ran the same programs."
)


@dataclass(frozen=True)
class Part:
    """A section of pictures: heading, what its subject is, caption by file."""

    heading: str
    sentence: str
    pictures: dict[str, str]


PARTS = (
    Part(
        "Many short lines: look ahead",
        "Programs often draw curves as hundreds of short lines. A controller that stops at each "
        "end takes forever; one that looks ahead keeps its speed and rounds each corner a little.",
        {
            lookahead_figures.PATH_FILE: "A circle of 84 lines. Left: the path. Right: speed of "
            "the tool; G61 stops exactly at every corner, G64 P0.025 may leave the path by 25 µm "
            "and runs through.",
            lookahead_figures.CORNER_FILE: "The same corner for several tolerances P in mm, one "
            "dot every 100 µs. The larger P, the rounder and faster.",
        },
    ),
    Part(
        "One move: how fast at which moment",
        "A drive cannot jump to its speed, and its acceleration should not jump either, or the "
        "machine shakes. So speed rises along an S: the acceleration itself grows and falls over "
        "a time tm. The acceleration time tr is set beforehand; what a short move does not reach "
        "is left out, which gives seven kinds of moves.",
        {
            "scurve_fig3.svg": "Speed over time for path lengths L of 800, 300 and 100 mm and "
            "three times tm (S-curve paper, figure 3); dashed: the fastest move within the same "
            "limits.",
            "scurve_fig12.svg": "One move of 100 mm in all its seven phases: way, speed, phase, "
            "and the pulses that a stepping drive gets (figure 12).",
            "scurve_fig15.svg": "Three more moves, which the paper ran on hardware (figure 15).",
        },
    ),
    Part(
        "In hardware: pulses for the drives",
        "The hardware description (RTL) of the motion front-end, simulated clock by clock at 100 "
        "MHz, makes pulses of the planned moves; each pulse is one step of a drive.",
        {
            show_rtl.FILE: "The move above from the edges of the step line. Time-exact: phases "
            "end at their time. Pulse-counted: phases end after their number of pulses, as in "
            "the S-curve paper; it runs ahead of the plan, by the pulses shown below.",
            show_path.FILE: "A whole program on five axes. Left: the tool's way as planned. "
            "Right: a corner of it in single steps. Below: how far the counted steps are from the "
            "planned joints; one step is the bound.",
        },
    ),
    Part(
        "The drive that follows",
        "A position loop lags behind: the faster, the more. Telling the drive the speed "
        "beforehand (velocity feed-forward), and then the acceleration too, takes most of the lag "
        "away.",
        {
            drive_figures.FIG_10: "The move of the study: there and back at 15 m/min, once with a "
            "jump of the acceleration (trapezoid), once with an S-curve.",
            drive_figures.FIG_11: "How far the drive is behind (CNC paper, figure 11): a) "
            "without, b) with velocity, c) with velocity and acceleration feed-forward; below, "
            "the jerk.",
            drive_figures.SERVO_FILE: "Above: a sudden load of 1.8 N·m pushes the drive away and "
            "it comes back, for three readings of the paper's bandwidth. Below: moves of a single "
            "step of the encoder.",
            drive_figures.ROBOT_FILE: "Errors of the robot's three legs on a line, with friction "
            "and a wrong payload: the three kinds of drive above, and the computed-torque law of "
            "this project.",
        },
    ),
)


def write(out: Path, tables: Sequence[Table]) -> None:
    """Write out/index.html from the figures that are in `out` and the tables."""
    page = Page(TITLE, LEAD)
    page.facts({"date": provenance.now(), "commit": provenance.commit(), "papers": SOURCES})
    for part in PARTS:
        drawn = {file: made for file in part.pictures if (made := pictures.load(out / file))}
        if drawn:
            page.section(part.heading, part.sentence)
        for file, made in drawn.items():
            page.figure(made, part.pictures[file], least_width=pictures.least_width(made))
    page.section("Numbers", "What was to be reached, and what this run has measured.")
    for table in tables:
        page.table(table)
    page.write(out / "index.html")
