# SPDX-License-Identifier: Apache-2.0
"""Inputs that every proof tries: all zero, all at their lower, all at their upper limits, and a
user's points.

A file of points is a table of comma-separated numbers whose first line names inputs and states of
the law. Each line is a tick: numbers as the program takes them, so counts of an encoder. What the
table does not name is 0, or the limit nearest to it; the count before is the count itself.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from asip_asm.diagnostics import closest
from asip_asm.files import read_text
from asip_asm.model.box_search import Input
from asip_asm.model.certificate import inputs_of
from asip_asm.model.exact import Array
from asip_asm.model.law import Law, before
from asip_asm.model.read import ModelError

Tick = tuple[dict[str, Array], dict[str, Array]]
"""Inputs (1,) of a tick, and the states (1,) before it."""
MOST_BYTES = 1 << 22
Point = Mapping[str, float]


def directed(law: Law, points: list[Point] | None = None) -> Iterator[Tick]:
    """All zero (or as near as the limits let it), all low, all high, then the user's points."""
    ranges = [each for each in inputs_of(law) if not each.of]
    zero = {each.name: float(np.clip(0.0, each.low, each.high)) for each in ranges}
    low, high = ({each.name: end(each) for each in ranges} for end in (_low, _high))
    for point in (zero, low, high, *(zero | dict(point) for point in points or ())):
        yield _tick(law, point)


def _low(each: Input) -> float:
    return each.low


def _high(each: Input) -> float:
    return each.high


def _tick(law: Law, point: Point) -> Tick:
    def array(name: str, kind: str) -> Array:
        value = point[name]
        return (
            np.array([round(value)], np.int32) if kind == "int" else np.array([value], np.float32)
        )

    inputs = {port.name: array(port.name, port.type) for port in law.of_kind("input")}
    states = {port.name: array(port.name, port.type) for port in law.of_kind("state")}
    for rate in law.of_kind("rate"):
        states[before(rate.rate_of)] = inputs[rate.rate_of]
    return inputs, states


def load_points(path: Path, law: Law) -> list[Point]:
    """Points of a file. Raises ModelError naming the line, OSError."""
    ranges = {each.name: each for each in inputs_of(law) if not each.of}
    for port in law.of_kind("parameter"):
        ranges.pop(port.name, None)
    rows = csv.reader(read_text(path, MOST_BYTES, "a table of points").splitlines())
    names = [name.strip() for name in next(rows, [])]
    for name in names:
        if name not in ranges or names.count(name) > 1:
            near = closest(name, ranges) or f"inputs and states are {', '.join(ranges)}"
            raise ModelError(f"{path}:1: no input or state '{name}', or named twice; {near}")
    found = [_point(f"{path}:{rows.line_num}", names, row, ranges) for row in rows if row]
    if not found:
        raise ModelError(f"{path}: no points; write names in the first line, numbers in the others")
    return found


def _point(where: str, names: list[str], row: list[str], ranges: Mapping[str, Input]) -> Point:
    if len(row) != len(names):
        raise ModelError(f"{where}: {len(row)} numbers for {len(names)} names")
    found = {}
    for name, text in zip(names, row, strict=True):
        each = ranges[name]
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not each.low <= value <= each.high:
            raise ModelError(
                f"{where}: {name} = {text.strip()[:40]!r} is not a number of its range, "
                f"{each.low:g} to {each.high:g}; change it, or the limits of the signal"
            )
        if each.whole and value != round(value):
            raise ModelError(f"{where}: {name} = {text.strip()[:40]} is no whole number of counts")
        found[name] = value
    return found
