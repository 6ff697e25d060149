# SPDX-License-Identifier: Apache-2.0
"""Progress of long work on the error stream."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, field

PACE_SECONDS = 10.0


@dataclass
class Pace:
    """Reports on the error stream how much of a campaign is done and how long the rest may take: at
    most every `PACE_SECONDS`, so that a log stays short.
    """

    what: str
    total: int
    begun: float = field(default_factory=time.monotonic)
    shown: float = field(default_factory=time.monotonic)

    def at(self, done: int, total: int = 0) -> None:
        """Some of the campaign is done; total: if it was not known at the start."""
        self.total = total or self.total
        now = time.monotonic()
        if 0 < done < self.total and now - self.shown >= PACE_SECONDS:
            self.shown = now
            left = (now - self.begun) / done * (self.total - done)
            text = f"{self.what}: {done} of {self.total}, about {left:.0f} s left"
            print(text, file=sys.stderr, flush=True)
