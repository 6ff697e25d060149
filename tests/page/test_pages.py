# SPDX-License-Identifier: Apache-2.0
"""Result pages: what is in them, and what a browser without network makes of them."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import pytest
from rich.table import Table

from sim.bench.run import page
from sim.report.curves import envelope, framed, panels
from sim.report.document import Page
from tests.page.browser import SIZES, Browser
from tests.page.run_example import PEAK_M, RESULTS, shown

ROOT = Path(__file__).resolve().parents[2]
CIRCLE = ROOT / "sim/paths/circle.ngc"
MOST_BYTES = 8_000_000


@pytest.fixture(scope="module")
def browser():
    with Browser() as found:
        yield found


@pytest.fixture(scope="module")
def run_page(tmp_path_factory):
    out = tmp_path_factory.mktemp("page")
    page.write(out, shown(CIRCLE))
    return out / "index.html"


# ---------------------------------------------------------------------- parts


@pytest.mark.parametrize("n", [1, 2, 99, 100, 101, 298_334])
def test_envelope__every_single_peak_is_kept(n):
    rng = np.random.default_rng(n)
    for place in {0, n // 2, n - 1, *rng.integers(0, n, 5).tolist()}:
        for peak in (-9.0, 9.0):
            values = rng.uniform(-1.0, 1.0, n)
            values[place] = peak
            kept = envelope(values, most=100)
            assert place in kept
            assert len(kept) <= 102
            assert (np.diff(kept) > 0).all() and kept[0] == 0 and kept[-1] == n - 1


def test_table__becomes_html__markup_gone__beyond_bound_marked(tmp_path):
    table = Table(title="T [dim]1[/]", caption="What it says & why.")
    table.add_column("name")
    table.add_column("value\\[m]", justify="right")
    table.add_row("ours <b>", "[bold red]2[/]", style="bold")
    table.add_row("theirs", "1", end_section=True)
    built = Page("P", "L")
    built.table(table)
    built.write(tmp_path / "p.html")
    text = (tmp_path / "p.html").read_text()
    assert "<caption>T 1</caption>" in text and "value[m]</th>" in text
    assert '<tr class="ours"><td class="left">ours &lt;b&gt;</td><td class="beyond">2</td>' in text
    assert '<tr class="end">' in text
    assert '<p class="note">What it says &amp; why.</p>' in text
    assert "plotly" not in text  # no figure, no library


# ---------------------------------------------------------------------- the page of the main job


@pytest.mark.quick("phone")
@pytest.mark.parametrize("size", SIZES)
def test_run_page__drawn_without_an_error__fits_the_window(browser, run_page, size):
    seen = browser.look(run_page, size)
    assert seen.errors == []
    assert seen.page["message"] == ""  # of a browser without WebGL
    assert seen.page["figures"] == seen.page["drawn"] == 5
    assert seen.page["webgl"] == 1
    assert seen.page["wide"] == 0
    # A peak of one tick, in the error of the tool as the browser has it.
    largest = browser.evaluate(
        "Math.max(...document.getElementById('figure-3')._fullData[0].y)",
    )
    assert largest == pytest.approx(PEAK_M * 1e6, rel=0.1)
    # The button of the speed shows the second half of the curves instead of the first.
    visible = "document.getElementById('figure-1').data.map(t => t.visible)"
    assert browser.evaluate(visible) == [True] * 3 + [False] * 3
    browser.evaluate(
        "document.querySelectorAll('.updatemenu-button')[1].dispatchEvent(new Event('click'))"
    )
    assert browser.evaluate(visible) == [False] * 3 + [True] * 3


def test_run_page__size_kept__largest_error_told(run_page):
    assert run_page.stat().st_size < MOST_BYTES
    said = re.search(r"<b>([0-9.]+) µm</b>largest distance of the tool", run_page.read_text())
    assert float(said[1]) == pytest.approx(PEAK_M * 1e6, rel=0.1)


def test_run_page__says_what_ran(run_page):
    text = run_page.read_text()
    for said in (
        "sim/paths/circle.ngc",
        "N30 G3 I-30 J0 F2000     ; full turn",
        "sim/robot.toml",
        "sliding mass of one leg (23)",
        "<dt>commit</dt>",
        "<dt>date</dt>",
        "of 100 µs, the rest before",
    ):
        assert said in text


def test_run_page__comparison_beyond_its_bound__said_at_the_top(tmp_path):
    results = RESULTS | {
        "bounds_ok": False,
        "exceeded": [{"in": "nios", "row": "F1", "text": "fpga1: F1 <differs>"}],
        "path": {
            **{"moves": 9, "corners_rounded": 1, "joints_smooth": 2, "stops": 3, "rests_s": 0.5},
            "speed_limited_by": {"feed": 0.75, "jerk": 0.25},
        },
    }
    for name, data in (("bad", results), ("good", results | {"bounds_ok": True, "exceeded": []})):
        (tmp_path / name).mkdir()
        page.write(tmp_path / name, shown(CIRCLE, recorded=False, results=data))
        text = (tmp_path / name / "index.html").read_text()
        assert ("<li>fpga1: F1 &lt;differs&gt;</li>" in text) == (name == "bad")
        assert ("<b>none</b>comparisons beyond" in text) == (name == "good")
    assert "1 corners rounded, 2 smooth, 3 stops; 0.5 s of rests" in text
    assert "feed 75%, jerk 25% of the time" in text


@pytest.mark.quick("400")
@pytest.mark.parametrize("ticks", [1, 400, 501])
def test_run_page__few_ticks__before_and_behind_the_settling(ticks, tmp_path):
    page.write(tmp_path, shown(CIRCLE, most=ticks))
    assert f"{ticks} of 100 µs" in (tmp_path / "index.html").read_text()
    assert (tmp_path / "tracking_errors.png").is_file()


def test_run_page__endless_program__is_cut(tmp_path):
    long = tmp_path / "long.ngc"
    long.write_text(CIRCLE.read_text() + "( x )\n" * 100_000)
    page.write(tmp_path, replace(shown(CIRCLE, recorded=False), gcode=long))
    text = (tmp_path / "index.html").read_text()
    assert "(cut here)</pre>" in text and text.count("( x )") < 40_000


def test_run_page__without_a_whole_run__path_only(tmp_path):
    page.write(tmp_path, shown(CIRCLE, recorded=False))
    text = (tmp_path / "index.html").read_text()
    assert text.count('class="plotly-graph-div"') == 2
    assert not (tmp_path / "forces.png").exists()


def test_pictures__beside_the_page(run_page):
    for name in ("path.png", "tracking_errors.png", "forces.png"):
        assert (run_page.parent / name).stat().st_size > 10_000


# ---------------------------------------------------------------------- the check itself


def curve_page(file: Path, more: str = "") -> Path:
    """A page with one figure, and whatever is put in front of its end."""
    built = Page("P", "L")
    built.figure(panels(np.arange(9.0), [("y", {"one": np.arange(9.0)})]), "C")
    built.write(file)
    file.write_text(file.read_text().replace("</body>", more + "</body>"))
    return file


@pytest.mark.quick("-None", "*planted")
@pytest.mark.parametrize(
    ("planted", "error"),
    [
        ("", None),
        ("<script>undefined_name.call()</script>", "undefined_name is not defined"),
        ("<script>console.error('planted')</script>", "planted"),
        ("<img src='http://127.0.0.1:9/x.png'>", "Content Security Policy"),
        ("<script>fetch('http://127.0.0.1:9/')</script>", "Content Security Policy"),
    ],
)
def test_look__planted_error_is_seen(browser, tmp_path, planted, error):
    seen = browser.look(curve_page(tmp_path / "p.html", planted), "desktop")
    assert bool(seen.errors) == (error is not None)
    if error:
        assert error in " ".join(seen.errors)
    assert seen.page["figures"] == seen.page["drawn"] == 1


@pytest.mark.full
def test_look__figure_without_a_curve_and_wide_part__are_seen(browser, tmp_path):
    built = Page("P", "L")
    built.figure(framed(go.Figure(), 300), "empty")
    built.write(tmp_path / "p.html")
    seen = browser.look(tmp_path / "p.html", "desktop")
    assert (seen.page["figures"], seen.page["drawn"]) == (1, 0)
    wide = "<p style='width: 200vw'>wide</p>"
    assert browser.look(curve_page(tmp_path / "p.html", wide), "phone").page["wide"] == 1
