# SPDX-License-Identifier: Apache-2.0
"""The server of the page: on the loopback address only, and only for who has the token.

Everything is below http://127.0.0.1:PORT/TOKEN/: the page with its scripts, the web socket `ws`
(messages.py), exports such as `export/ring.csv`. Nothing is loaded from anywhere else. A page gets
its next frame when it has drawn the last one, so that a slow page never makes a queue.
"""

from __future__ import annotations

import asyncio
import socket
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

import msgspec
import tornado.httpserver
import tornado.web
import tornado.websocket
from plotly.offline import get_plotlyjs
from tornado.log import app_log

from sim.debug import guard
from sim.debug.scope import messages
from sim.debug.scope.export import FORMATS
from sim.debug.scope.session import Session
from sim.debug.scope.source import End, Event, Pace, Source, SourceError

PAGE = Path(__file__).with_name("page")
TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css"}
FRAME_S = 0.1  # least time between two frames of a page
CLOSE_S = 2.0  # for a source to end
POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; connect-src 'self'"
)


class Hub:
    """The session with its source and its pages; lives in the loop's thread."""

    def __init__(self, source: Source, changed: Callable[[int], None] = lambda pages: None) -> None:
        """changed: gets the number of open pages whenever it changes."""
        self.source = source
        self.session = Session(source.description)
        self.pages: set[PageSocket] = set()
        self._changed = changed
        self._loop = asyncio.get_running_loop()
        self._feeder = threading.Thread(target=self._feed, daemon=True)
        self._feeder.start()

    def _feed(self) -> None:
        """Bring events into the loop, each when the last one has been taken."""
        event: Event | None = None
        while not isinstance(event, End):
            event = self.source.wait()
            try:
                asyncio.run_coroutine_threadsafe(self._take(event), self._loop).result()
            except (RuntimeError, CancelledError):  # the loop has ended
                return

    async def _take(self, event: Event) -> None:
        self.session.take(event)

    async def close(self) -> None:
        """End the source; nobody waits for its events after this."""
        self.source.close()
        await asyncio.to_thread(self._feeder.join, CLOSE_S)

    def opened(self, page: PageSocket) -> None:
        """A page has come; the first one lets a source begin that waits for it."""
        self.pages.add(page)
        self._changed(len(self.pages))
        if self.session.description.paces and not self.session.ended:
            pace = Pace(self.session.paused, self.session.rate)
            self.source.send(self.session.pace(pace))

    def closed(self, page: PageSocket) -> None:
        """A page has gone."""
        self.pages.discard(page)
        self._changed(len(self.pages))


class _Guarded(tornado.web.RequestHandler):
    """Only with the token."""

    def initialize(self, hub: Hub, token: str) -> None:
        self.hub, self.token = hub, token

    def prepare(self) -> None:
        # A name of an attacker's own that leads to this machine (DNS rebinding) is no address here.
        if not guard.is_loopback(self.request.host_name.strip("[]")):
            raise tornado.web.HTTPError(403, reason="Wrong host")
        given = self.path_args[0] if self.path_args else ""
        if not guard.same_token(given, self.token):
            raise tornado.web.HTTPError(403, reason="Wrong or missing token")

    def write_error(self, status_code: int, **_: Any) -> None:
        cure = "; open the address that the command has printed" if status_code == 403 else ""
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"{status_code} {self._reason}{cure}\n")


class _Files(_Guarded):
    """The page and what it is made of."""

    content: dict[str, tuple[str, bytes]] = {}

    def get(self, _: str, name: str) -> None:
        if not name and not self.request.path.endswith("/"):  # the page's links are relative
            self.redirect(f"{self.request.path}/", permanent=True)
            return
        if not self.content:
            for file in PAGE.iterdir():
                self.content[file.name] = (TYPES[file.suffix], file.read_bytes())
            self.content["plotly.js"] = (TYPES[".js"], get_plotlyjs().encode())
        if (name or "index.html") not in self.content:
            raise tornado.web.HTTPError(404)
        kind, content = self.content[name or "index.html"]
        self.set_header("Content-Type", f"{kind}; charset=utf-8")
        self.set_header("Content-Security-Policy", POLICY)
        self.set_header("Referrer-Policy", "no-referrer")
        self.finish(content)


class _Export(_Guarded):
    """Recorded ticks as a file."""

    async def get(self, _: str, part: str, kind: str) -> None:
        session = self.hub.session
        if kind not in FORMATS:
            raise tornado.web.HTTPError(404, reason=f"formats: {', '.join(FORMATS)}")
        try:
            block = session.part(part)
        except SourceError as error:
            raise tornado.web.HTTPError(404, reason=str(error)) from None
        about = session.description
        write = FORMATS[kind]
        try:
            data = await asyncio.to_thread(write, about.channels, about.period, block)
        except ImportError as error:
            cure = f"no package {error.name}: pip install 'microtick[scope]'"
            raise tornado.web.HTTPError(501, reason=cure) from None
        self.set_header("Content-Type", "application/octet-stream")
        self.set_header("Content-Disposition", f'attachment; filename="asip-{part}.{kind}"')
        self.finish(data)


class PageSocket(tornado.websocket.WebSocketHandler):
    """One open page."""

    def initialize(self, hub: Hub, token: str) -> None:
        self.hub, self.token = hub, token
        self.view = messages.View(channels=hub.session.description.shown)
        self._ready = asyncio.Event()
        self._sent: dict[str, bytes] = {}

    prepare = _Guarded.prepare
    write_error = _Guarded.write_error

    def open(self, *_: str) -> None:
        self.set_nodelay(True)
        self.tell({"type": "hello", "source": self.hub.session.description})
        self.hub.opened(self)
        self._ready.set()
        self._task = asyncio.create_task(self._draw())
        self._task.add_done_callback(self._ended)

    def _ended(self, task: asyncio.Task[None]) -> None:
        """Nothing ends drawing but the page; anything else is a mistake here, and is reported."""
        if not task.cancelled() and task.exception() is not None:
            app_log.error("the scope cannot draw", exc_info=task.exception())
            self.close(reason="the scope cannot draw")

    def on_close(self) -> None:
        self._task.cancel()
        self.hub.closed(self)

    def tell(self, message: Any) -> None:
        """Send to this page."""
        self._write(msgspec.json.encode(message))

    def _write(self, data: bytes) -> None:
        try:
            self.write_message(data)
        except tornado.websocket.WebSocketClosedError:
            pass

    def _tell_new(self, message: Any) -> bool:
        """Send unless the page has the same already; whether it was sent."""
        data = msgspec.json.encode(message)
        new = self._sent.get(message["type"]) != data
        if new:
            self._sent[message["type"]] = data
            self._write(data)
        return new

    async def _draw(self) -> None:
        """State and curves, one frame after the other."""
        while True:
            await self._ready.wait()
            session, view = self.hub.session, self.view
            self._tell_new(session.state())
            numbers = session.last_ticks(view.channels)
            if numbers is not None:
                self._tell_new(numbers)
            frame = session.frame(view.channels, view.pixels, view.begin, view.end, view.part)
            if self._tell_new(frame):
                self._ready.clear()
            await asyncio.sleep(FRAME_S)

    async def on_message(self, text: str | bytes) -> None:
        try:
            await self._answer(messages.DECODER.decode(text))
        except (msgspec.DecodeError, SourceError, UnicodeDecodeError) as error:
            self.tell({"type": "error", "text": str(error)})

    async def _answer(self, message: messages.Message) -> None:
        hub, session = self.hub, self.hub.session
        match message:
            case messages.Ready():
                self._ready.set()
            case messages.View(channels=channels):
                unknown = [name for name in channels if name not in session.columns]
                if unknown:
                    raise SourceError(f"no channel {unknown[0]!r}")
                self.view = message
                self._sent.clear()
                self._ready.set()
            case messages.Pace():
                hub.source.send(session.pace(message))
            case messages.SetTrigger(settings=settings):
                session.set_trigger(settings)
            case messages.Arm():
                session.set_trigger(session.trigger.settings)
            case messages.Stage(name=name, value=value):
                others = {key: held for key, held in session.staged.items() if key != name}
                if value is not None and name in session.values:
                    await asyncio.to_thread(hub.source.check, others | {name: value})
                session.stage(name, value)
            case messages.CommitStaged():
                await asyncio.to_thread(hub.source.send, session.commit())
            case messages.Step():
                hub.source.send(session.step(message))
            case messages.Measure(channel=channel):
                session.measure(channel)
            case messages.Put(name=name, value=value):
                hub.source.send(session.put(name, value))
            case messages.Cursor(a=a, b=b):
                view = self.view
                self.tell(session.at_ticks(view.channels, a, b, view.part))


def bind(port: int = 0) -> socket.socket:
    """A listening socket on the loopback address; 0: any free port. Raises OSError."""
    listening = guard.listen(port, app_log.warning)
    listening.setblocking(False)
    return listening


def address(listening: socket.socket, token: str) -> str:
    """What to open in a browser."""
    return f"http://{guard.LOOPBACK}:{listening.getsockname()[1]}/{token}/"


async def serve(
    source: Source,
    listening: socket.socket,
    token: str,
    changed: Callable[[int], None] = lambda pages: None,
) -> None:
    """Show the source until this is cancelled. changed: gets the number of open pages."""
    hub = Hub(source, changed)
    known = {"hub": hub, "token": token}
    application = tornado.web.Application(
        [
            (r"/([^/]*)/ws", PageSocket, known),
            (r"/([^/]*)/export/(\w+)\.(\w+)", _Export, known),
            (r"/([^/]*)/?([\w.]*)", _Files, known),
        ],
        websocket_max_message_size=messages.LARGEST,
        log_function=lambda handler: None,
    )
    server = tornado.httpserver.HTTPServer(application)
    server.add_socket(listening)
    try:
        await asyncio.Event().wait()
    finally:
        server.stop()
        await hub.close()
