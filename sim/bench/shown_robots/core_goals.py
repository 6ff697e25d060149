# SPDX-License-Identifier: Apache-2.0
"""Goals of the core's area and clock, as `microtick synth` measured them, with the commit.

A row is not met where the figure is missing, or where a module of the core is not that of
the commit any more, or where a clock is the median of fewer than five seeds.
"""

from __future__ import annotations

import operator
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sim.bench.run.tables import synthesised
from sim.report.goals import Goal
from sim.rtl.figures import is_present

ROWS = (
    # top, name, field, unit, target, what is met
    ("asip_fast", "core fast, logic", "aluts", "ALUTs", 12_010, operator.le),
    ("asip_fast", "core fast, registers", "registers", "registers", 7_489, operator.le),
    ("asip_fast", "core fast, multipliers", "dsp_18x18", "elements", 8, operator.le),
    ("asip_fast", "core fast, clock", "fmax_mhz", "MHz", 125, operator.ge),
    ("asip_small", "core small, logic", "aluts", "ALUTs", 5_000, operator.le),
    ("asip_small", "core small, clock", "fmax_mhz", "MHz", 102, operator.ge),
)
SEEDS = 5
"""Runs of place and route that the median of a clock needs at least."""


@dataclass(frozen=True)
class Figure:
    """A measured figure of a core. value: None where nothing measured it. valid: it is of the core
    as it is, and the median of enough seeds where it is a clock."""

    value: float | None
    valid: bool
    note: str


def figure(document: Mapping[str, Any], top: str, field: str) -> Figure:
    """A field of `microtick synth` of a top. document: of build/synth.json."""
    figures = document.get("tops", {}).get(top, {})
    value, commit = figures.get(field), figures.get("commit", "")
    note, enough = f"measured at commit {commit}", True
    if isinstance(value, Mapping):
        runs = _runs(value)
        value, enough = value.get("median"), runs >= SEEDS
        if not enough:
            note += f", with {runs} seeds of {SEEDS}"
    if value is None:
        return Figure(None, False, "not measured; microtick synth measures it")
    current = is_present(top, figures)
    if not current:
        note += ", the core is another one now; microtick synth measures it"
    return Figure(value, current and enough, note)


def core_goals(document: Mapping[str, Any] | None = None) -> list[Goal]:
    """Goals of build/shown_robots.json, not met where nothing counts as measured.

    document: of build/synth.json, None: as `make run` finds it.
    """
    document = synthesised() if document is None else document
    found = []
    for top, name, field, unit, target, meets in ROWS:
        own = figure(document, top, field)
        met = own.valid and own.value is not None and meets(own.value, target)
        text = f"{'<=' if meets is operator.le else '>='} {target}"
        found.append(Goal(name, own.value, unit, text, met, own.note))
    return found


def _runs(clock: Mapping[str, Any]) -> int:
    """Seeds of a clock: their number in docs/data/synthesis.json, each in build/synth.json."""
    return clock["runs"] if "runs" in clock else len(clock.get("seeds", ()))
