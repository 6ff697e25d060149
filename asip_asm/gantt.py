# SPDX-License-Identifier: Apache-2.0
"""Chart of a profile as one HTML page without external parts: units over clock cycles."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from html import escape

from asip_asm.profile import Execution, Profile, Wait

CYCLE_WIDTH = 14  # pixels
LANE_HEIGHT = 17
TICK_SPACING = 10  # cycles between labels of the axis

STYLE = """
body { margin: 16px; font: 13px system-ui, sans-serif; background: #fff; color: #222; }
h1 { font-size: 17px; } table { border-collapse: collapse; margin: 8px 24px 16px 0; }
td, th { padding: 1px 10px 1px 0; text-align: right; } td:first-child, th:first-child {
 text-align: left; }
.figures { display: flex; } .scroll { overflow-x: auto; border: 1px solid #bbb; }
.chart { position: relative; } .row { position: relative; border-top: 1px solid #ddd; }
.name { position: sticky; left: 0; z-index: 3; width: 70px; padding: 1px 4px; background: #fffd;
 font-weight: 600; display: inline-block; height: 14px; }
.bar, .cell, .stall, .tick { position: absolute; box-sizing: border-box; overflow: hidden;
 white-space: nowrap; }
.bar { border: 1px solid #0006; border-radius: 3px; font: 10px/14px ui-monospace, monospace;
 padding: 0 2px; color: #111; z-index: 2; }
.cell { background: #789; border: 1px solid #fff; z-index: 2; }
.stall { top: 0; bottom: 0; z-index: 1; opacity: .45; } .tick { border-left: 1px solid #bbb;
 bottom: 0; top: 0; font-size: 10px; color: #555; padding-left: 2px; }
.operand { background: #e45756; } .write-port { background: #b279a2; }
.unit { background: #f58518; } .fetch { background: #72b7b2; } .drain { background: #bab0ac; }
.key { display: inline-block; width: 12px; height: 12px; margin: 0 4px 0 14px; opacity: .45; }
.lit { outline: 3px solid #d00; z-index: 4; } .fed { outline: 3px solid #06c; z-index: 4; }
"""

COLOURS = ("#9ecae9", "#c6dbef", "#ffbf79", "#88d27a", "#f2cf5b", "#d6a5c9", "#ff9d98", "#d8b5a5")

# Pointing at a bar outlines the operations that it reads (red) and those that read it (blue).
SCRIPT = """
const bars = new Map([...document.querySelectorAll('.bar')].map(b => [b.dataset.n, b]));
const readers = new Map();
for (const [n, b] of bars) for (const p of JSON.parse(b.dataset.from))
  readers.set(String(p), [...(readers.get(String(p)) || []), n]);
for (const [n, b] of bars) {
  const mark = on => {
    for (const p of JSON.parse(b.dataset.from)) bars.get(String(p)).classList.toggle('lit', on);
    for (const r of readers.get(n) || []) bars.get(r).classList.toggle('fed', on);
  };
  b.addEventListener('mouseenter', () => mark(true));
  b.addEventListener('mouseleave', () => mark(false));
}
"""


def gantt_page(profile: Profile) -> str:
    """The page: a row of bundles issued, a row per unit with a bar from E1 to W for each operation,
    stripes over the cycles in which nothing issued.
    """
    title = f"{escape(profile.title or 'program')} ({profile.configuration})"
    width = CYCLE_WIDTH * max([profile.cycles, *(e.end for e in profile.executions)])
    rows = [_axis(profile), _issue_row(profile)]
    for i, unit in enumerate(profile.units):
        executions = [e for e in profile.executions if e.unit == unit]
        if executions:
            rows.append(_unit_row(unit, executions, COLOURS[i % len(COLOURS)]))
    keys = "".join(
        f'<span class="key {_class(cause)}"></span>{cause}' for cause in _stalls(profile)
    )
    return "\n".join(
        [
            f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>',
            f"<style>{STYLE}</style></head><body><h1>{title}: {profile.cycles} cycles</h1>",
            f'<div class="figures">{_causes_table(profile)}{_units_table(profile)}</div>',
            f"<p>Each bar is an operation from stage E1 to W. No bundle issued:{keys}</p>",
            f'<div class="scroll"><div class="chart" style="width:{width}px">',
            *(_stall(profile, wait) for wait in profile.waits),
            *rows,
            f"</div></div><script>{SCRIPT}</script></body></html>\n",
        ]
    )


def lanes(executions: Iterable[Execution]) -> list[list[Execution]]:
    """Executions of a unit in as few lanes as no two of a lane overlap."""
    result: list[list[Execution]] = []
    for execution in sorted(executions, key=lambda e: (e.start, e.number)):
        lane = next((lane for lane in result if lane[-1].end <= execution.start), None)
        if lane is None:
            result.append([execution])
        else:
            lane.append(execution)
    return result


def tooltip(execution: Execution) -> str:
    """Everything about an operation, on several lines."""
    rows = [execution.text, execution.where]
    rows += [f"equation ({execution.equation})"] if execution.equation else []
    waited = execution.issue - execution.decode
    rows.append(
        f"bundle {execution.address}, issued in cycle {execution.issue}"
        + (f" after waiting {waited}" if waited else "")
    )
    rows.append(f"E1 in cycle {execution.start}, ends with cycle {execution.end - 1}")
    if execution.word is not None:
        rows.append(f"{execution.target} = {execution.word:08x}")
    return "\n".join(rows)


def _axis(profile: Profile) -> str:
    ticks = "".join(
        f'<div class="tick" style="left:{CYCLE_WIDTH * cycle}px">{cycle}</div>'
        for cycle in range(0, profile.cycles, TICK_SPACING)
    )
    return f'<div class="row" style="height:{LANE_HEIGHT}px">{ticks}</div>'


def _issue_row(profile: Profile) -> str:
    cells = "".join(
        f'<div class="cell" style="{_box(cycle, cycle + 1, 1)}" '
        f'title="bundle {address}, cycle {cycle}"></div>'
        for cycle, address in profile.issues
    )
    return _row("issue", 1, cells)


def _unit_row(unit: str, executions: Sequence[Execution], colour: str) -> str:
    stacked = lanes(executions)
    bars = "".join(
        _bar(execution, level, colour)
        for level, lane in enumerate(stacked, 1)
        for execution in lane
    )
    return _row(unit, len(stacked), bars)


def _row(name: str, levels: int, content: str) -> str:
    height = LANE_HEIGHT * (levels + 1)  # the name is above the bars
    return (
        f'<div class="row" style="height:{height}px"><span class="name">{escape(name)}</span>'
        f"{content}</div>"
    )


def _bar(execution: Execution, level: int, colour: str) -> str:
    return (
        f'<div class="bar" data-n="{execution.number}" '
        f'data-from="{json.dumps(execution.producers)}" '
        f'style="{_box(execution.start, execution.end, level)};background:{colour}" '
        f'title="{escape(tooltip(execution))}">{escape(execution.text)}</div>\n'
    )


def _box(start: int, end: int, level: int) -> str:
    return (
        f"left:{CYCLE_WIDTH * start}px;width:{CYCLE_WIDTH * (end - start)}px;"
        f"top:{LANE_HEIGHT * level}px;height:{LANE_HEIGHT - 1}px"
    )


def _stall(profile: Profile, wait: Wait) -> str:
    style = f"left:{CYCLE_WIDTH * wait.cycle}px;width:{CYCLE_WIDTH * wait.cycles}px"
    text = escape(profile.describe(wait).strip())
    return f'<div class="stall {_class(wait.cause)}" style="{style}" title="{text}"></div>'


def _stalls(profile: Profile) -> list[str]:
    return [cause for cause, cycles in profile.causes.items() if cause != "issue" and cycles]


def _class(cause: str) -> str:
    return cause.replace(" ", "-")


def _causes_table(profile: Profile) -> str:
    rows = [(cause, str(n), _share(n, profile)) for cause, n in profile.causes.items()]
    return _table(("cycles", "", "share"), rows)


def _units_table(profile: Profile) -> str:
    rows = [(n, str(u.operations), _share(u.busy, profile)) for n, u in profile.units.items()]
    return _table(("unit", "operations", "busy"), rows)


def _share(cycles: int, profile: Profile) -> str:
    return f"{100.0 * cycles / profile.cycles:.1f} %"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    def row(cells: Iterable[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    return "<table>" + row(head, "th") + "".join(row(cells, "td") for cells in rows) + "</table>"
