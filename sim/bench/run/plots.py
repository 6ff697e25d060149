# SPDX-License-Identifier: Apache-2.0
"""Pictures of the main job (PNG): tool path with the table axes, tracking errors, forces."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from asip_asm.files import replaced
from sim.bench.run.figures import AXES
from sim.core.closed_loop import SETTLED_S, Recording
from sim.report.curves import box, envelope
from sim.robot.parameters import Robot
from sim.robot.records import OUTPUTS, SetPoints

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
    error = (desired - recording.joints)[skip:] * 1e6
    labels = [f"{name}\n[{'µm' if axis < 3 else 'µrad'}]" for axis, name in enumerate(AXES)]
    _axes(robot, "Tracking error, desired minus exact position", labels, error, skip, file)


def forces(robot: Robot, recording: Recording, file: Path) -> None:
    """Forces and torques over time."""
    labels = [
        f"{name}, {AXES[axis]}\n[{'N' if axis < 3 else 'N·m'}]" for axis, name in enumerate(OUTPUTS)
    ]
    title = "Forces of the legs and torques of the table axes"
    _axes(robot, title, labels, recording.ticks.outputs, 0, file)


def _axes(
    robot: Robot, title: str, labels: list[str], values: NDArray, first: int, file: Path
) -> None:
    """Values (N, 5) of consecutive ticks over time, from tick `first` on, a panel for each axis."""
    figure, rows = plt.subplots(5, 1, figsize=(9, 9), sharex=True)
    for plot, label, column in zip(rows, labels, values.T, strict=True):
        _curve(plot, robot, column, label, first)
    rows[0].set_title(title)
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
    with replaced(file) as new:
        figure.savefig(new, dpi=110, bbox_inches="tight")
    plt.close(figure)
