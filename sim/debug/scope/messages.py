# SPDX-License-Identifier: Apache-2.0
"""What a page may say: JSON objects, distinguished by their `type`. Anything else is refused.

`Pace` and `Step` go on to the source as they are.
"""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta

from sim.debug.scope.trigger import Settings

Name = Annotated[str, Meta(max_length=200)]
LARGEST = 1 << 16  # bytes of a message
MOST_CURVES = 32


class _Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="type"):
    """One message."""


class View(_Message, frozen=True, tag="view"):
    """What this page draws. begin, end: ticks to look at, None: the latest ones or the trigger's
    window; part: 'live', or 'blackbox' for the ticks before a fault."""

    channels: Annotated[list[Name], Meta(max_length=MOST_CURVES)]
    pixels: Annotated[int, Meta(ge=50, le=4000)] = 800
    begin: Annotated[int, Meta(ge=0)] | None = None
    end: Annotated[int, Meta(ge=0)] | None = None
    part: Annotated[str, Meta(pattern="^(live|blackbox)$")] = "live"


class Ready(_Message, frozen=True, tag="ready"):
    """The page has drawn what it got and takes the next frame."""


class Pace(_Message, frozen=True, tag="pace"):
    """Hold the loop between two ticks, or let it run; rate: at most so many ticks per second of
    the clock on the wall, None: as fast as it can."""

    paused: bool
    rate: Annotated[float, Meta(ge=1.0, le=1e7)] | None = None


class SetTrigger(_Message, frozen=True, tag="trigger"):
    settings: Settings


class Arm(_Message, frozen=True, tag="arm"):
    """Wait for the trigger once more."""


class Stage(_Message, frozen=True, tag="stage"):
    """A gain for the next commit; None: as it is."""

    name: Name
    value: float | None


class CommitStaged(_Message, frozen=True, tag="commit"):
    """Put all staged gains in force together."""


class Step(_Message, frozen=True, tag="step"):
    """Add a step to an input for some ticks."""

    name: Name
    amplitude: float
    ticks: Annotated[int, Meta(ge=10, le=1 << 15)] = 2000


class Measure(_Message, frozen=True, tag="measure"):
    """Figures of a channel as a step response, in the trigger's window from its trigger on."""

    channel: Name


class Put(_Message, frozen=True, tag="put"):
    """A value on an input for one tick; None: not a number."""

    name: Name
    value: float | None = None


class Cursor(_Message, frozen=True, tag="cursor"):
    """Ask for the exact values of the view's channels at two ticks."""

    a: Annotated[int, Meta(ge=0)]
    b: Annotated[int, Meta(ge=0)]


Message = (
    View | Ready | Pace | SetTrigger | Arm | Stage | CommitStaged | Step | Measure | Put | Cursor
)
DECODER = msgspec.json.Decoder(Message)
