# SPDX-License-Identifier: Apache-2.0
"""What `make dual` measures: cycles, time left, set-points against the planned path, tracking."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from sim.dual.system import TwoProcessors
from sim.harness.dual_rtl import REGMAP
from sim.model.parameters import Robot
from sim.model.records import SetPoints
from sim.model.tracking import joint_path
from sim.run.closed_loop import Recording, tracking_error
from sim.run.controller import SET_POINTS, ControllerFault
from sim.run.results import CLOCK_MHZ

NOMINAL_CLOCKS = int(REGMAP.registers["PERIOD"].reset or 0)  # 100 us
REGISTERS = (
    *("TRAJECTORY_MIN", "TRAJECTORY_MAX", "TRACKING_MIN", "TRACKING_MAX", "COMMAND_MAX"),
    *("COPY_MAX", "USED_MAX", "LEFT_MIN", "PERIODS", "UNDERRUNS", "OVERRUNS"),
)


def set_point_errors(path: SetPoints, made: NDArray[np.float32]) -> dict[str, float]:
    """Largest difference of each word to the planned path, (N, 15) against N ticks."""
    difference = np.abs(made.astype(np.float64) - path.words()).max(axis=0)
    return dict(zip(SET_POINTS, difference.tolist(), strict=True))


def results(
    robot: Robot, path: SetPoints, recording: Recording, controller: TwoProcessors
) -> dict[str, Any]:
    """The content of build/dual/results.json; clocks come from the system's registers.

    Raises ControllerFault if the system has counted other periods than the closed loop.
    """
    system = controller.system
    clocks = {name.lower(): system.read(name) for name in REGISTERS}
    period = system.read("PERIOD")
    if clocks["periods"] != len(path) + 1:  # one before the first tick
        raise ControllerFault(f"{clocks['periods']} periods for {len(path)} ticks")
    # The work of a period does not depend on its length: the rest of it is idle.
    left = NOMINAL_CLOCKS - (period - clocks["left_min"])
    desired = joint_path(robot, path)[0]
    return {
        "ticks": len(path),
        "clock_mhz": CLOCK_MHZ,
        "period_clocks_simulated": period,
        "period_clocks_nominal": NOMINAL_CLOCKS,
        "configuration": {n: image.configuration for n, image in controller.images.items()},
        "clocks": clocks,
        "left_of_nominal_period": {
            "clocks_min": left,
            "us_min": left / CLOCK_MHZ,
            "share_min": left / NOMINAL_CLOCKS,
        },
        "latency": {
            "set_point_periods": 1,
            "period_start_to_command_clocks_max": clocks["command_max"],
        },
        "flags": system.flags(),
        "set_point_error": set_point_errors(path, np.array(controller.set_points[: len(path)])),
        "tracking": vars(tracking_error(robot, path, desired, recording)),
    }


def tables(data: dict[str, Any]) -> Iterator[Table]:
    """The figures of results.json as tables."""
    clocks, us = data["clocks"], 1.0 / data["clock_mhz"]
    timing = Table(title=f"two processors, {data['ticks']} ticks at {data['clock_mhz']} MHz")
    timing.add_column("part of a period")
    for head in ("least", "most", "most [us]"):
        timing.add_column(head, justify="right")
    for name, low, high in (
        ("trajectory core, cycles", clocks["trajectory_min"], clocks["trajectory_max"]),
        ("tracking core, cycles", clocks["tracking_min"], clocks["tracking_max"]),
        ("copying, clocks", None, clocks["copy_max"]),
        ("period start to commands, clocks", None, clocks["command_max"]),
        ("all work, clocks", None, clocks["used_max"]),
    ):
        timing.add_row(name, "" if low is None else str(low), str(high), f"{high * us:.2f}")
    left = data["left_of_nominal_period"]
    timing.add_row("left of 100 us, clocks", str(left["clocks_min"]), "", f"{left['us_min']:.2f}")
    yield timing

    handed = Table(title="set-points of the core against the plan in double precision")
    for head in ("word", "largest difference", "unit"):
        handed.add_column(head, justify="left" if head == "word" else "right")
    for name, value in data["set_point_error"].items():
        angle = name in ("alpha", "gamma") or "_" in name
        order = 0 if name in ("x", "y", "z", "alpha", "gamma") else 2 if name[0] in "ae" else 1
        unit = ("rad" if angle else "m") + ("", "/s", "/s^2")[order]
        handed.add_row(name, f"{value:.3g}", unit)
    yield handed

    tracking = Table(title="largest tracking error after 50 ms")
    for head in ("", "two processors", "one processor"):
        tracking.add_column(head, justify="right")
    for name, scale, unit in (("leg", 1e6, "um"), ("tool", 1e6, "um"), ("table", 1e6, "urad")):
        both = (data[key][name] * scale for key in ("tracking", "tracking_single_core"))
        tracking.add_row(f"{name} [{unit}]", *(f"{value:.4f}" for value in both))
    yield tracking
