# SPDX-License-Identifier: Apache-2.0
"""The robot's closed loop with the RTL core as the scope sees it, without and with a browser."""

from __future__ import annotations

import base64
import csv
import io
import struct

import numpy as np
import pytest
from rich.console import Console

from sim.debug.packets import line_bits
from sim.debug.scope.process import ScopeProcess
from sim.debug.scope.source import VERSION, Block, Commit, End, Event, Pace, SourceError, Step
from sim.debug.scope.tap import TapSource
from sim.robot.records import COUNTS, OUTPUTS, SetPoints
from tests.page.browser import Browser
from tests.scope.robot_loop import ROBOT, Loop, described, path

STEP_TICKS = 1500
LIMIT = 120.0  # s, guard against a hang


def started(wanted: SetPoints) -> tuple[TapSource, Loop]:
    """A scope's source and the loop of a path, which waits for it."""
    source = TapSource(*described(wanted))
    loop = Loop(wanted, source.place)
    loop.start()
    return source, loop


def watch(source: TapSource) -> tuple[list[Event], np.ndarray, int]:
    """All events of a loop until its end; values of all ticks, and the first one's number."""
    source.send(Pace(paused=False))
    events: list[Event] = []
    while not (events and isinstance(events[-1], End)):
        events.append(source.wait())
    source.close()
    blocks = [event for event in events if isinstance(event, Block)]
    return events, np.concatenate([block.values for block in blocks]), blocks[0].first


def test_watched_loop__same_bits_as_alone__and_the_scope_has_every_tick():
    wanted = path(500, reach=0.02)
    alone = Loop(wanted, None)
    alone.run()
    source, loop = started(wanted)
    about = source.description
    _, values, first = watch(source)
    loop.join(LIMIT)
    assert (first, len(values), loop.touched) == (0, 500, ())
    for name in ("outputs", "exported", "cycles"):
        got, want = (getattr(run.recording.ticks, name) for run in (loop, alone))
        assert got.tobytes() == want.tobytes(), name
    columns = {name: values[:, k] for k, name in enumerate(about.names)}
    outputs = np.stack([columns[name] for name in OUTPUTS], axis=1)
    assert np.array_equal(outputs, alone.recording.ticks.outputs)
    assert np.array_equal(np.stack([columns[n] for n in COUNTS], axis=1), alone.recording.counts)
    assert np.array_equal(columns["x"], wanted.position[:, 0].astype(np.float32))
    assert np.array_equal(columns["dev_y"], alone.recording.tool[:, 1] - wanted.position[:, 1])
    # A state of the program: the encoder count that it keeps for the next tick.
    assert np.array_equal(columns["count1_before"], columns["count1"])
    assert np.array_equal(columns["cycles"], alone.recording.ticks.cycles)
    # Eight of these signals fit on a serial line of 3 Mbit/s at 10 kHz: 300 bits a record.
    ticks = alone.recording.ticks
    eight = np.hstack([ticks.outputs, ticks.exported])[:, :8].astype(np.float32)
    assert eight.shape == (500, 8) and line_bits(eight.view(np.uint32).tolist()) < 300


def test_commit__changes_all_words_between_two_ticks():
    wanted = path(3000)
    source, loop = started(wanted)
    about = source.description
    source.send(Commit(1, {"f_table": 15.0, "KV_legs": 600.0}))
    source.send(Step("gamma", 1e-3, 1000))
    events, values, _ = watch(source)
    loop.join(LIMIT)
    applied, stepped = [e for e in events if not isinstance(e, Block | End)]
    versions = values[:, about.names.index(VERSION)]
    assert np.array_equal(versions, (np.arange(3000) >= applied.tick).astype(float))
    assert applied.values["KP_table"] == pytest.approx(3 * (2 * np.pi * 15.0) ** 2, rel=1e-6)
    assert applied.values["KV_legs"] == 600.0 and applied.values["f_table"] == 15.0
    gamma = values[:, about.names.index("gamma")]
    on = np.flatnonzero(gamma)
    assert on.tolist() == list(range(stepped.tick, stepped.tick + 1000))
    assert [entry.split(": ")[1] for entry in loop.touched] == [
        "f_table = 15, KV_legs = 600",
        "step of 0.001 on gamma",
    ]


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"f_table": 1e3}, "f_table = 1000.0: must be <= 200 Hz"),
        ({"f_legs": -1.0}, "f_legs = -1.0 Hz: must be within 0.1 .. 1000 Hz"),
        ({"F_max": 1.0}, "F_max = 1.0: must be >"),
        ({"KP_legs": 1e39}, "KP_legs = 1e\\+39 is too large for binary32"),
        ({"f_table": 30.0}, "with f_table = 30 the program itself is another one"),
    ],
)
def test_gain_that_cannot_be__is_refused_with_the_reason(values, said):
    source = TapSource(*described(path(1)))
    with pytest.raises(SourceError, match=said):
        source.check(values)
    source.close()


def test_parameter__takes_its_constants_back():
    _, tuner = described(path(1))
    assert tuner.commit({"KP_table": 1.0, "KV_table": 2.0}).values["KP_table"] == 1.0
    after = tuner.commit({"f_table": 20.0, "KV_table": 3.0}).values
    assert after["KP_table"] == pytest.approx(3 * (2 * np.pi * 20) ** 2, rel=1e-6)
    assert after["KV_table"] == 3.0  # of the same commit


def test_scope_that_goes_away__leaves_the_loop_running():
    source, loop = started(path(600))
    source.send(Pace(paused=False))
    source.wait()
    source.close()
    loop.join(LIMIT)
    assert len(loop.recording.counts) == 600


# ---------------------------------------------------------------------- in the browser


def textbook(f: float) -> tuple[float, float]:
    """Overshoot and rise time [s] of the loop that (28) and (36) make with a rigid axis: set-point
    to position (K_P s + K_I)/(s^3 + K_V s^2 + K_P s + K_I), gains as in `Robot`."""
    from scipy import signal

    w = 2 * np.pi * f
    time = np.arange(STEP_TICKS) * ROBOT.T_s
    _, y = signal.step(([3 * w**2, w**3], [1, 3 * w, 3 * w**2, w**3]), T=time)
    rise = np.interp([0.1, 0.9], y[: y.argmax()], time[: y.argmax()])
    return y.max() - 1.0, rise[1] - rise[0]


def set_field(browser: Browser, selector: str, value: object, event: str = "change") -> None:
    told = f"f.dispatchEvent(new Event('{event}', {{bubbles: true}}))"
    browser.evaluate(
        f"(f => {{ f.value = '{value}'; {told}; }})(document.querySelector('{selector}'))"
    )


def step_figures(browser: Browser, number: int) -> dict:
    """Press Step on the page; the figures that come."""
    set_field(browser, "#step-input", "gamma")
    set_field(browser, "#step-ticks", STEP_TICKS)
    browser.evaluate("document.querySelector('#step button').click()")
    browser.until(f"state.responses.length === {number}")
    return browser.evaluate("state.responses[state.responses.length - 1]")


def test_page__data_move__a_gain_changes_the_response__a_fault_fills_the_black_box():
    wanted = path(60_000)
    about, tuner = described(wanted)
    with ScopeProcess(TapSource(about, tuner), Console(quiet=True)) as scope, Browser() as browser:
        loop = Loop(wanted, scope.source.place)
        loop.start()
        browser.open(scope.url, "desktop")
        browser.until("typeof drawn !== 'undefined' && drawn > 1 && state.tick > 0")
        set_field(browser, "#rate", 0.1)  # the path lasts a minute at least
        browser.until("state.rate === 1000")
        before = browser.evaluate("state.tick")
        browser.until(f"state.tick > {before}")
        assert browser.evaluate("document.getElementById('status').textContent") == "running"
        assert (
            browser.until("document.querySelectorAll('#curves .scatterlayer .js-line').length")
            == 10
        )
        assert browser.until("document.querySelector('#robot .gl-container canvas') !== null")

        # the response with the gains of the file, and after a change without a stop
        first = step_figures(browser, 1)
        set_field(browser, "tr[data-gain=f_table] input", 20)
        browser.until("state.staged.f_table === 20")
        browser.evaluate("document.getElementById('commit').click()")
        browser.until("state.version === 1")
        shown = "document.querySelector('tr[data-gain=f_table]').children[1].textContent"
        browser.until(f"{shown} === '20'")
        second = step_figures(browser, 2)
        assert (first["version"], second["version"]) == (0, 1)
        for f, response in ((10.0, first), (20.0, second)):
            overshoot, rise = textbook(f)
            assert response["figures"]["overshoot"] == pytest.approx(overshoot, abs=0.01)
            assert response["figures"]["rise"] == pytest.approx(rise, rel=0.03)
        text = browser.evaluate("document.getElementById('figures').textContent")
        assert f"{first['figures']['overshoot'] * 100:.3f}"[:4] in text

        # a refusal is reported, nothing changes
        set_field(browser, "tr[data-gain=f_table] input", 500)
        browser.until(
            "document.getElementById('message').textContent.includes('must be <= 200 Hz')"
        )
        assert browser.evaluate("state.gains.f_table") == 20

        # hold and go on
        browser.evaluate("document.getElementById('pause').click()")
        browser.until("state.paused")
        browser.until("document.getElementById('status').textContent === 'paused'")
        browser.evaluate("document.getElementById('pause').click()")
        browser.until("!state.paused")

        # a sensor breaks
        browser.evaluate("document.querySelector('#channels input[value=x]').click()")
        set_field(browser, "#put-input", "x")
        browser.evaluate("document.querySelector('#put button').click()")
        browser.until("!document.getElementById('fault').hidden")
        text = browser.evaluate("document.getElementById('fault-text').textContent")
        assert "NOT_FINITE" in text and "tracking_law.inc:" in text
        cells = "[...document.querySelectorAll('#last-ticks tr')].map(r => r.lastChild.textContent)"
        browser.until(f"{cells}.includes('nan')")
        browser.until("lastFrame.kind === 'blackbox'")
        loop.join(LIMIT)
        assert loop.stopped == f"tick {browser.evaluate('state.fault.tick')}: " + (
            "the core stopped with fault NOT_FINITE"
        )

        # what was seen leaves the page
        link = browser.evaluate("fetch('export/blackbox.csv').then(answer => answer.text())")
        head, *lines = csv.reader(io.StringIO(link))
        assert (
            lines[-1][head.index("x [m]")] == "nan" and float(lines[-2][head.index("x [m]")]) == 0
        )
        assert int(lines[-1][0]) == browser.evaluate("state.fault.tick")
        picture = base64.b64decode(browser.evaluate("picture()").partition(",")[2])
        assert picture[:8] == b"\x89PNG\r\n\x1a\n"
        assert min(struct.unpack(">II", picture[16:24])) > 300
        assert browser.errors == []
        browser.open("about:blank", "desktop")
