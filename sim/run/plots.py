# SPDX-License-Identifier: Apache-2.0
"""Pictures of the main job (PNG): tool path with the table axes, tracking errors, forces."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from sim.model.parameters import Robot
from sim.model.records import OUTPUTS, SetPoints
from sim.page.curves import box, envelope
from sim.run.closed_loop import SETTLED_S, Recording

AXES = ("leg 1", "leg 2", "leg 3", "tilt", "rotation")
PATH_POINTS = 16_000  # of the path in space
TICKS = 6  # numbers along the longest axis in space


def tool_path(
    robot: Robot,
    path: SetPoints,
    recording: Recording,
    drawing: NDArray[np.bool_],
    file: Path,
) -> None:
    """Tool path in 3-D above the table axes; `drawing` (N,) marks the ticks of feed moves."""
    figure = plt.figure(figsize=(8, 8.5))
    grid = figure.add_gridspec(3, 1, height_ratios=(6, 1, 1), hspace=0.25)
    axes = figure.add_subplot(grid[0], projection="3d")
    step = max(1, len(path) // PATH_POINTS)
    tool = recording.tool[::step] * 1e3
    on = drawing[::step]
    axes.plot(*np.where(on[:, None], np.nan, tool).T, color="0.6", lw=0.8, label="rapid")
    axes.plot(*np.where(on[:, None], tool, np.nan).T, color="tab:red", lw=1.8, label="feed")
    axes.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]", title="Tool path and table axes")
    low, high = box(tool)
    axes.set_box_aspect(high - low)
    for name, limits in zip("xyz", np.stack([low, high], axis=1), strict=True):
        axes.set(**{f"{name}lim": limits})
        share = (limits[1] - limits[0]) / (high - low).max()
        axes.locator_params(axis=name, nbins=max(2, round(TICKS * share)))
        getattr(axes, f"{name}axis").labelpad = 8
    axes.view_init(elev=22, azim=-72)
    axes.legend()
    for row, name in enumerate(AXES[3:]):
        _curve(
            figure.add_subplot(grid[row + 1]),
            robot,
            np.degrees(path.table_position[:, row]),
            f"{name}\n[°]",
        )
    figure.axes[-1].set_xlabel("time [s]")
    _save(figure, file)


def errors(robot: Robot, desired: NDArray, recording: Recording, file: Path) -> None:
    """Tracking error of each axis over time."""
    skip = round(SETTLED_S / robot.T_s)
    figure, rows = plt.subplots(5, 1, figsize=(9, 9), sharex=True)
    for axis, (name, plot) in enumerate(zip(AXES, rows, strict=True)):
        error = (desired[:, axis] - recording.joints[:, axis])[skip:] * 1e6
        _curve(plot, robot, error, f"{name}\n[{'µm' if axis < 3 else 'µrad'}]", skip)
    rows[0].set_title("Tracking error, desired minus exact position")
    rows[-1].set_xlabel("time [s]")
    _save(figure, file)


def forces(robot: Robot, recording: Recording, file: Path) -> None:
    """Forces and torques over time."""
    figure, rows = plt.subplots(5, 1, figsize=(9, 9), sharex=True)
    for axis, (name, plot) in enumerate(zip(OUTPUTS, rows, strict=True)):
        label = f"{name}, {AXES[axis]}\n[{'N' if axis < 3 else 'N·m'}]"
        _curve(plot, robot, recording.ticks.outputs[:, axis], label)
    rows[0].set_title("Forces of the legs and torques of the table axes")
    rows[-1].set_xlabel("time [s]")
    _save(figure, file)


def _curve(plot: plt.Axes, robot: Robot, values: NDArray, label: str, first: int = 0) -> None:
    """Values of consecutive ticks over time, from tick `first` on."""
    kept = envelope(values)
    plot.plot((kept + first) * robot.T_s, values[kept], lw=0.6, color="tab:blue")
    plot.set_ylabel(label)
    plot.grid(alpha=0.3)


def _save(figure: plt.Figure, file: Path) -> None:
    figure.align_ylabels()
    figure.savefig(file, dpi=110, bbox_inches="tight")
    plt.close(figure)
