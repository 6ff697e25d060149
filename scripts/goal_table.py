# SPDX-License-Identifier: Apache-2.0
"""The table of goals that a measured page or a terminal shows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich import box
from rich.table import Table


def goal_table(goals: Sequence[Mapping[str, Any]]) -> str:
    """Markdown of goals {name, value, unit, target, met}; a value None was not measured."""
    head = "| what | reached | target |\n| --- | --- | --- |\n"
    return head + "".join(
        f"| {goal['name']} | {_value(goal)} | {goal['target']:g} {_unit(goal)}|\n" for goal in goals
    )


def goal_view(goals: Iterable[Mapping[str, Any]]) -> Table:
    """The rows of `sim.debug.row.Row` for a terminal."""
    view = Table("what", "value", "unit", "target", "met", "", box=box.SIMPLE_HEAD)
    for goal in goals:
        value = "-" if goal["value"] is None else f"{goal['value']:.6g}"
        met = "yes" if goal["met"] else "[red]no[/red]"
        view.add_row(goal["name"], value, goal["unit"], goal["target"], met, goal["note"])
    return view


def _unit(goal: Mapping[str, Any]) -> str:
    return "" if goal["unit"] in ("1", "") else goal["unit"] + " "


def _value(goal: Mapping[str, Any]) -> str:
    if goal["value"] is None:
        return "not measured"
    value = goal["value"]
    whole = abs(value) < 1e6 and value == round(value)
    number = f"{value:.0f}" if whole else f"{value:.4g}" if value < 1e6 else f"{value:.3g}"
    return f"{number} {_unit(goal)}".strip() + ("" if goal["met"] else ", missed")
