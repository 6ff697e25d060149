# SPDX-License-Identifier: Apache-2.0
"""The command `microtick motion`: table, page and results; the front-end RTL on a short move."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, replace
from fractions import Fraction
from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from sim.bench.motion import show, show_page, show_rtl
from sim.motion.planner import figures as planner_figures
from sim.motion.planner.ramp_time import ramp_time_plan
from sim.report.pictures import load
from sim.rtl.motion_rtl import MotionError
from tests.bench.needs import find
from tests.page.browser import SIZES, Browser

QUICK = {"v0": "30", "vm": "200", "tr": "0.02", "tm": "0.005", "length": "8"}


@pytest.mark.full
def test_quick_show__table_page_and_results_of_every_present_module(tmp_path, capsys):
    arguments = ["--no-rtl", "--no-robot", "--output", str(tmp_path)]
    assert show.main(arguments) == 0
    printed = capsys.readouterr().out
    document = json.loads((tmp_path / "results.json").read_text())
    rows = document["figures"]
    assert {"CNC", "S-curve"} <= {row["paper"] for row in rows}
    assert {"3", "11a", "11b", "11c", "12", "15", "table"} <= {row["figure"] for row in rows}
    for name in show.FIGURES:
        assert f"{name}: " in printed
    html = (tmp_path / "index.html").read_text()
    for file in {row["file"] for row in rows}:
        assert (tmp_path / file).is_file() and (tmp_path / file).with_suffix(".png").is_file()
        assert any(file in part.pictures for part in show_page.PARTS)
    pictures = sum(load(tmp_path / f) is not None for p in show_page.PARTS for f in p.pictures)
    assert html.rindex("<figure>") < html.index("<table")  # pictures first
    if find("chromium") or os.environ.get("CI") == "true":
        with Browser() as browser:
            for size in SIZES:
                seen = browser.look(tmp_path / "index.html", size)
                assert seen.errors == [] and seen.page["wide"] == 0
                assert seen.page["figures"] == seen.page["drawn"] == pictures
    differ = [row["name"] for row in rows if not row["agrees"]]
    assert f"{len(rows)} figures, {len(differ)} differ" in printed


def test_output_that_is_a_file__error_and_exit_code_1(tmp_path, capsys):
    file = tmp_path / "taken"
    file.write_text("")
    assert show.main(["--no-rtl", "--no-robot", "--output", str(file)]) == 1
    assert "error: " in capsys.readouterr().err


def test_figure_module_of_another_form__refused_by_name():
    @dataclass
    class Short:
        figure: str
        ours: float

    with pytest.raises(show.ShowError, match=r"lookahead\.figures: .* no agrees, file, name"):
        show.rows_of("lookahead", [Short("4", 1.0)])


def test_lookahead_document__becomes_rows__apex_beyond_p_differs():
    times = {"jerk limited": 5.46, "steps of acceleration": 5.51}
    blended = {"jerk limited": 1.51, "steps of acceleration": 1.5}
    corners = [
        {"P [mm]": 0.001, "apex of the set-points [mm]": 0.00099},
        {"P [mm]": 0.005, "apex of the set-points [mm]": 0.0051},
    ]
    document = {
        "figures 4 and 5": {"without blending [s]": times, "with blending [s]": blended},
        "figure 6": corners,
    }
    rows = show.rows_of("lookahead", document)
    # Each time and apex next to the paper's and LinuxCNC's: 5.51 s and 5.1 um are beyond the
    # paper's (and LinuxCNC's time), 5.1 um is within LinuxCNC's apex.
    assert [row["agrees"] for row in rows] == [
        *(False, False, True),
        *(True, True, True),
        *(True, True),
        *(False, True),
    ]
    assert {row["paper"] for row in rows} == {"CNC"}
    with pytest.raises(show.ShowError, match="lookahead.figures: .* no 'figure 6'"):
        show.rows_of("lookahead", {"figures 4 and 5": document["figures 4 and 5"]})


def test_a_figure_that_differs__is_shown_as_such():
    good = planner_figures.Result("3", "x", "mm", "1", "stated", 1.0, True, "scurve_fig3.svg")
    rows = show.rows_of("test", [good, replace(good, ours=2.0, agrees=False)])
    text = StringIO()
    Console(file=text, width=100).print(show.table_of(rows))
    assert "S-curve 3" in text.getvalue() and "x [mm]" in text.getvalue()
    assert text.getvalue().count("DIFFERS") == 1 == text.getvalue().count("agrees")


# ---------------------------------------------------------------------- front-end RTL


@pytest.fixture
def quick(monkeypatch):
    """A move of 60 ms in the place of the paper's."""
    monkeypatch.setattr(show_rtl, "FIGURE_12", QUICK)
    return ramp_time_plan(**QUICK)


@pytest.mark.full
@pytest.mark.parametrize("mode", show_rtl.MODES)
def test_rtl_run__all_pulses__progress_adds_up_to_the_duration(quick, monkeypatch, mode):
    monkeypatch.setattr(show_rtl, "CHUNK", 1_000_000)
    ticks = []
    move = show_rtl.run(mode, ticks.append)
    assert len(move.pulses) == quick.length * show_rtl.PULSES_PER_MM
    assert len(ticks) > 3
    assert sum(ticks) == pytest.approx(move.seconds * 1e6, abs=5)
    exact = abs(move.seconds - float(quick.total_time)) < 5e-6
    assert exact == (mode == "time-exact")


def test_rtl_move_that_never_ends__motion_error(quick, monkeypatch):
    monkeypatch.setattr(show_rtl, "ticks", lambda: 1_000)
    monkeypatch.setattr(show_rtl, "CHUNK", 1_000_000)
    with pytest.raises(MotionError, match="no interrupt"):
        show_rtl.run("time-exact")


def test_last_speed_of_the_plan__of_a_constant_speed__is_that_speed():
    plan = ramp_time_plan("20", "20", "0.1", "0", "3")
    assert show_rtl.last_speed_of_plan(plan) == pytest.approx(20.0, rel=1e-9)


def test_rtl_results__wrong_count_or_time__differ():
    plan = show_rtl.figure_12()
    count = int(plan.length * show_rtl.PULSES_PER_MM)
    step = 1.0 / (show_rtl.last_speed_of_plan(plan) * show_rtl.PULSES_PER_MM)
    pulses = np.arange(count) * step
    right = show_rtl.Move(float(plan.total_time), pulses)
    assert all(result.agrees for result in show_rtl.results({"time-exact": right}))
    wrong = show_rtl.Move(float(plan.total_time + Fraction(1, 5000)), pulses[:-1] * 1.01)
    assert not any(result.agrees for result in show_rtl.results({"time-exact": wrong}))
