# SPDX-License-Identifier: Apache-2.0
"""Phase record of the velocity control (rtl/motion/velocity_control.sv): its fields and units.

Velocity is in 2^-32/16 Hz (pulses), acceleration in that per tick of 1 us, jerk per tick twice. In
a record of n ticks the hardware publishes v + i a + j i (i + 1) / 2 in tick i = 0 .. n - 1, whole
units of 1/16 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

TICK = Fraction(1, 1_000_000)  # s
UNITS_PER_HZ = 16
UNITS_PER_PULSE = UNITS_PER_HZ * 1_000_000  # of a rate held for one tick
FRACTION = 1 << 32
HIGHEST_RATE = 50_000_000  # Hz
SLOPE_LIMIT = 1 << 52  # of acceleration and jerk, in their units
COUNT_LIMIT = (1 << 32) - 1

DIRECTION, BY_PULSES, FIRST, LAST = 1, 2, 4, 8
"""Flags of a record's word 0."""


@dataclass(frozen=True)
class Record:
    """One phase record: flags, count (ticks or pulses), velocity, acceleration, jerk."""

    flags: int
    count: int
    velocity: int
    slope: int
    jerk: int

    def words(self) -> list[int]:
        """The eight words of the record, in the order they are loaded."""
        words = [self.flags, self.count]
        for value in (self.velocity, self.slope, self.jerk):
            words += [value & 0xFFFFFFFF, (value >> 32) & 0xFFFFFFFF]
        return words

    def published(self, tick: int) -> int:
        """Rate [1/16 Hz] in a tick of a time-exact record."""
        value = self.velocity + tick * self.slope + self.jerk * (tick * (tick + 1) // 2)
        return max(value, 0) >> 32
