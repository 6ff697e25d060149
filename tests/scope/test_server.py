# SPDX-License-Identifier: Apache-2.0
"""The server of the scope: who gets in, what it answers, what it does with nonsense."""

from __future__ import annotations

import asyncio
import http.client
import io
import json

import msgspec
import numpy as np
import pyarrow.parquet
import pytest
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.httputil import HTTPHeaders
from tornado.websocket import websocket_connect

from sim.debug.scope.messages import LARGEST
from sim.debug.scope.source import Commit, End, Fault, Pace, Put, Step, Stepped
from sim.debug.scope.step_response import measure
from tests.scope.fake_source import ABOUT, FakeSource, Scope, rows
from tests.scope.page_link import LIMIT, Page, socket_of, talk


@pytest.fixture()
def scope():
    with Scope(FakeSource()) as running:
        yield running


def get(scope: Scope, path: str, host: str | None = None) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection(*scope.address, timeout=LIMIT)
    connection.request("GET", path, headers={"Host": host} if host else {})
    answer = connection.getresponse()
    return answer.status, answer.read()


# ---------------------------------------------------------------------- who gets in


@pytest.mark.parametrize("path", ["/", "/x/", "/{}x/", "/x/plotly.js", "/x/export/ring.csv"])
def test_without_the_token__everything_is_refused(scope, path):
    status, text = get(scope, path.format(scope.token))
    assert status == 403 and b"open the address that the command has printed" in text


def test_address_without_its_last_slash__leads_to_the_page(scope):
    connection = http.client.HTTPConnection(*scope.address, timeout=LIMIT)
    connection.request("GET", f"/{scope.token}")
    answer = connection.getresponse()
    assert answer.status == 301 and answer.getheader("Location") == f"/{scope.token}/"


def test_socket__wrong_token_or_foreign_page__is_refused(scope):
    async def refused(address: str, origin: str | None) -> int:
        headers = HTTPHeaders({"Origin": origin} if origin else {})
        with pytest.raises(HTTPClientError) as caught:
            await websocket_connect(HTTPRequest(address, headers=headers))
        return caught.value.code

    right = socket_of(scope.url)
    assert asyncio.run(refused(right.replace(scope.token, "guess"), None)) == 403
    assert asyncio.run(refused(right, "http://elsewhere.example")) == 403


def test_server__listens_on_the_loopback_address_only(scope):
    assert scope.address[0] == "127.0.0.1"


def test_page__loads_nothing_from_elsewhere(scope):
    status, text = get(scope, f"/{scope.token}/")
    assert status == 200 and b"//" not in text.replace(b"<!DOCTYPE html>", b"")
    for name in ("plotly.js", "scope.js", "plots.js", "panels.js", "scope.css"):
        assert name.encode() in text and get(scope, f"/{scope.token}/{name}")[0] == 200
    assert get(scope, f"/{scope.token}/nothing.js")[0] == 404
    assert get(scope, f"/{scope.token}/..%2fserver.py")[0] in (403, 404)


# ---------------------------------------------------------------------- what it answers


def test_frame__every_tick_where_there_are_pixels__exact(scope):
    scope.source.events.put(rows(0, 500))

    async def act(page: Page) -> None:
        assert (await page.hear("hello"))["source"]["title"] == ABOUT.title
        page.say(type="view", channels=["count", "sine"], pixels=400, begin=100, end=200)
        frame = await page.hear("frame", lambda m: m["kind"] == "window" and m["end"] == 200)
        assert frame["curves"]["sine"]["t"] == list(range(100, 200))
        assert frame["curves"]["sine"]["v"] == rows(100, 100).values[:, 0].tolist()
        page.say(type="cursor", a=3, b=7)
        reply = await page.hear("cursor")
        assert reply["at_a"] == {"count": -3.0, "sine": rows(3, 1).values[0, 0]}

    talk(scope.url, act)


def test_second_page__sees_what_the_first_one_did(scope):
    async def act(first: Page, second: Page) -> None:
        first.say(type="stage", name="K", value=3.5)
        assert (await second.hear("state", lambda m: m["staged"]))["staged"] == {"K": 3.5}
        second.say(type="commit")
        state = await first.hear("state", lambda m: m["version"] == 1)
        assert state["gains"]["K"] == 3.5 and state["staged"] == {}
        second.say(type="view", channels=["ramp"])
        first.say(type="pace", paused=True, rate=100)
        assert (await second.hear("state", lambda m: m["paused"]))["rate"] == 100

    talk(scope.url, act, pages=2)
    assert Commit(1, {"K": 3.5}) in scope.source.sent and Pace(True, 100) in scope.source.sent


def test_commands__reach_the_source(scope):
    async def act(page: Page) -> None:
        page.say(type="step", name="u", amplitude=0.5, ticks=100)
        page.say(type="put", name="u", value=None)
        page.say(type="stage", name="K", value=101)
        assert (await page.hear("error"))["text"] == "K = 101: must be at most 100"

    talk(scope.url, act)
    step, put = [c for c in scope.source.sent if isinstance(c, Step | Put)]
    assert step == Step("u", 0.5, 100) and put.name == "u" and np.isnan(put.value)


def test_step__its_figures_and_curve_come(scope):
    async def act(page: Page) -> None:
        scope.source.events.put(rows(0, 10))
        scope.source.events.put(Stepped(10, "u", -1.0, 50))
        scope.source.events.put(rows(10, 60))
        (response,) = (await page.hear("state", lambda m: m["responses"]))["responses"]
        want = rows(10, 50).values[:, 0]
        figures = json.loads(msgspec.json.encode(measure(want, -1.0, ABOUT.period)))
        assert response["figures"] == figures and response["figures"]["rise"] > 0.0
        assert response["values"] == (want - want[0]).tolist()

    talk(scope.url, act)


def test_fault__black_box_comes_to_every_page(scope):
    async def act(first: Page, second: Page) -> None:
        scope.source.events.put(rows(0, 50))
        scope.source.events.put(Fault(49, "NOT_FINITE"))
        scope.source.events.put(End("the loop has ended"))
        for page in (first, second):
            state = await page.hear("state", lambda m: m["fault"])
            assert state["fault"] == {"tick": 49, "text": "NOT_FINITE"}
            assert (await page.hear("blackbox"))["ticks"][-1] == 49
        first.say(type="step", name="u", amplitude=0.5)
        assert "no tick comes any more" in (await first.hear("error"))["text"]

    talk(scope.url, act, pages=2)
    status, data = get(scope, f"/{scope.token}/export/blackbox.parquet")
    assert status == 200
    table = pyarrow.parquet.read_table(io.BytesIO(data))
    assert table["sine"].to_pylist() == rows(0, 50).values[:, 0].tolist()


def test_export__unknown_part_or_format__says_what_there_is(scope):
    assert get(scope, f"/{scope.token}/export/capture.csv")[0] == 404
    status, text = get(scope, f"/{scope.token}/export/ring.xlsx")
    assert status == 404 and b"csv, parquet, mcap" in text


# ---------------------------------------------------------------------- nonsense


@pytest.mark.parametrize(
    "text",
    [
        *("", "{", "[]", "null", '"view"', "1e999", "\x00", "{}" * 3, '{"type":"nothing"}'),
        *('{"type":"view"}', '{"type":"view","channels":["no such"]}'),
        *('{"type":"view","channels":["sine"],"pixels":1e9}', '{"type":"commit","more":1}'),
        *('{"type":"pace","paused":"yes"}', '{"type":"pace","paused":false,"rate":-1}'),
        *('{"type":"step","name":"u","amplitude":1,"ticks":1e99}', '{"type":"commit"}'),
        *('{"type":"trigger","settings":{"mode":"never"}}', '{"type":"stage","name":7}'),
        '{"type":"trigger","settings":{"channel":"sine","span":-5}}',
    ],
)
def test_malformed_message__is_told__and_the_page_goes_on(scope, text):
    async def act(page: Page) -> None:
        page.link.write_message(text)
        assert (await page.hear("error"))["text"]
        page.say(type="view", channels=["ramp"])
        await page.hear("frame", lambda m: list(m["curves"]) == ["ramp"])

    talk(scope.url, act)
    assert not [c for c in scope.source.sent if not isinstance(c, Pace)]


def test_message_too_large_or_not_text__ends_that_page_only(scope):
    async def act(first: Page, second: Page) -> None:
        first.link.write_message("x" * (LARGEST + 1))
        while await asyncio.wait_for(first.link.read_message(), LIMIT) is not None:
            pass
        second.link.write_message(b"\xff\xfe", binary=True)
        await second.hear("error")
        second.say(type="view", channels=["ramp"])
        await second.hear("frame", lambda m: list(m["curves"]) == ["ramp"])

    talk(scope.url, act, pages=2)


def test_slow_page__gets_one_frame_until_it_is_ready(scope):
    async def act(page: Page) -> None:
        await page.hear("hello")
        frames = 0
        for k in range(20):
            scope.source.events.put(rows(100 * k, 100))
        try:
            while True:
                text = await asyncio.wait_for(page.link.read_message(), 1.0)
                frames += json.loads(text)["type"] == "frame"
        except TimeoutError:
            pass
        assert frames == 1
        page.say(type="ready")
        frame = await page.hear("frame")
        assert frame["end"] == 2000

    talk(scope.url, act)
