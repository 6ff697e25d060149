# SPDX-License-Identifier: Apache-2.0
"""Comparisons beyond their bounds mark their rows, and a wrong program ends with status 3."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from rich.console import Console

from sim.model.parameters import Robot
from sim.model.records import OUTPUTS
from sim.run import checks, tables

AGH = Path("sim/paths/agh.ngc")
KEPT = {"leg": 9e-7, "tool": 4e-6, "table": 4e-5}


def results(**changes):
    """Results that keep everything, but for what a test changes."""
    data = {
        "worst_fraction_of_bound": {"optimised": dict.fromkeys(OUTPUTS, 1.0)},
        "nios": {"fpga1": {"words_other_than_pc_float32": {}, "tau4_to_pc_of_limit": 1.0}},
        "tracking": {"max_leg_error_m": 1.0, "optimised": dict(KEPT)},
    }
    return data | changes


def entered(data, robot=None, gcode=AGH):
    checks.enter(data, robot or Robot.load(), gcode)
    return data


def test_bounds__all_kept__are_ok():
    data = entered(results())
    assert data["bounds_ok"] is True and data["exceeded"] == []


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (
            {"worst_fraction_of_bound": {"optimised": dict.fromkeys(OUTPUTS, 1.0) | {"F2": 1.5}}},
            "optimised: error of F2 is 1.5 of its bound",
        ),
        (
            {"worst_fraction_of_bound": {"fpga1": {"tau5": float("nan")}}},
            "fpga1: error of tau5 is nan of its bound",
        ),
        (
            {
                "nios": {
                    "fpga2": {
                        "words_other_than_pc_float32": {"v3": 7, "tau4": 9},
                        "tau4_to_pc_of_limit": 0.5,
                    }
                }
            },
            "fpga2: v3 differs from the PC's float32 in 7 ticks",
        ),
        (
            {
                "nios": {
                    "fpga2": {
                        "words_other_than_pc_float32": {"tau4": 9},
                        "tau4_to_pc_of_limit": 1.01,
                    }
                }
            },
            "fpga2: tau4 differs by more than the sine's last bit",
        ),
        (
            {"tracking": {"as_printed": KEPT | {"tool": 6e-6}}},
            "as_printed: tracking error of tool 6e-06, target 5e-06",
        ),
    ],
)
def test_bounds__one_exceeded__is_told_and_marked(change, text):
    data = entered(results(**change))
    assert data["bounds_ok"] is False
    assert [entry["text"] for entry in data["exceeded"]] == [text]
    entry = data["exceeded"][0]
    assert checks.is_marked(data, entry["in"], entry["row"])
    assert not checks.is_marked(data, entry["in"], "another row")


def test_targets__another_robot_or_path__have_none():
    lame = {"tracking": {"optimised": KEPT | {"leg": 1.0}}}
    other = dataclasses.replace(Robot.load(), m_s=15.0)
    assert entered(results(**lame), robot=other)["bounds_ok"]
    assert entered(results(**lame), gcode=Path("circle.ngc"))["bounds_ok"]
    assert not entered(results(**lame))["bounds_ok"]


def test_table_of_bounds__row_beyond_its_bound__says_so(capsys):
    fractions = dict.fromkeys(OUTPUTS, 0.5)
    data = entered(
        results(
            worst_fraction_of_bound={"as_printed": fractions, "optimised": {**fractions, "F1": 2}}
        )
    )
    Console(width=120).print(tables.bound_table(data))
    marked = [line for line in capsys.readouterr().out.splitlines() if "EXCEEDED" in line]
    assert len(marked) == 1 and "optimised" in marked[0]
