# SPDX-License-Identifier: Apache-2.0
"""What all pages share: the ring, the trigger's window, the black box, gains, step responses.

No input or output happens here: the server feeds events in and asks for what to show.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.debug.scope import source
from sim.debug.scope.ring import LENGTH, Ring, thinned
from sim.debug.scope.source import Block, Description, SourceError
from sim.debug.scope.step_response import StepFigures, measure
from sim.debug.scope.trigger import LEAST_SPAN, Settings, Trigger

BLACK_BOX = 4096
"""Ticks before a fault that are stored."""
RESPONSES = 6  # step responses that are stored
RESPONSE_POINTS = 400
TRAIL_TICKS, TRAIL_POINTS = 5000, 100  # of the tool in space
FREE_RUN = 4  # spans without a trigger until 'auto' shows the latest ticks again
TABLE_TICKS = 12  # of the black box, as numbers
OWN = ("paused", "rate", "ended", "note", "lost", "staged", "version", "committed", "stepping")
"""Attributes of a session that pages get as they are."""


@dataclass(frozen=True)
class Kept:
    """A window that stays: by the trigger (`at` fired) or before a fault (`at` faulted)."""

    block: Block
    at: int
    text: str = ""

    @property
    def end(self) -> int:
        return self.block.first + len(self.block.values)


@dataclass(frozen=True)
class Response:
    """A measured step: values (N,) of the channel from its tick on."""

    tick: int
    name: str
    channel: str
    version: int
    figures: StepFigures
    values: list[float]
    ticks: list[int]


class Session:
    """State of the scope."""

    def __init__(self, description: Description, length: int = LENGTH) -> None:
        self.description = description
        self.columns = {name: k for k, name in enumerate(description.names)}
        self.ring = Ring(len(self.columns), length)
        self.trigger = Trigger()
        self.capture: Kept | None = None
        self.black_box: Kept | None = None
        self.values = {gain.name: gain.value for gain in description.gains}
        self.staged: dict[str, float] = {}
        self.version = self.committed = 0
        self.paused = False
        self.rate: float | None = None
        self.ended = self.note = ""
        self.lost = 0
        self.stepping = False
        self._stepped: source.Stepped | None = None
        self.responses: deque[Response] = deque(maxlen=RESPONSES)

    # ------------------------------------------------------------------ from the source
    def take(self, event: source.Event) -> None:
        """The next event of the source."""
        if isinstance(event, Block):
            self.ring.append(event)
            settings = self.trigger.settings
            if settings.channel in self.columns and len(event.values):
                column = event.values[:, self.columns[settings.channel]]
                self.trigger.look(event.first, column)
            self._catch()
            self._respond()
        elif isinstance(event, source.Applied):
            self.values.update(event.values)
            self.version = event.version
        elif isinstance(event, source.Stepped):
            self._stepped = event
        elif isinstance(event, source.Fault):
            begin = self.ring.end - BLACK_BOX
            kept = self.ring.window(begin, self.ring.end)
            self.black_box = Kept(kept, event.tick, event.text)
            self.trigger.fault(event.tick)
            self._catch(over=True)
        elif isinstance(event, source.Lost):
            self.lost += event.ticks
        elif isinstance(event, source.Note):
            self.note = event.text
        elif isinstance(event, source.End):
            self.ended = event.text
            self._catch(over=True)

    def _catch(self, over: bool = False) -> None:
        window = self.trigger.window(self.ring.end, over)
        if window is not None:
            begin, end, at = window
            self.capture = Kept(self.ring.window(begin, end), at)

    def _respond(self) -> None:
        """Measure the step once all its ticks are there."""
        step = self._stepped
        if step is None or self.ring.end < step.tick + step.ticks:
            return
        self._stepped, self.stepping = None, False
        channel = next(s.response for s in self.description.steps if s.name == step.name)
        block = self.ring.window(step.tick, step.tick + step.ticks)
        values = block.values[:, self.columns[channel]]
        if len(values) < step.ticks or not np.isfinite(values).all():
            return
        self._keep(step.tick, step.name, channel, values, step.amplitude)

    def _keep(
        self, tick: int, name: str, channel: str, values: NDArray[np.float64], amplitude: float
    ) -> None:
        """Figures and curve of a response (N,) that begins with its first value."""
        figures = measure(values, amplitude, self.description.period)
        kept = thinned(values, RESPONSE_POINTS // 2)
        curve = (values[kept] - values[0]).tolist()
        self.responses.append(
            Response(tick, name, channel, self.version, figures, curve, kept.tolist())
        )

    # ------------------------------------------------------------------ from the pages
    def pace(self, wanted: source.Pace) -> source.Pace:
        """Hold or run. Raises SourceError."""
        if not self.description.paces:
            raise SourceError("a machine cannot be paused from here; its loop has its own clock")
        self.paused, self.rate = wanted.paused, wanted.rate
        return wanted

    def set_trigger(self, settings: Settings) -> None:
        """Other settings, armed. Raises SourceError."""
        numbers = (settings.level, settings.low, settings.high, settings.pre)
        problem = settings.problem(list(self.columns))
        if not all(map(math.isfinite, numbers)):
            problem = "levels of a trigger are finite numbers"
        if problem:
            raise SourceError(problem)
        self.trigger = Trigger(settings)
        self.capture = None

    def stage(self, name: str, value: float | None) -> None:
        """Raises SourceError."""
        if name not in self.values:
            raise SourceError(f"no gain {name!r}; there are {', '.join(self.values) or 'none'}")
        if value is None:
            self.staged.pop(name, None)
        elif not math.isfinite(value):
            raise SourceError(f"{name} = {value}: must be a finite number")
        else:
            self.staged[name] = value

    def commit(self) -> source.Commit:
        """Everything staged, as the next version. Raises SourceError."""
        if not self.staged:
            raise SourceError("nothing is staged; give a gain another value first")
        self._running()
        self.committed += 1
        staged, self.staged = self.staged, {}
        return source.Commit(self.committed, staged)

    def step(self, wanted: source.Step) -> source.Step:
        """Raises SourceError."""
        if wanted.name not in [step.name for step in self.description.steps]:
            raise SourceError(f"no step can be put on {wanted.name!r}")
        if not math.isfinite(wanted.amplitude) or wanted.amplitude == 0.0:
            raise SourceError(f"a step of {wanted.amplitude} shows nothing")
        if wanted.ticks > self.ring.length:
            held = self.ring.length
            raise SourceError(f"the ring holds {held} ticks, the step has {wanted.ticks}")
        self._running()
        if self.stepping:
            raise SourceError("a step is under way; the next one begins when it has been measured")
        self.stepping = True
        return wanted

    def measure(self, channel: str) -> None:
        """Take the window of the trigger for a step response: from the mean before the tick that
        fired to the mean of the last tenth. Raises SourceError."""
        capture = self.capture
        if channel not in self.columns:
            raise SourceError(f"no channel {channel!r}")
        if capture is None:
            raise SourceError("nothing is captured; set a trigger that fires at the step")
        values = capture.block.values[:, self.columns[channel]]
        begin = max(capture.at - capture.block.first, 0)
        response = values[begin:].copy()
        if len(response) < LEAST_SPAN or not np.isfinite(values).all():
            raise SourceError("the window has too few ticks after its trigger, or no numbers")
        response[0] = values[: max(begin, 1)].mean()
        amplitude = float(response[-max(len(response) // 10, 1) :].mean() - response[0])
        if amplitude == 0.0:
            raise SourceError(f"{channel} is the same before and after: there is no step in it")
        self._keep(capture.at, channel, channel, response, amplitude)

    def put(self, name: str, value: float | None) -> source.Put:
        """Raises SourceError."""
        if name not in self.description.inputs:
            raise SourceError(f"nothing can be put on {name!r}")
        self._running()
        return source.Put(name, math.nan if value is None else value)

    def _running(self) -> None:
        if self.ended:
            raise SourceError(f"no tick comes any more: {self.ended}")

    # ------------------------------------------------------------------ to the pages
    def part(self, name: str) -> Block:
        """Ticks to export: 'ring', 'capture' or 'blackbox'. Raises SourceError."""
        if name == "ring":
            return self.ring.window(self.ring.first, self.ring.end)
        kept = {"capture": self.capture, "blackbox": self.black_box}.get(name)
        if kept is None:
            raise SourceError(f"there is no {name!r}; parts: ring, capture, blackbox")
        return kept.block

    def window(
        self, begin: int | None, end: int | None, part: str
    ) -> tuple[str, Block, int | None]:
        """What a page that looks there shows: kind, ticks, tick of the trigger or fault."""
        settings, capture, box = self.trigger.settings, self.capture, self.black_box
        if part == "blackbox" and box is not None:
            return "blackbox", _cut(box.block, begin, end), box.at
        if begin is not None and end is not None:
            if capture is not None and capture.block.first <= begin < end <= capture.end:
                return "capture", _cut(capture.block, begin, end), capture.at
            return "window", self.ring.window(begin, end), None
        late = capture is None or self.ring.end - capture.end > FREE_RUN * settings.span
        if settings.mode == "auto" and late:
            return "live", self.ring.window(self.ring.end - settings.span, self.ring.end), None
        if capture is None:
            return "waiting", self.ring.window(self.ring.end, self.ring.end), None
        return "capture", capture.block, capture.at

    def frame(
        self, channels: list[str], pixels: int, begin: int | None, end: int | None, part: str
    ) -> dict[str, Any]:
        """The curves of a page, thinned to its pixels, and the machine in space."""
        kind, block, at = self.window(begin, end, part)
        curves = {}
        for name in channels:
            column = block.values[:, self.columns[name]]
            kept = thinned(column, pixels) if len(column) else np.arange(0)
            curves[name] = {"t": (kept + block.first).tolist(), "v": column[kept].tolist()}
        last = block.first + len(block.values)
        frame = {"type": "frame", "kind": kind, "begin": block.first, "end": last, "at": at}
        return frame | {"curves": curves, "space": self._space()}

    def _space(self) -> dict[str, Any] | None:
        scene = self.description.scene
        if scene is None or not len(self.ring):
            return None
        places = [self.columns[name] for name in (*scene.tool, *scene.table)]
        rows = self.ring.window(self.ring.end - TRAIL_TICKS, self.ring.end).values[:, places]
        step = -(-len(rows) // TRAIL_POINTS)
        trail = rows[::-1][::step][::-1, :3]
        return {"now": rows[-1].tolist(), "trail": trail.T.tolist()}

    def at_ticks(self, channels: list[str], a: int, b: int, part: str) -> dict[str, Any]:
        """Exact values at two ticks, None where they are not stored."""
        block = self.window(None, None, part)[1]

        def values(tick: int) -> dict[str, float] | None:
            for held in (_cut(block, tick, tick + 1), self.ring.window(tick, tick + 1)):
                if len(held.values) and held.first == tick:
                    row = held.values[0]
                    return {name: float(row[self.columns[name]]) for name in channels}
            return None

        return {"type": "cursor", "a": a, "b": b, "at_a": values(a), "at_b": values(b)}

    def state(self) -> dict[str, Any]:
        """Everything but the curves."""
        box = self.black_box
        return {name: getattr(self, name) for name in OWN} | {
            "type": "state",
            "tick": self.ring.end,
            "kept": len(self.ring),
            "length": self.ring.length,
            "trigger": {"settings": self.trigger.settings, "state": self.trigger.state},
            "capture": None if self.capture is None else self.capture.at,
            "gains": self.values,
            "responses": list(self.responses),
            "fault": None if box is None else {"tick": box.at, "text": box.text},
        }

    def last_ticks(self, channels: list[str]) -> dict[str, Any] | None:
        """The black box as numbers in text: NaN and infinity keep their names."""
        box = self.black_box
        if box is None:
            return None
        rows = box.block.values[-TABLE_TICKS:]
        shown = {
            name: [f"{value:.7g}" for value in rows[:, self.columns[name]].tolist()]
            for name in channels
        }
        begin = box.end - len(rows)
        return {"type": "blackbox", "ticks": list(range(begin, box.end)), "values": shown}


def _cut(block: Block, begin: int | None, end: int | None) -> Block:
    """The part of a block between two ticks, all of it without them."""
    if begin is None or end is None:
        return block
    low = min(max(begin - block.first, 0), len(block.values))
    high = min(max(end - block.first, low), len(block.values))
    return Block(block.first + low, block.values[low:high])
