# SPDX-License-Identifier: Apache-2.0
"""Matplotlib figures as files: SVG and PNG, and the same curves as an interactive figure.

`save` writes all three below one name; a page takes the interactive one by `load`.
"""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import plotly.io

from asip_asm.files import replaced, write_text
from sim.report.curves import FRAME_HEIGHT, envelope, framed

DPI = 110
PIXELS_PER_INCH, TITLE_HEIGHT = 75, 18  # of an interactive figure, of a line of a title [px]
TITLE_WIDTH = 42  # characters of a line, for the width of a phone
COLUMN_WIDTH = 320  # least width of panels next to each other [px]
POINTS = 4_000  # of a curve at most
DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot"}
INTERACTIVE = ".plotly.json"


def pyplot(salt: str) -> Any:
    """matplotlib.pyplot for files. salt: any name; the same input then gives the same SVG."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    matplotlib.rcParams["svg.hashsalt"] = salt
    return plt


def save(figure: Any, file: Path) -> None:
    """Write a Matplotlib figure to `file` (SVG), next to it as PNG and interactive; closes it."""
    import matplotlib.pyplot as plt

    figure.tight_layout()
    with replaced(file) as new:
        figure.savefig(new, metadata={"Date": None})
    with replaced(file.with_suffix(".png")) as new:
        figure.savefig(new, dpi=DPI)
    write_text(file.with_suffix(INTERACTIVE), interactive(figure).to_json())
    plt.close(figure)


def load(file: Path) -> go.Figure | None:
    """The interactive figure that `save` wrote next to `file`, None if there is none."""
    found = file.with_suffix(INTERACTIVE)
    if not found.is_file():
        return None
    return plotly.io.from_json(found.read_text(encoding="utf-8"))


def least_width(figure: go.Figure) -> int:
    """Width below which a figure with panels next to each other is not narrowed, else 0 [px]."""
    columns = {axis.domain[0] for axis in figure.select_xaxes()}
    return COLUMN_WIDTH * len(columns) if len(columns) > 1 else 0


def interactive(figure: Any) -> go.Figure:
    """The curves of a Matplotlib figure: lines, event lines and outlined histograms of its axes."""
    made = go.Figure()
    boxes = np.array([axes.get_position().extents for axes in figure.axes])  # x0, y0, x1, y1
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    layout: dict[str, Any] = {}
    annotations, listed = [], set()
    for number, (axes, box) in enumerate(zip(figure.axes, boxes, strict=True), start=1):
        begin, end = (box[:2] - low) / (high - low), (box[2:] - low) / (high - low)
        for curve in _curves(axes):
            name = curve.pop("name")
            shown = bool(name) and name not in listed
            listed.add(name)
            group = {"name": name, "legendgroup": name} if name else {"hoverinfo": "x+y"}
            made.add_scatter(
                **curve, **group, showlegend=shown, xaxis=f"x{number}", yaxis=f"y{number}"
            )
        for letter, other, k in (("x", "y", 0), ("y", "x", 1)):
            layout[f"{letter}axis{number}"] = _axis(axes, letter) | {
                "anchor": f"{other}{number}",
                "domain": [float(begin[k]), float(end[k])],
            }
        layout[f"xaxis{number}"] |= _shared(figure, axes)
        if axes.get_aspect() == 1.0:
            layout[f"yaxis{number}"] |= {"scaleanchor": f"x{number}", "constrain": "domain"}
            layout[f"xaxis{number}"]["constrain"] = "domain"
        if axes.get_title():
            lines = textwrap.wrap(axes.get_title(), TITLE_WIDTH)
            annotations.append(
                {
                    **{"text": "<br>".join(lines), "showarrow": False, "font": {"size": 13}},
                    **{"xref": "paper", "x": float((begin + end)[0] / 2), "xanchor": "center"},
                    **{"yref": "paper", "y": float(end[1]), "yanchor": "bottom"},
                }
            )
    made.update_layout(**layout, annotations=annotations)
    height = figure.get_size_inches()[1] * PIXELS_PER_INCH  # of the panels
    most = max((str(entry["text"]).count("<br>") + 1 for entry in annotations), default=0)
    title = TITLE_HEIGHT * most + 8
    framed(made, round(height) + FRAME_HEIGHT + title)
    return made.update_layout(legend_y=1 + title / height, margin_t=45 + title)


def _curves(axes: Any) -> list[dict[str, Any]]:
    """Arguments of a trace for each line, row of events and outline; name "" if unlisted."""
    from matplotlib.colors import to_hex

    found = []
    for line in axes.get_lines():
        x, y = (np.asarray(values, dtype=float) for values in line.get_data(orig=False))
        if line.get_transform() == axes.get_yaxis_transform():  # a level over the whole width
            x = np.array(axes.get_xlim())
        kept = envelope(y, POINTS) if (np.diff(x) >= 0).all() else np.arange(len(x))
        marked, drawn = line.get_marker() not in ("None", None), line.get_linestyle() != "None"
        colour = to_hex(line.get_color())
        found.append(
            {
                "x": x[kept].astype(np.float32),
                "y": y[kept].astype(np.float32),
                "name": _name(line),
                "mode": "+".join(["lines"] * drawn + ["markers"] * marked),
                "marker": {"color": colour, "size": 4},
                "line": {
                    "color": colour,
                    "width": 1.3 * line.get_linewidth(),
                    "dash": DASHES.get(line.get_linestyle(), "solid"),
                    "shape": "hv" if line.get_drawstyle() == "steps-post" else "linear",
                },
            }
        )
    for events in axes.collections:
        ends = np.full((len(events.get_segments()), 3, 2), np.nan)
        ends[:, :2] = np.array(events.get_segments())
        x, y = ends.reshape(-1, 2).astype(np.float32).T
        line = {"color": to_hex(np.atleast_2d(events.get_color())[0][:3]), "width": 1}
        found.append({"x": x, "y": y, "name": _name(events), "mode": "lines", "line": line})
    for outline in axes.patches:
        x, y = outline.get_xy().astype(np.float32).T
        line = {"color": to_hex(outline.get_edgecolor()), "width": 1.3}
        found.append({"x": x, "y": y, "name": _name(outline), "mode": "lines", "line": line})
    return found


def _name(artist: Any) -> str:
    """Label of a listed artist; Matplotlib begins that of others with an underscore."""
    label = str(artist.get_label())
    return "" if label.startswith("_") else label


def _axis(axes: Any, letter: str) -> dict[str, Any]:
    """Title, scale and range of an axis, the range only where it was set by hand."""
    described: dict[str, Any] = {"title": {"text": getattr(axes, f"get_{letter}label")()}}
    limits = np.array(getattr(axes, f"get_{letter}lim")())
    if getattr(axes, f"get_{letter}scale")() == "log":
        described |= {"type": "log", "dtick": 1, "range": np.log10(limits).tolist()}
    elif not getattr(axes, f"get_autoscale{letter}_on")():
        described["range"] = limits.tolist()
    if letter == "y" and not axes.get_yticks().size:
        described["showticklabels"] = False
    return described


def _shared(figure: Any, axes: Any) -> dict[str, Any]:
    """Common x axis of the panels below each other; only the lowest has numbers."""
    siblings = [other for other in figure.axes if axes.get_shared_x_axes().joined(axes, other)]
    if len(siblings) < 2:
        return {}
    lowest = min(siblings, key=lambda other: other.get_position().y0)
    number = figure.axes.index(lowest) + 1
    return {} if axes is lowest else {"matches": f"x{number}", "showticklabels": False}
