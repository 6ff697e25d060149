# SPDX-License-Identifier: Apache-2.0
"""Goals: what was measured, and what it should reach; their JSON form and their tables."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeVar

from rich import box
from rich.markup import escape
from rich.table import Table

from asip_asm.files import write_text
from asip_asm.pace import Pace

Item = TypeVar("Item")
NOT_MEASURED, SAMPLED = "not measured", "sampled"


@dataclass(frozen=True)
class Goal:
    """One row of `goals` in build/NAME.json.

    value: as measured, None where it could not be measured. target: a relation and a number, such
    as "<= 1500". met: None where a quick run measured a sample only, or a tool is missing; the note
    then says how to measure it.
    """

    name: str
    value: float | None
    unit: str
    target: str
    met: bool | None
    note: str = ""


def at_most(name: str, value: float, limit: float, unit: str, note: str = "") -> Goal:
    """A value that may not exceed a limit."""
    return Goal(name, value, unit, f"<= {limit:g}", bool(value <= limit), note)


def at_least(name: str, value: float, limit: float, unit: str, note: str = "") -> Goal:
    """A value that has to reach a limit."""
    return Goal(name, value, unit, f">= {limit:g}", bool(value >= limit), note)


def exactly(name: str, value: float, wanted: float, unit: str, note: str = "") -> Goal:
    """A value that has to be one number."""
    return Goal(name, value, unit, f"{wanted:g}", bool(value == wanted), note)


def not_measured(name: str, target: str, unit: str, cure: str) -> Goal:
    """A value that this run did not measure; cure: the command that does, or what is missing."""
    return Goal(name, None, unit, target, None, cure)


def depth(name: str, value: float, limit: float, unit: str, cure: str) -> Goal:
    """How much a campaign tried. Fewer cases than the goal names are a sample, not a miss.

    cure: the command that tries them all.
    """
    return Goal(name, value, unit, f">= {limit:g}", True if value >= limit else None, cure)


def paced(items: Sequence[Item], what: str) -> Iterator[Item]:
    """The items, with the pace at which they are taken."""
    pace = Pace(what, len(items))
    for done, item in enumerate(items):
        pace.at(done)
        yield item


def missed(goals: Iterable[Mapping[str, Any]]) -> list[str]:
    """Names of the goals that are not met. What was not measured is not a miss."""
    return [goal["name"] for goal in goals if goal["met"] is False]


def as_json(goals: Iterable[Goal]) -> list[dict[str, Any]]:
    """The goals as `write_goals` takes them."""
    return [asdict(goal) for goal in goals]


def write_goals(file: Path, goals: Iterable[Mapping[str, Any]], **more: Any) -> None:
    """Write {"goals": ...} and further fields; the file appears whole or not at all."""
    file.parent.mkdir(parents=True, exist_ok=True)
    write_text(file, json.dumps(more | {"goals": list(goals)}, indent=2) + "\n")


def merged(
    file: Path, producer: str, goals: Iterable[Goal], order: Iterable[str]
) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Further fields of a results file, and its goals with these of a producer in place of earlier
    ones; order: names of all producers. Read it just before writing: other runs may write too."""
    content = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    found: dict[str, list[dict[str, Any]]] = {}
    for goal in content.pop("goals", []):
        found.setdefault(goal.get("producer", ""), []).append(goal)
    found[producer] = [row | {"producer": producer} for row in as_json(goals)]
    return content, [goal for each in order for goal in found.get(each, [])]


def begin_goals(file: Path) -> None:
    """A run of every producer begins: the file is whole at its end only."""
    if not file.exists():
        return
    content = json.loads(file.read_text(encoding="utf-8"))
    write_goals(file, content.pop("goals"), **content | {"depths": {}, "whole": False})


def merge_goals(
    file: Path,
    producer: str,
    goals: Iterable[Goal],
    order: Sequence[str],
    full: bool,
    **more: Any,
) -> list[dict[str, Any]]:
    """Write the goals and further fields of a producer; those of the others stay. All goals.

    The field `depths` has the producers, true after a full run; `whole` says that all of them had
    one.
    """
    content, rows = merged(file, producer, goals, order)
    depths = content.get("depths", {}) | {producer: full}
    whole = all(depths.get(name, False) for name in order)
    write_goals(file, rows, **content | more | {"depths": depths, "whole": whole})
    return rows


def verdict(goal: Mapping[str, Any]) -> str:
    """Met, missed, sampled or not measured, in words."""
    if goal["met"] is None:
        return NOT_MEASURED if goal["value"] is None else SAMPLED
    return "met" if goal["met"] else "missed"


def terminal_table(goals: Iterable[Mapping[str, Any]]) -> Table:
    """The goals for a terminal."""
    view = Table("what", "value", "unit", "target", "", "", box=box.SIMPLE_HEAD)
    for goal in goals:
        value = "-" if goal["value"] is None else f"{goal['value']:.6g}"
        found = verdict(goal)
        shown = f"[red]{found}[/red]" if goal["met"] is False else found
        note = escape(goal.get("note", ""))
        view.add_row(escape(goal["name"]), value, goal["unit"], goal["target"], shown, note)
    return view


def markdown_table(goals: Iterable[Mapping[str, Any]]) -> str:
    """The goals for a page."""
    head = "| what | reached | target |\n| --- | --- | --- |\n"
    return head + "".join(
        f"| {goal['name']} | {_reached(goal)} | {_with_unit(goal['target'], goal)} |\n"
        for goal in goals
    )


def updated_table(table: str, results: Mapping[str, Any]) -> str:
    """A page's table with the results of full runs. Results that are not whole replace the rows of
    their names, or come after the others; the other rows stay."""
    goals = results["goals"]
    if results.get("whole"):
        return markdown_table(goals)
    depths = results.get("depths", {})
    new = [goal for goal in goals if depths.get(goal["producer"]) and goal["value"] is not None]
    _, _, *made = markdown_table(new).splitlines()
    rows = {goal["name"]: row for goal, row in zip(new, made, strict=True)}
    lines = [rows.pop(line.split(" | ")[0].removeprefix("| "), line) for line in table.splitlines()]
    return "\n".join([*lines, *rows.values()]) + "\n"


def _reached(goal: Mapping[str, Any]) -> str:
    if goal["value"] is None:
        return NOT_MEASURED
    value = goal["value"]
    whole = abs(value) < 1e6 and value == round(value)
    number = f"{value:.0f}" if whole else f"{value:.4g}" if value < 1e6 else f"{value:.3g}"
    found = verdict(goal)
    return _with_unit(number, goal) + ("" if found == "met" else f", {found}")


def _with_unit(text: str, goal: Mapping[str, Any]) -> str:
    return text if goal["unit"] in ("1", "") else f"{text} {goal['unit']}"
