# SPDX-License-Identifier: Apache-2.0
"""Parts of the scope without a server: ring, trigger, step response, session, exports."""

from __future__ import annotations

import csv
import io
import json

import jsonschema
import msgspec
import numpy as np
import pyarrow.parquet
import pytest
from mcap.reader import make_reader

from sim.debug.scope.export import FORMATS
from sim.debug.scope.ring import Ring, thinned
from sim.debug.scope.session import BLACK_BOX, Session
from sim.debug.scope.source import Applied, Block, End, Fault, SourceError, Step, Stepped
from sim.debug.scope.step_response import measure
from sim.debug.scope.trigger import Settings, Trigger
from tests.scope.fake_source import ABOUT, rows


def feed(session: Session, ticks: int, size: int = 97) -> None:
    """So many more ticks, in blocks."""
    first = session.ring.end
    for at in range(first, first + ticks, size):
        session.take(rows(at, min(size, first + ticks - at)))


# ---------------------------------------------------------------------- ring


@pytest.mark.parametrize("sizes", [[1], [5, 3], [7, 7, 7], [100], [3, 40, 2]])
def test_ring__holds_the_last_ticks__whatever_the_blocks(sizes):
    ring, end = Ring(3, 10), 0
    for size in sizes:
        ring.append(rows(end, size))
        end += size
    assert (ring.first, ring.end) == (max(end - 10, 0), end)
    window = ring.window(0, 10**9)
    assert window.first == ring.first
    assert np.array_equal(window.values, rows(ring.first, len(ring)).values)
    assert len(ring.window(end, end + 5).values) == len(ring.window(-9, 0).values) == 0


def test_ring__ticks_that_are_missing__it_starts_anew():
    ring = Ring(3, 100)
    ring.append(rows(0, 20))
    ring.append(rows(30, 5))
    assert (ring.first, ring.end) == (30, 35)


@pytest.mark.parametrize("peak", [99.0, -99.0, np.nan])
@pytest.mark.parametrize("place", [0, 4321, 9999])
def test_thinned__one_odd_tick_of_10000__is_drawn(peak, place):
    values = np.sin(np.arange(10_000) / 50)
    values[place] = peak
    kept = thinned(values, 300)
    assert place in kept and len(kept) <= 602


# ---------------------------------------------------------------------- trigger


def caught(settings: Settings, values: np.ndarray, size: int) -> list[tuple[int, int, int]]:
    """Windows of a trigger, values in blocks."""
    trigger, found = Trigger(settings), []
    for at in range(0, len(values), size):
        trigger.look(at, values[at : at + size])
        window = trigger.window(min(at + size, len(values)))
        if window:
            found.append(window)
    return found


@pytest.mark.parametrize("size", [1, 13, 500])
@pytest.mark.parametrize(
    ("settings", "at"),
    [
        (Settings(kind="rising", level=50), 50),
        (Settings(kind="falling", level=50), 150),
        (Settings(kind="leave", low=-1, high=20), 21),
        (Settings(kind="enter", low=70, high=80), 70),
    ],
    ids=lambda value: getattr(value, "kind", value),
)
def test_trigger__fires_at_the_tick_that_crosses(settings, at, size):
    values = 100.0 - np.abs(np.arange(500) - 100.0)  # 0, up to 100 at tick 100, down
    chosen = msgspec.structs.replace(settings, mode="single", channel="c", pre=0.5, span=41)
    assert caught(chosen, values, size) == [(at - 20, at + 21, at)]


def test_trigger__normal_fires_again__single_waits_for_arm():
    values = np.sin(np.arange(1000) * 2 * np.pi / 100)
    normal = Settings(mode="normal", channel="c", level=0.5, span=50, pre=0.0)
    assert [at for _, _, at in caught(normal, values, 10)] == list(range(9, 1000, 100))
    assert len(caught(msgspec.structs.replace(normal, mode="single"), values, 10)) == 1


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"channel": "nothing"}, "no channel 'nothing'"),
        ({"span": 9}, "span is 9"),
        ({"span": 1 << 20}, "span is"),
        ({"pre": 1.5}, "pre is 1.5"),
        ({"kind": "leave", "low": 2.0, "high": 1.0}, "low must be less"),
        ({"level": float("nan")}, "finite"),
    ],
)
def test_trigger__settings_that_cannot_be__are_refused(change, said):
    session = Session(ABOUT)
    with pytest.raises(SourceError, match=said):
        session.set_trigger(Settings(**({"channel": "sine"} | change)))


# ---------------------------------------------------------------------- step response


@pytest.mark.parametrize("amplitude", [1.0, -3e-6])
@pytest.mark.parametrize("zeta", [0.3, 0.6])
def test_step_response__second_order__agrees_with_the_textbook(zeta, amplitude):
    from scipy import signal

    omega, period = 50.0, 1e-4
    system = signal.TransferFunction([omega**2], [1.0, 2 * zeta * omega, omega**2])
    time = np.arange(20_000) * period
    _, y = signal.step(system, T=time)
    found = measure(7.0 + amplitude * y if amplitude == 1.0 else amplitude * y, amplitude, period)
    damped = np.sqrt(1 - zeta**2)
    assert found.overshoot == pytest.approx(np.exp(-np.pi * zeta / damped), rel=1e-3)
    assert found.peak == pytest.approx(np.pi / (omega * damped), abs=1.5 * period)
    fine = np.interp([0.1, 0.9], y[: int(found.peak / period)], time[: int(found.peak / period)])
    assert found.rise == pytest.approx(fine[1] - fine[0], rel=1e-6)
    outside = time[np.abs(y - 1) > 0.02].max()
    assert found.settling == pytest.approx(outside + period, abs=period / 2)
    assert found.final == pytest.approx(1.0, abs=1e-6)


def test_step_response__that_never_comes__says_so():
    found = measure(np.zeros(100), 1.0, 1e-3)
    assert (found.rise, found.peak, found.settling) == (None, None, None)
    assert found.overshoot == found.final == 0.0


# ---------------------------------------------------------------------- session


def test_session__step__measured_once_its_ticks_are_there():
    session = Session(ABOUT)
    feed(session, 100)
    session.take(Stepped(100, "u", 0.5, 200))
    feed(session, 199)
    assert not session.responses
    feed(session, 1)
    (response,) = session.responses
    want = rows(100, 200).values[:, 0]
    assert response.figures == measure(want, 0.5, ABOUT.period)
    assert response.values == (want - want[0]).tolist()


def test_session__measure__the_window_of_the_trigger_as_a_step_response():
    session, tick = Session(ABOUT), np.arange(1000)
    values = rows(0, 1000).values
    values[:, 0] = 3.0 + 2.0 * (1.0 - np.exp(-np.maximum(tick - 399, 0) / 20.0))  # from 400 on
    with pytest.raises(SourceError, match="nothing is captured"):
        session.measure("sine")
    session.set_trigger(
        Settings(mode="single", channel="sine", level=3.01, span=500, pre=0.2)  # fires at 400
    )
    session.take(Block(0, values))
    session.measure("sine")
    (response,) = session.responses
    assert response.tick == 400 and response.figures.overshoot < 1e-6
    assert response.figures.amplitude == pytest.approx(2.0, abs=1e-6)
    assert response.figures.rise == pytest.approx(20.0 * np.log(9.0) * ABOUT.period, rel=0.01)
    with pytest.raises(SourceError, match="no channel 'none'"):
        session.measure("none")


def test_session__fault__black_box_keeps_the_ticks_before_it():
    session = Session(ABOUT)
    session.set_trigger(Settings(kind="fault", mode="single", span=100, pre=0.5))
    feed(session, 2 * BLACK_BOX)
    last = session.ring.end - 1
    broken = rows(last + 1, 1)
    broken.values[0, 0] = np.nan
    session.take(broken)
    session.take(Fault(last + 1, "NOT_FINITE: output F1"))
    session.take(End())
    feed(session, 3)  # whatever comes later
    box = session.part("blackbox")
    assert len(box.values) == BLACK_BOX and box.first == last + 2 - BLACK_BOX
    assert np.array_equal(box.values[:-1], rows(box.first, BLACK_BOX - 1).values)
    shown = session.last_ticks(["sine", "ramp"])
    assert shown["ticks"][-1] == last + 1 and shown["values"]["sine"][-1] == "nan"
    assert session.state()["fault"] == {"tick": last + 1, "text": "NOT_FINITE: output F1"}
    assert session.part("capture").first == last + 1 - 50
    frame = session.frame(["sine"], 100, None, None, "blackbox")
    assert (frame["kind"], frame["at"]) == ("blackbox", last + 1)


def test_session__staged_gains__change_together_when_committed():
    session = Session(ABOUT)
    session.stage("K", 3.0)
    session.stage("T", 0.25)
    session.stage("T", None)
    assert session.values == {"K": 2.0, "T": 0.5}
    commit = session.commit()
    assert (commit.version, commit.values, session.staged) == (1, {"K": 3.0}, {})
    assert session.values["K"] == 2.0  # until the loop says so
    session.take(Applied(10, 1, {"K": 3.0}))
    assert session.values == {"K": 3.0, "T": 0.5} and session.version == 1
    for refused, said in (
        (session.commit, "nothing is staged"),
        (lambda: session.stage("k", 1.0), "no gain 'k'; there are K, T"),
        (lambda: session.stage("K", float("inf")), "must be a finite number"),
        (lambda: session.step(Step("v", 1.0, 10)), "no step"),
        (lambda: session.step(Step("u", 0.0, 10)), "shows nothing"),
        (lambda: [session.step(Step("u", 1.0, 10)) for _ in "ab"], "a step is under way"),
        (lambda: session.put("v", None), "nothing can be put"),
        (lambda: session.part("blackbox"), "there is no 'blackbox'"),
    ):
        with pytest.raises(SourceError, match=said):
            refused()


def test_session__auto_shows_the_latest_ticks__normal_what_fired():
    session = Session(ABOUT)
    feed(session, 5000)
    assert session.window(None, None, "live")[0] == "live"
    session.set_trigger(Settings(mode="normal", channel="ramp", level=1e9, span=100))
    feed(session, 500)
    assert session.window(None, None, "live")[0] == "waiting"
    session.set_trigger(Settings(mode="normal", channel="ramp", level=2000.0, span=100, pre=0.5))
    feed(session, 1000)
    kind, block, at = session.window(None, None, "live")
    assert (kind, at, block.first, len(block.values)) == ("capture", 6000, 5950, 100)
    assert session.window(1000, 1010, "live")[1].first == 1000
    exact = session.at_ticks(["ramp"], 5999, 10**7, "live")
    assert exact["at_a"] == {"ramp": 5999 / 3} and exact["at_b"] is None


# ---------------------------------------------------------------------- exports

BLOCK = Block(1_000_000, np.vstack([rows(5, 40).values, [[np.nan, np.inf, -0.0]]]))
WANTED = BLOCK.values


def test_csv__read_back__is_the_same_to_the_last_bit():
    text = FORMATS["csv"](ABOUT.channels, ABOUT.period, BLOCK).decode()
    head, *lines = csv.reader(io.StringIO(text))
    assert head == ["tick", "time [s]", "sine [m]", "ramp [1]", "count [count]"]
    values = np.array([[float(cell) for cell in line] for line in lines])
    assert np.array_equal(values[:, 2:].view(np.uint64), WANTED.view(np.uint64))
    assert values[0, 0] == BLOCK.first and values[0, 1] == BLOCK.first * ABOUT.period


def test_parquet__read_back_by_pyarrow__is_the_same_with_units():
    data = FORMATS["parquet"](ABOUT.channels, ABOUT.period, BLOCK)
    table = pyarrow.parquet.read_table(io.BytesIO(data))
    assert table.column_names == ["tick", "time", "sine", "ramp", "count"]
    assert table.schema.field("sine").metadata[b"unit"] == b"m"
    values = np.stack([table[name].to_numpy() for name in ABOUT.names], axis=1)
    assert np.array_equal(values.view(np.uint64), WANTED.view(np.uint64))
    assert table["tick"].to_pylist() == list(range(BLOCK.first, BLOCK.first + len(WANTED)))


def test_mcap__read_back_by_its_reader__a_message_per_tick_with_schema():
    data = FORMATS["mcap"](ABOUT.channels, ABOUT.period, BLOCK)
    found = list(make_reader(io.BytesIO(data)).iter_messages())
    assert len(found) == len(WANTED)
    schema, channel, message = found[0]
    assert (channel.topic, channel.message_encoding, schema.encoding) == (
        *("/asip", "json"),
        "jsonschema",
    )
    assert set(json.loads(schema.data)["properties"]) == {"tick", *ABOUT.names}
    for k, (_, _, message) in enumerate(found[:-1]):
        values = json.loads(message.data)
        assert [values[name] for name in ABOUT.names] == WANTED[k].tolist()
        assert message.log_time == round((BLOCK.first + k) * ABOUT.period * 1e9)
    last = json.loads(found[-1][2].data)
    assert set(last) == {"tick", "count"}  # JSON has no NaN and no infinity
    for _, _, message in found:
        jsonschema.validate(json.loads(message.data), json.loads(schema.data))
