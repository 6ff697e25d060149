# SPDX-License-Identifier: Apache-2.0
"""Comparisons beyond their bounds mark their rows, and a wrong program ends with status 3."""

import dataclasses
import json
from pathlib import Path

import pytest
from rich.console import Console

from asip_asm.assemble import assemble
from sim.bench.run import __main__ as command
from sim.bench.run import checks, tables
from sim.bench.run import job as main_job
from sim.robot.parameters import Robot
from sim.robot.records import OUTPUTS

AGH = Path("sim/paths/agh.ngc")
KEPT = {"leg": 9e-7, "tool": 4e-6, "table": 4e-5}


def nios(platform, words, tau4):
    """Part of the results: ticks with other words than the PC's by row, and tau4 by its limit."""
    found = {"words_other_than_pc_float32": words, "tau4_to_pc_of_limit": tau4}
    return {"nios": {platform: found}}


def results(**changes):
    """Results that keep everything, except for what a test changes."""
    data = {
        "worst_fraction_of_bound": {"optimised": dict.fromkeys(OUTPUTS, 1.0)},
        **nios("fpga1", {}, 1.0),
        "tracking": {"max_leg_error_m": 1.0, "optimised": dict(KEPT)},
    }
    return data | changes


def entered(data, robot=None, gcode=AGH):
    checks.enter(data, checks.is_published(robot or Robot.load(), gcode))
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
            nios("fpga2", {"v3": 7, "tau4": 9}, 0.5),
            "fpga2: v3 differs from the PC's float32 in 7 ticks",
        ),
        (
            nios("fpga2", {"tau4": 9}, 1.01),
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


# ---------------------------------------------------------------------- the whole job


@pytest.fixture
def other_robot(tmp_path):
    """A robot file with another mass and control period."""
    text = Path("sim/robot.toml").read_text(encoding="utf-8")
    text = text.replace("[m_s]\nvalue = 12.0", "[m_s]\nvalue = 15.0")
    text = text.replace("[T_s]\nvalue = 1e-4", "[T_s]\nvalue = 2e-4")
    path = tmp_path / "my robot.toml"
    path.write_text(text, encoding="utf-8")
    return path


def job(folder, *arguments):
    """Exit status and results.json of a short run."""
    words = [str(AGH), "--ticks", "60", "--no-plots", "--output", str(folder), *arguments]
    status = command.main(words)
    return status, json.loads((folder / "results.json").read_text(encoding="utf-8"))


def test_job__another_robot_file__acts_without_a_generator(other_robot, tmp_path):
    status, data = job(tmp_path, "--robot", str(other_robot), "--platforms", "fpga3")
    assert status == 0 and data["bounds_ok"] is True
    assert data["robot"]["file"] == str(other_robot)
    assert data["robot"]["values"]["m_s"] == 15.0 and data["robot"]["values"]["T_s"] == 2e-4
    assert set(data["worst_fraction_of_bound"]) == {"as_printed", "optimised"}


def test_job__a_wrong_constant_in_the_programs__is_status_3(tmp_path, monkeypatch, capsys):
    def wrong(source, **options):
        mass = options["defines"]["m_s"]
        return assemble(source, **options | {"defines": options["defines"] | {"m_s": 2.0 * mass}})

    monkeypatch.setattr(main_job, "assemble", wrong)
    status, data = job(tmp_path, "--platforms", "fpga3")
    assert status == 3 and data["bounds_ok"] is False
    rows = {entry["row"] for entry in data["exceeded"]}
    assert rows == {"as_printed", "optimised"}
    said = capsys.readouterr().out
    assert "EXCEEDED" in said and "error: optimised: error of F1 is" in said
