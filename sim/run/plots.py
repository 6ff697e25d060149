# SPDX-License-Identifier: Apache-2.0
"""Plots of the main job: tool path in space, tracking errors per axis, forces and torques."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from sim.model.parameters import Robot
from sim.model.records import OUTPUTS, SetPoints
from sim.run.closed_loop import SETTLED_S, Recording

AXES = ("leg 1", "leg 2", "leg 3", "tilt", "rotation")
POINTS = 4000  # drawn per curve; error curves keep the extremes of every interval


def _envelope(values: NDArray[np.floating]) -> tuple[NDArray, NDArray, NDArray]:
    """Index of each interval, smallest and largest value in it."""
    step = max(1, len(values) // POINTS)
    n = len(values) // step
    blocks = values[: n * step].reshape(n, step)
    return np.arange(n) * step, blocks.min(axis=1), blocks.max(axis=1)


def tool_path(
    path: SetPoints, recording: Recording, drawing: NDArray[np.bool_], file: Path
) -> None:
    """Tool path in 3-D; `drawing` (N,) marks the ticks of feed moves."""
    figure = plt.figure(figsize=(8, 6))
    axes = figure.add_subplot(projection="3d")
    step = max(1, len(path) // (4 * POINTS))
    tool = recording.tool[::step] * 1e3
    on = drawing[::step]
    axes.plot(*np.where(on[:, None], np.nan, tool).T, color="0.75", lw=0.8, label="rapid")
    axes.plot(*np.where(on[:, None], tool, np.nan).T, color="tab:red", lw=1.8, label="feed")
    axes.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]", title="Tool path")
    axes.set_aspect("equal")
    axes.view_init(elev=22, azim=-72)
    axes.legend()
    _save(figure, file)


def errors(robot: Robot, desired: NDArray, recording: Recording, file: Path) -> None:
    """Tracking error of each axis over time."""
    figure, rows = plt.subplots(5, 1, figsize=(9, 9), sharex=True)
    skip = round(SETTLED_S / robot.T_s)
    for axis, (name, plot) in enumerate(zip(AXES, rows, strict=True)):
        error = (desired[:, axis] - recording.joints[:, axis]) * 1e6
        index, low, high = _envelope(error[skip:])
        plot.fill_between((index + skip) * robot.T_s, low, high, lw=0.6, color="tab:blue")
        plot.set_ylabel(f"{name}\n[{'µm' if axis < 3 else 'µrad'}]")
        plot.grid(alpha=0.3)
    rows[0].set_title("Tracking error, desired minus exact position")
    rows[-1].set_xlabel("time [s]")
    _save(figure, file)


def forces(robot: Robot, recording: Recording, file: Path) -> None:
    """Forces and torques over time."""
    figure, rows = plt.subplots(2, 1, figsize=(9, 6), sharex=True)
    for axis, name in enumerate(OUTPUTS):
        index, low, high = _envelope(recording.ticks.outputs[:, axis])
        plot = rows[0 if axis < 3 else 1]
        plot.fill_between(index * robot.T_s, low, high, lw=0.6, alpha=0.8, label=name)
    rows[0].set(ylabel="force [N]", title="Controller outputs")
    rows[1].set(ylabel="torque [N·m]", xlabel="time [s]")
    for plot in rows:
        plot.legend(loc="upper right")
        plot.grid(alpha=0.3)
    _save(figure, file)


def _save(figure: plt.Figure, file: Path) -> None:
    figure.tight_layout()
    figure.savefig(file, dpi=110)
    plt.close(figure)
