# SPDX-License-Identifier: Apache-2.0
"""The table of goals that a measured page shows, and text between a page's marks."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any


def goal_table(goals: Sequence[Mapping[str, Any]]) -> str:
    """Markdown of goals {name, value, unit, target, met}; a value None was not measured."""
    head = "| what | reached | target |\n| --- | --- | --- |\n"
    return head + "".join(
        f"| {goal['name']} | {_value(goal)} | {goal['target']:g} {_unit(goal)}|\n" for goal in goals
    )


def marked(name: str) -> re.Pattern[str]:
    """Finds `<!-- name: written by ... -->`, what it writes, `<!-- end of name -->`."""
    return re.compile(rf"(<!-- {name}: [^\n]*-->\n).*?(<!-- end of {name} -->)", re.S)


def between_marks(page: str, texts: Mapping[str, str], file: str) -> str:
    """A page with these texts by name of their marks. Raises ValueError for marks it has not."""
    for name, text in texts.items():
        page, count = marked(name).subn(lambda found, text=text: found[1] + text + found[2], page)
        if count != 1:
            raise ValueError(f"{file} has lost its marks: restore `<!-- {name}: ... -->`")
    return page


def _unit(goal: Mapping[str, Any]) -> str:
    return "" if goal["unit"] in ("1", "") else goal["unit"] + " "


def _value(goal: Mapping[str, Any]) -> str:
    if goal["value"] is None:
        return "not measured"
    number = f"{goal['value']:.4g}" if goal["value"] < 1e6 else f"{goal['value']:.3g}"
    return f"{number} {_unit(goal)}".strip() + ("" if goal["met"] else ", missed")
