# SPDX-License-Identifier: Apache-2.0
"""Limit and home switches of a simulated axis, and the index of its encoder."""

from __future__ import annotations

from dataclasses import dataclass, field

NEGATIVE, POSITIVE, HOME = 1, 2, 4  # SWITCH_* of nios_sw/ethercat/application.h
COUNTS = 64  # an index count is modulo this


@dataclass
class Switches:
    """Places in increments. The limit switches are on up to `negative` and from `positive` on, the
    home switch in [home[0], home[1]]; an index is at each multiple of `pitch` (0: none).
    """

    negative: int
    positive: int
    home: tuple[int, int]
    pitch: int = 0
    count: int = 0  # of the index
    index: int = 0  # where the last one was
    _before: int | None = field(default=None, repr=False)

    def word(self, position: int) -> int:
        """Switches that are on there."""
        word = NEGATIVE * (position <= self.negative) | POSITIVE * (position >= self.positive)
        return word | HOME * (self.home[0] <= position <= self.home[1])

    def move(self, position: int) -> None:
        """The axis is there now: the index is counted, its place is exact. One is passed when the
        axis comes to it from either side or crosses it."""
        before, self._before = self._before, position
        if not self.pitch or before is None or before == position:
            return
        up = position > before
        last = (position if up else -position) // self.pitch * self.pitch
        last = last if up else -last
        passed = (last - before if up else before - last) / self.pitch
        if passed > 0:
            self.index = last
            self.count = (self.count + int(-(-passed // 1))) % COUNTS
