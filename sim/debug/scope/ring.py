# SPDX-License-Identifier: Apache-2.0
"""The last ticks of every channel, in bounded memory, and their thinning out for a drawing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.debug.scope.source import Block
from sim.report.curves import envelope

LENGTH = 1 << 17
"""Ticks that a ring keeps: 13 s of a loop of 10 kHz."""


class Ring:
    """Ticks `first` to `end` (not included) of the channels; older ones are overwritten."""

    def __init__(self, channels: int, length: int = LENGTH) -> None:
        self._rows = np.empty((length, channels))
        self.first = self.end = 0

    def __len__(self) -> int:
        return self.end - self.first

    @property
    def length(self) -> int:
        """Ticks that it can hold."""
        return len(self._rows)

    def append(self, block: Block) -> None:
        """Add ticks; a block that does not follow the last tick starts again."""
        values = block.values[-self.length :]
        first = block.first + len(block.values) - len(values)
        if first != self.end:
            self.first = first
        places = np.arange(first, first + len(values)) % self.length
        self._rows[places] = values
        self.end = first + len(values)
        self.first = max(self.first, self.end - self.length)

    def window(self, begin: int, end: int) -> Block:
        """Ticks begin <= tick < end as far as they are stored, copied."""
        begin = min(max(begin, self.first), self.end)
        end = max(min(end, self.end), begin)
        places = np.arange(begin, end) % self.length
        return Block(begin, self._rows[places])


def thinned(values: NDArray[np.float64], pixels: int) -> NDArray[np.int64]:
    """Indices of values (N,) to draw: smallest and largest of every pixel, so that no peak is lost.

    Where a pixel holds a value that is no number, that value stays and makes a gap.
    """
    if len(values) <= 2 * pixels:
        return np.arange(len(values))
    return envelope(values, 2 * pixels)
