# SPDX-License-Identifier: Apache-2.0
"""What the results of the main job must keep: error bounds, the PC's words, tracking targets; and
the goals that a run can check by itself, next to what it measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from sim.robot.parameters import Robot

# Largest tracking errors of the robot of sim/robot.toml on the path A-G-H [m, m, rad].
TARGET_PATH = "agh.ngc"
TRACKING_TARGETS = {"leg": 1e-6, "tool": 5e-6, "table": 50e-6}
AXES = {"leg": ("a leg", "m"), "tool": ("the tool", "m"), "table": ("a table axis", "rad")}


def enter(data: dict[str, Any], published: bool) -> None:
    """Enter `bounds_ok` and `exceeded` into the content of results.json.

    published: the run is of the case for which there are targets of the tracking errors.
    exceeded: per comparison that fails the key of results.json it is about, the row, a sentence.
    """
    found = list(_bounds(data)) + list(_words(data))
    if published:
        found += _targets(data)
    data["exceeded"] = [{"in": key, "row": row, "text": text} for key, row, text in found]
    data["bounds_ok"] = not found


def is_published(robot: Robot, gcode: Path) -> bool:
    """Whether a run is of the case for which there are targets of the tracking errors."""
    return robot == Robot.load() and gcode.name == TARGET_PATH


def is_marked(data: dict[str, Any], key: str, row: str) -> bool:
    """Whether a row of a table belongs to a comparison that failed."""
    return any(entry["in"] == key and entry["row"] == row for entry in data.get("exceeded", ()))


def _bounds(data: dict[str, Any]) -> Iterator[tuple[str, str, str]]:
    """An error that is no number is beyond its bound."""
    for program, fractions in data.get("worst_fraction_of_bound", {}).items():
        for output, fraction in fractions.items():
            if not fraction <= 1.0:
                text = f"{program}: error of {output} is {fraction:.3g} of its bound"
                yield "worst_fraction_of_bound", program, text


def _words(data: dict[str, Any]) -> Iterator[tuple[str, str, str]]:
    """FPGA1 and FPGA2 evaluate the PC's formulas: all words equal but the sine's last bit."""
    for platform, measured in data.get("nios", {}).items():
        for row, ticks in measured["words_other_than_pc_float32"].items():
            if row != "tau4":
                text = f"{platform}: {row} differs from the PC's float32 in {ticks} ticks"
                yield "nios", row, text
        if not measured["tau4_to_pc_of_limit"] <= 1.0:
            yield "nios", "tau4", f"{platform}: tau4 differs by more than the sine's last bit"


def _targets(data: dict[str, Any]) -> Iterator[tuple[str, str, str]]:
    for program, errors in data.get("tracking", {}).items():
        for name, target in TRACKING_TARGETS.items():
            if isinstance(errors, dict) and not errors[name] <= target:
                text = f"{program}: tracking error of {name} {errors[name]:.3g}, target {target:g}"
                yield "tracking", program, text


def goals(data: dict[str, Any], published_path: bool) -> list[dict[str, Any]]:
    """Name, value, unit, target and whether it is met; data: the content of results.json.

    published_path: the letters A, G, H, for which there are targets of the tracking errors.
    """
    found = []

    def add(name: str, value: float, unit: str, target: float) -> None:
        met = value <= target
        found.append({"name": name, "value": value, "unit": unit, "target": target, "met": met})

    programs = [errors for errors in data["tracking"].values() if isinstance(errors, dict)]
    if published_path and programs:
        for key, target in TRACKING_TARGETS.items():
            name, unit = AXES[key]
            worst = max(errors[key] for errors in programs)
            add(f"largest tracking error of {name}", worst, unit, target)
    period = data["robot"]["values"]["T_s"] * 1e6
    for name, times in timing_of_programs(data).items():
        add(f"longest tick of {name}", times["time_us"], "us", period)
    return found


def timing_of_programs(data: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """Timing by name of platform, and of program where a platform has several."""
    found = {}
    for platform, timing in data["platforms"].items():
        for program, times in ({"": timing} if "time_us" in timing else timing).items():
            found[f"{platform.upper()} {program.replace('_', ' ')}".strip()] = times
    return found
