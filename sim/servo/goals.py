# SPDX-License-Identifier: Apache-2.0
"""What the drives are to reach, and what of it is measured: the rows of build/drive.json."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.program import build
from sim.model.drives import Drives
from sim.model.parameters import Robot
from sim.servo.current_law import AXES, Setting, current_law
from sim.servo.current_loop import respond, rise_and_overshoot

SMALL = 0.03  # of i_max: a step that the bus voltage allows; it limits the rise of larger ones
CYCLES = {"small": 700, "fast": 220}
NOT_MEASURED = (
    ("sampling instant to new compare values, one axis on fast", "us", 1.5),
    ("closed current loop, -3 dB, with noise and dead time", "Hz", 5000),
    ("closed current loop, phase margin, with noise and dead time", "degrees", 45),
    ("dead-time distortion at 5 % of rated current, compensated", "times", 5),
    ("whole path, leg", "um", 1.5),
    ("whole path, tool", "um", 7),
    ("whole path, table", "urad", 75),
    ("every clock of the chain for 2 s of the path", "minutes", 30),
    ("whole path with the averaged inverter", "minutes", 30),
)
"""Name, unit, target of the rows that need the chain in closed loop."""


def cycles(drives: Drives, setting: Setting, configuration: str) -> int:
    """Of the program of five axes."""
    options = Options(configuration=configuration, reassociate=True, reciprocal=True)
    with tempfile.TemporaryDirectory() as folder:
        law = current_law(drives, setting, AXES)
        return build(compile_law(law, options), Path(folder) / "current_loops.s").cycles


def measure(path: Path | None, report: Callable[[str], None]) -> list[dict[str, Any]]:
    """Rows {name, value, unit, target, met} for the parameters in `path`; value None: not measured.

    Raises ParameterError.
    """
    drives, robot = Drives.load(path), Robot.load(path)
    setting = Setting(robot.resolution)
    rows: list[dict[str, Any]] = []

    def add(name: str, value: float | None, unit: str, target: float, met: bool) -> None:
        rows.append(dict(name=name, value=value, unit=unit, target=target, met=met))

    for configuration, target in CYCLES.items():
        report(f"program of five axes on {configuration}")
        found = cycles(drives, setting, configuration)
        add(f"five current loops on {configuration}", found, "cycles", target, found <= target)
    rises, overshoots = [], []
    for axis in (0, 3, 4):
        report(f"step of the current, axis {axis + 1}")
        wanted = SMALL * drives.motors[axis].i_max
        found = respond(drives, replace(setting, compensation=0.0), axis, wanted, 300)
        rise, overshoot = rise_and_overshoot(found[:, 1], setting.period)
        rises.append(1e6 * rise)
        overshoots.append(100 * overshoot)
    about = "without noise and dead time"
    add(f"step of the current, 10 % to 90 %, {about}", max(rises), "us", 100, max(rises) <= 100)
    most = max(overshoots)
    add(f"step of the current, overshoot, {about}", most, "%", 15, most <= 15)
    for name, unit, target in NOT_MEASURED:
        add(name, None, unit, target, False)
    return rows
