# SPDX-License-Identifier: Apache-2.0
"""Rows of `make workbench`: what was measured, and what it is to reach."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """A goal. value: as measured, None where it could not be; target: in words, as '<= 1500'."""

    name: str
    value: float | None
    unit: str
    target: str
    met: bool
    note: str = ""


def at_most(name: str, value: float, limit: float, unit: str, note: str = "") -> Row:
    """A row whose value may not exceed a limit."""
    return Row(name, value, unit, f"<= {limit:g}", value <= limit, note)


def at_least(name: str, value: float, limit: float, unit: str, note: str = "") -> Row:
    """A row whose value has to reach a limit, such as the depth of a campaign."""
    return Row(name, value, unit, f">= {limit:g}", value >= limit, note)


def exactly(name: str, value: float, wanted: float, unit: str, note: str = "") -> Row:
    """A row whose value has to be one number."""
    return Row(name, value, unit, f"{wanted:g}", value == wanted, note)
