# SPDX-License-Identifier: Apache-2.0
"""Looks at a page in headless Chromium, through its DevTools protocol on a pair of pipes."""

from __future__ import annotations

import base64
import json
import os
import select
import subprocess
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.bench.needs import require

ROOT = Path(__file__).resolve().parents[2]
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--disable-dev-shm-usage", "--hide-scrollbars", "--remote-debugging-pipe"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader"),  # WebGL without a graphics card
)
LIMIT = 120.0  # s, of a look at a page: a guard against a hang
SIZES = {"desktop": (1280, 900), "phone": (390, 844)}
# Every figure is drawn when it has a canvas (3-D) or paths of curves or bars (2-D) in it.
LOOK = """
(() => {
  const plots = [...document.querySelectorAll('.js-plotly-plot')];
  const inside = e => e.getBoundingClientRect().right <= document.documentElement.clientWidth + 1;
  return JSON.stringify({
    figures: plots.length,
    drawn: plots.filter(p => p.querySelector('.gl-container canvas')
                          || p.querySelector('svg .scatterlayer path.js-line')
                          || p.querySelector('svg .barlayer .point path')).length,
    webgl: plots.filter(p => p.querySelector('.gl-container canvas')).length,
    message: plots.map(p => p.querySelector('.no-webgl')?.textContent || '').join(''),
    pictures: [...document.images].filter(i => i.complete && i.naturalWidth > 0).length,
    images: document.images.length,
    wide: [...document.querySelectorAll('h1,h2,p,figure,.key,dl,.js-plotly-plot')]
            .filter(e => !inside(e) && !e.closest('.wide')).length,
    ready: document.readyState,
  });
})()
"""


@dataclass
class Look:
    """What a browser saw: see LOOK for `page`; script errors and console messages of that level."""

    page: dict[str, Any] = field(default_factory=dict)
    errors: list[str] = field(default_factory=list)


class Browser:
    """A browser with one empty page; a context manager."""

    def __init__(self) -> None:
        program = require("chromium")
        self._profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        to_browser, self._out = os.pipe()
        self._in, from_browser = os.pipe()
        # The protocol's descriptors are 3 and 4.
        command = f'exec "$@" 3<&{to_browser} 4>&{from_browser}'
        profile = f"--user-data-dir={self._profile.name}"
        self._process = subprocess.Popen(
            ["/bin/bash", "-c", command, "bash", program, *FLAGS, profile, "about:blank"],
            pass_fds=(to_browser, from_browser),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_browser)
        os.close(from_browser)
        self._pending, self._number, self.errors = b"", 0, []
        self._end = time.monotonic() + LIMIT
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        session = self._call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = session["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self._call(f"{domain}.enable")

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._out)
        os.close(self._in)
        self._process.terminate()
        self._process.wait(LIMIT)
        self._profile.cleanup()

    def look(self, file: Path, size: str, picture: Path | None = None) -> Look:
        """Open a file in a window of SIZES, wait until it is drawn; picture: of the whole page."""
        width, height = SIZES[size]
        self.open(file.resolve().as_uri(), size)
        seen: dict[str, Any] = {}
        calm = 0
        while calm < 5:
            time.sleep(0.2)
            before, seen = seen, json.loads(self.evaluate(LOOK))
            calm = calm + 1 if seen == before and seen["ready"] == "complete" else 0
        if picture:
            size_now = self._call("Page.getLayoutMetrics")["cssContentSize"]
            clip = {"x": 0, "y": 0, "width": width, "height": size_now["height"], "scale": 1}
            shot = self._call("Page.captureScreenshot", clip=clip, captureBeyondViewport=True)
            picture.write_bytes(base64.b64decode(shot["data"]))
        return Look(seen, self.errors)

    def open(self, address: str, size: str) -> None:
        """Begin to load a page in a window of SIZES; errors are those from now on."""
        self.errors, self._end = [], time.monotonic() + LIMIT
        width, height = SIZES[size]
        view = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": size == "phone"}
        self._call("Emulation.setDeviceMetricsOverride", **view)
        self._call("Page.navigate", url=address)

    def until(self, script: str) -> Any:
        """Value of an expression on the page once it is true there; LIMIT guards against a hang."""
        end = time.monotonic() + LIMIT
        self._end = end + LIMIT
        while not (value := self.evaluate(script)):
            if time.monotonic() > end:
                raise TimeoutError(f"the page never came to: {script}; errors: {self.errors}")
            time.sleep(0.1)
        return value

    def evaluate(self, script: str) -> Any:
        """Value of an expression on the page, awaited if it is a promise."""
        asked = {"expression": script, "returnByValue": True, "awaitPromise": True}
        return self._call("Runtime.evaluate", **asked)["result"].get("value")

    def _call(self, method: str, **parameters: Any) -> dict[str, Any]:
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if hasattr(self, "_session"):
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive(method)
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self._note(answer)

    def _receive(self, method: str) -> dict[str, Any]:
        while b"\0" not in self._pending:
            left = self._end - time.monotonic()
            if left <= 0 or not select.select([self._in], [], [], left)[0]:
                raise TimeoutError(f"chromium has not answered {method} within {LIMIT:g} s")
            data = os.read(self._in, 1 << 20)
            if not data:
                raise RuntimeError(f"chromium has ended during {method}")
            self._pending += data
        answer, _, self._pending = self._pending.partition(b"\0")
        return json.loads(answer)

    def _note(self, event: dict[str, Any]) -> None:
        """Keep errors of scripts, of the console and of the browser's log (loading, policy)."""
        method, data = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = data["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled" and data["type"] in ("error", "assert"):
            self.errors.append(" ".join(str(a.get("value", a)) for a in data["args"]))
        elif method == "Log.entryAdded" and data["entry"]["level"] == "error":
            self.errors.append(data["entry"]["text"])
