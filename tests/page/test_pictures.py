# SPDX-License-Identifier: Apache-2.0
"""Matplotlib figures become interactive ones with the same curves, axes and titles."""

import numpy as np
import pytest

from sim.report import pictures
from sim.report.document import Page
from tests.page.browser import Browser


@pytest.fixture
def figure():
    """Every kind of curve that the figures of `microtick motion` have."""
    plt = pictures.pyplot("test")
    made = plt.figure(figsize=(8, 6))
    grid = made.add_gridspec(2, 2)
    left, right = made.add_subplot(grid[0, 0]), made.add_subplot(grid[0, 1])
    below = made.add_subplot(grid[1, :])
    x = np.linspace(0.0, 1.0, 20_000)
    y = np.sin(9 * x)
    y[12_345] = 7.0  # a peak of one point
    left.plot(x, y, "k--", label="curve")
    left.axhline(0.5, color="0.5")
    left.eventplot([0.1, 0.2, 0.4], lineoffsets=0.5)
    left.set(title="a title that is too long for one line of a telephone", xlabel="x [m]")
    right.plot([0, 1], [0, 1], "r.", label="dots")
    right.set(aspect="equal", xlim=(-1, 3))
    below.hist([1, 1, 1, 2, 3], bins=3, histtype="step", label="steps")
    below.set(yscale="log", ylabel="ticks")
    return made


def test_interactive__curves_axes_and_titles_as_drawn(figure):
    made = pictures.interactive(figure)
    curves = {trace.name: trace for trace in made.data if trace.name}
    assert set(curves) == {"curve", "dots", "steps"}
    assert max(curves["curve"].y) == 7.0 and len(curves["curve"].x) <= pictures.POINTS + 2
    assert curves["curve"].line.dash == "dash" and curves["dots"].mode == "markers"
    level, events = (trace for trace in made.data if not trace.name)
    assert list(level.y) == [0.5, 0.5] and len(events.x) == 9
    assert "<br>" in made.layout.annotations[0].text
    assert made.layout.yaxis2.scaleanchor == "x2" and list(made.layout.xaxis2.range) == [-1, 3]
    assert made.layout.yaxis3.type == "log" and made.layout.yaxis3.title.text == "ticks"
    assert max(curves["steps"].y) == 3
    assert pictures.least_width(made) == 2 * pictures.COLUMN_WIDTH


@pytest.mark.full
def test_save__three_files__the_interactive_one_is_drawn_by_a_browser(figure, tmp_path):
    file = tmp_path / "figure.svg"
    pictures.save(figure, file)
    assert file.is_file() and file.with_suffix(".png").is_file()
    assert pictures.load(tmp_path / "other.svg") is None
    page = Page("P", "L")
    page.figure(pictures.load(file), "C", least_width=640)
    page.write(tmp_path / "p.html")
    with Browser() as browser:
        seen = browser.look(tmp_path / "p.html", "phone", tmp_path / "seen.png")
    assert seen.errors == [] and seen.page["wide"] == 0
    assert seen.page["figures"] == seen.page["drawn"] == 1
