# SPDX-License-Identifier: Apache-2.0
"""Interactive figures of the main job: tool path in space, axes, errors, forces, histogram."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from sim.core.closed_loop import SETTLED_S, Recording
from sim.report.curves import COLOURS, INK, box, envelope, framed, panels
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints

AXES = ("leg 1", "leg 2", "leg 3", "tilt", "rotation")
PATH_POINTS = 2_500  # of the path in space, for each of the quantities that colour it
TICKS = 8  # numbers along the longest axis in space
ZOOM = 2.2  # of the box around the path: its diagonal then fills the figure
BINS = 160
HIGH = 0.253  # of a panel of the histogram, by the figure
MICRO = 1e6


def tool_path(
    robot: Robot, path: SetPoints, drawing: NDArray[np.bool_], recording: Recording | None
) -> go.Figure:
    """The tool in space, equal axes; buttons colour it by tracking error or by speed.

    drawing (N,): ticks of feed moves, the others are thin. Without a recording the path as wanted.
    """
    speed = np.linalg.norm(path.velocity, axis=1) * 60e3
    colours = {"speed [mm/min]": speed}
    tool = path.position * 1e3
    if recording is not None:
        tool = recording.tool * 1e3
        colours = {"tracking error [µm]": tool_error(robot, path, recording)} | colours
    kept = np.unique(np.concatenate([envelope(c, PATH_POINTS) for c in colours.values()]))
    time = kept * robot.T_s
    figure = go.Figure()
    for shown, (name, values) in enumerate(colours.items()):
        for feed in (True, False):
            on = (drawing[kept] == feed)[:, np.newaxis]
            points = np.where(on, tool[kept], np.nan).astype(np.float32)
            figure.add_scatter3d(
                **_places(points),
                mode="lines",
                name="feed" if feed else "rapid",
                showlegend=False,
                visible=shown == 0,
                connectgaps=False,
                customdata=np.stack([time, values[kept]], axis=1).astype(np.float32),
                hovertemplate=(
                    "x %{x:.3f}, y %{y:.3f}, z %{z:.3f} mm<br>%{customdata[0]:.3f} s<br>"
                    f"{name} %{{customdata[1]:.3f}}"
                ),
                line={
                    "width": 7 if feed else 2,
                    "color": values[kept].astype(np.float32),
                    "colorscale": "Viridis",
                    "cmin": 0.0,
                    "cmax": float(values.max()) or 1.0,
                    "showscale": feed,
                    "colorbar": {
                        "title": {"text": name, "side": "top"},
                        "orientation": "h",
                        "thickness": 12,
                        "len": 0.8,
                        "y": 0.0,
                        "yanchor": "top",
                    },
                },
            )
        worst = int(values.argmax())
        figure.add_scatter3d(
            **_places(tool[worst : worst + 1]),
            mode="markers",
            name="largest",
            showlegend=False,
            visible=shown == 0,
            marker={"size": 5, "symbol": "diamond-open", "color": INK},
            hovertemplate=f"largest {name}: {values[worst]:.3f}<br>{worst * robot.T_s:.4f} s",
        )
    each = len(figure.data) // len(colours)
    buttons = [
        {
            "label": f"colour: {name.split(' [')[0]}",
            "method": "restyle",
            "args": [{"visible": [k // each == shown for k in range(len(figure.data))]}],
        }
        for shown, name in enumerate(colours)
    ]
    framed(figure, 600).update_layout(
        scene=_equal_axes(tool),
        margin={"l": 0, "r": 0, "t": 50, "b": 70},
        updatemenus=[
            {
                "type": "buttons",
                "direction": "right",
                "buttons": buttons,
                "x": 0,
                "xanchor": "left",
                "y": 1,
                "yanchor": "bottom",
            }
        ],
    )
    return figure


def _places(points: NDArray) -> dict[str, NDArray]:
    return dict(zip("xyz", points.T, strict=True))


def _equal_axes(points: NDArray) -> dict:
    """A scene in which a millimetre is the same along x, y and z, for (N, 3) points [mm]."""
    low, high = box(points)
    extent = high - low
    scene = {
        f"{name}axis": {
            "title": {"text": ""},
            "tickprefix": f"{name} ",
            "showtickprefix": "last",
            "tickangle": 0,
            "range": [low[k], high[k]],
            "backgroundcolor": "#f7f7f7",
            "showbackground": True,
            "gridcolor": "#cccccc",
            "nticks": max(2, round(TICKS * extent[k] / extent.max())),
        }
        for k, name in enumerate("xyz")
    }
    ratio = dict(zip("xyz", (ZOOM * extent / np.linalg.norm(extent)).tolist(), strict=True))
    # From the front, above and a little from the left; z is up.
    return scene | {
        "aspectmode": "manual",
        "aspectratio": ratio,
        "camera": {"eye": {"x": 0.5, "y": -1.6, "z": 0.7}, "projection": {"type": "orthographic"}},
    }


def tool_error(robot: Robot, path: SetPoints, recording: Recording) -> NDArray[np.float64]:
    """Distance (N,) of the tool from its place on the path [µm]; 0 before the loop has settled."""
    error = np.linalg.norm(recording.tool - path.position, axis=1) * MICRO
    error[: round(SETTLED_S / robot.T_s)] = 0.0
    return error


def axes(robot: Robot, path: SetPoints) -> go.Figure:
    """Where the program wants tool and table, over time."""
    rows = [
        (f"{n} [mm]", {"as programmed": path.position[:, k] * 1e3}) for k, n in enumerate("xyz")
    ]
    rows += [
        (f"{name} [°]", {"as programmed": np.degrees(path.table_position[:, k])})
        for k, name in enumerate(AXES[3:])
    ]
    return panels(_time(robot, path), rows)


def errors(
    robot: Robot, path: SetPoints, desired: NDArray, recordings: Mapping[str, Recording]
) -> go.Figure:
    """Tracking error of tool and axes over time; the first program is shown, others on demand."""
    skip = round(SETTLED_S / robot.T_s)
    rows = [
        ("tool [µm]", {n: tool_error(robot, path, r)[skip:] for n, r in recordings.items()}),
        *(
            (
                f"{name} [{'µm' if axis < 3 else 'µrad'}]",
                {
                    program: (desired - run.joints)[skip:, axis] * MICRO
                    for program, run in recordings.items()
                },
            )
            for axis, name in enumerate(AXES)
        ),
    ]
    return panels(_time(robot, path)[skip:], rows, hidden=list(recordings)[1:])


def forces(robot: Robot, path: SetPoints, recordings: Mapping[str, Recording]) -> go.Figure:
    """What the controller commands, over time."""
    rows = [
        (
            f"{name} [{'N' if axis < 3 else 'N·m'}]",
            {program: run.ticks.outputs[:, axis] for program, run in recordings.items()},
        )
        for axis, name in enumerate(AXES)
    ]
    return panels(_time(robot, path), rows, hidden=list(recordings)[1:])


def histogram(robot: Robot, path: SetPoints, desired: NDArray, recording: Recording) -> go.Figure:
    """How often each size of tracking error occurs: tool, legs, table axes."""
    skip = round(SETTLED_S / robot.T_s)
    error = (desired - recording.joints)[skip:] * MICRO
    panel = {
        "tool, distance [µm]": {"tool": tool_error(robot, path, recording)[skip:]},
        "legs [µm]": {AXES[k]: error[:, k] for k in range(3)},
        "table [µrad]": {AXES[k]: error[:, k] for k in (3, 4)},
    }
    figure = go.Figure()
    layout: dict[str, Mapping[str, object]] = {}
    for number, (title, curves) in enumerate(panel.items(), start=1):
        values = np.concatenate(list(curves.values()))
        edges = np.histogram_bin_edges(values, BINS)
        for name, value in curves.items():
            figure.add_bar(
                x=((edges[1:] + edges[:-1]) / 2).astype(np.float32),
                y=np.histogram(value, edges)[0].astype(np.int32),
                name=name,
                marker={"color": COLOURS[len(figure.data)], "opacity": 0.6, "line": {"width": 0}},
                xaxis=f"x{number}",
                yaxis=f"y{number}",
            )
        top = 1 - (number - 1) * (HIGH + 0.12)
        layout[f"xaxis{number}"] = {"title": {"text": title}, "anchor": f"y{number}"}
        scale: dict[str, object] = {
            "title": {"text": "ticks"},
            "anchor": f"x{number}",
            "domain": [max(0.0, top - HIGH), top],
            "type": "log",
            "dtick": 1,
        }
        layout[f"yaxis{number}"] = scale
    return framed(figure.update_layout(**layout, barmode="overlay", bargap=0), 620)


def _time(robot: Robot, path: SetPoints) -> NDArray[np.float64]:
    return np.arange(len(path), dtype=np.float64) * robot.T_s
