# SPDX-License-Identifier: Apache-2.0
"""Figures 4 to 6 of the CNC paper: short lines with and without blending, a corner.

The path of figures 4 and 5 is not printed; the one here has its feed and its times: 84 chords of a
circle of 362 mm circumference, F15000, 4.8 m/s2.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from asip_asm.files import write_text
from sim.motion.gcode.interpreter import stream
from sim.motion.geometry.curves import FloatArray
from sim.motion.geometry.moves import Motion, Move
from sim.motion.lookahead.joints import Joint
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import LookaheadSettings
from sim.report import pictures

PATH_FILE, CORNER_FILE = "lookahead_path.svg", "lookahead_corner.svg"
CHORDS = 84
CIRCUMFERENCE_MM = 362.0
# Of LinuxCNC 2.9.0~pre1 (Debian 12), run headless on these programs with the same limits, without
# a limit of jerk, positions logged at 1 kHz: times of the chords [s], and apex of the path logged
# [mm] by P [mm]. It samples ten times less often than we do.
LINUXCNC = {"without blending [s]": 5.074, "with blending [s]": 1.536}
LINUXCNC_APEX_MM = {0.001: 0.00204, 0.005: 0.00614, 0.010: 0.01111, 0.025: 0.02583}
PUBLISHED = {"without blending [s]": 5.0, "with blending [s]": 1.5}
CORNER_MM = 31.0
CORNER_TOLERANCES_MM = (0.001, 0.005, 0.010, 0.025)


def chord_program(mode: str, chords: int = CHORDS) -> str:
    """The path of figures 4 and 5 as a program; mode: for instance "G61" or "G64 P0.025"."""
    radius = CIRCUMFERENCE_MM / (2 * math.pi)
    angles = [2 * math.pi * k / chords for k in range(chords + 1)]
    points = [f"X{radius * math.cos(a):.9f} Y{radius * math.sin(a):.9f}" for a in angles]
    lines = [f"G21 G90 {mode}", f"G0 {points[0]}", "G4 P0", *(f"G1 {p} F15000" for p in points[1:])]
    return "\n".join([*lines, "M2"])


def without_approach(text: str) -> list[Move]:
    """Moves of a program without its first rapid."""
    moves = [item for item in stream(text.splitlines()) if isinstance(item, Move)]
    return moves[1:] if moves[0].motion is Motion.RAPID else moves


def corner_program(mode: str, angle: float = 90.0) -> str:
    """A corner at X31 Y0 between two lines of 20 mm; angle between their directions [degree]."""
    x = CORNER_MM + 20 * math.cos(math.radians(angle))
    y = 20 * math.sin(math.radians(angle))
    return f"G21 G90 {mode}\nG0 X{CORNER_MM - 20} Y0\nG1 X{CORNER_MM} F15000\nX{x:.9f} Y{y:.9f}\nM2"


def run(moves: list[Move], settings: LookaheadSettings) -> tuple[FloatArray, float, list[Joint]]:
    """Tool positions (n, 3) [mm], time [s] and joints of moves."""
    joints: list[Joint] = []
    plan = Lookahead(moves, settings, joints)
    points = np.concatenate([block.position[:, :3] for block in plan.setpoints()]) * 1e3
    return points, plan.summary.duration, joints


def figures(output: Path) -> dict[str, Any]:
    """Draws the figures into `output` (SVG, PNG) with `lookahead.json`; returns that."""
    output.mkdir(parents=True, exist_ok=True)
    base = LookaheadSettings(only_blends=True)
    stepped = replace(base, limits=MachineLimits.of(base.robot, jerk_limited=False))
    modes = {"without blending [s]": "G61", "with blending [s]": "G64 P0.025"}
    document: dict[str, Any] = {"figures 4 and 5": {}, "figure 6": []}
    paths: dict[str, FloatArray] = {}
    for name, mode in modes.items():
        moves = without_approach(chord_program(mode))
        points, time, _ = run(moves, base)
        paths[f"{mode}: {time:.3f} s"] = points
        document["figures 4 and 5"][name] = {
            "published": PUBLISHED[name],
            "jerk limited": time,
            "steps of acceleration": run(moves, stepped)[1],
        }
    _draw_path(output / PATH_FILE, paths, base.period)
    views: dict[str, FloatArray] = {}
    corner = np.array([CORNER_MM, 0.0])
    views["G61"] = run(without_approach(corner_program("G61")), base)[0]
    for tolerance in CORNER_TOLERANCES_MM:
        mode = f"G64 P{tolerance:g}"
        points, time, joints = run(without_approach(corner_program(mode)), base)
        views[mode] = points
        document["figure 6"].append(
            {
                "P [mm]": tolerance,
                "apex [mm]": joints[0].apex * 1e3,
                "apex of the set-points [mm]": float(
                    np.linalg.norm(points[:, :2] - corner, axis=1).min()
                ),
                "corner speed [mm/s]": joints[0].speed * 1e3,
                "time [s]": time,
            }
        )
    _draw_corner(output / CORNER_FILE, views)
    file = output / "lookahead.json"
    write_text(file, json.dumps(document, indent=2) + "\n")
    return document


def _draw_path(file: Path, paths: dict[str, FloatArray], period: float) -> None:
    plt = pictures.pyplot("lookahead")
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5))
    for name, points in paths.items():
        left.plot(points[:, 0], points[:, 1], linewidth=0.8, label=name)
        speed = np.linalg.norm(np.diff(points, axis=0), axis=1) / period
        right.plot(np.arange(len(speed)) * period, speed, linewidth=0.8, label=name)
    left.set(aspect="equal", xlabel="X [mm]", ylabel="Y [mm]")
    left.set_title(f"{CHORDS} chords of a circle, F15000 (path of our choice)", fontsize=10)
    right.set(xlabel="time [s]", ylabel="tool speed [mm/s]")
    right.set_title("figures 4 and 5 of the CNC paper: short lines, limited jerk", fontsize=10)
    right.legend(loc="center right")
    for axis in (left, right):
        axis.grid(alpha=0.3)
    pictures.save(figure, file)


def _draw_corner(file: Path, views: dict[str, FloatArray]) -> None:
    plt = pictures.pyplot("lookahead")
    figure, axis = plt.subplots(figsize=(5.5, 5.5))
    for name, points in views.items():
        axis.plot(points[:, 0], points[:, 1], marker=".", markersize=2, linewidth=0.8, label=name)
    axis.set(
        aspect="equal",
        xlim=(CORNER_MM - 0.03, CORNER_MM + 0.005),
        ylim=(-0.005, 0.03),
        xlabel="X [mm]",
        ylabel="Y [mm]",
        title="figure 6 of the CNC paper: a corner, set-points at 10 kHz",
    )
    axis.set_xticks(CORNER_MM + np.arange(-0.03, 0.006, 0.01))
    axis.grid(alpha=0.3)
    axis.legend()
    pictures.save(figure, file)
