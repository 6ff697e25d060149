# SPDX-License-Identifier: Apache-2.0
"""An axis with sine and cosine lines and one with Hall lines in one front-end: counts, faults and
trips of each, and a clear of each."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from sim.rtl.gen.drive_regmap import REGMAP
from tests.servo import clocked, test_hall_decoder
from tests.servo.clocked import Accesses, Clocked, signed
from tests.servo.test_sincos_position import AMPLITUDE, BIT, EXACT, LINE, PERIOD, modulated

HERE = Path(__file__).parent
CLOCKS = 60 * PERIOD
BEGINS, ENDS = 20 * PERIOD, 30 * PERIOD  # of a fault
SPEED, HALL_SPEED = 0.1, 0.05  # counts a clock
SECTOR, LATE = 256, 19  # of a `hall_decoder` without parameters
OUTPUTS = ("readdata", "waitrequest", "position", "low")
FIELDS = REGMAP.registers["STATUS"].fields


def run(
    host: Accesses, sine: float = 1.0, line: int | None = None
) -> tuple[list[int], np.ndarray, np.ndarray, np.ndarray]:
    """Words read, distance of both counts from the motors (n, 2), low gates; from BEGINS
    until ENDS the sine has this strength, and all Hall lines this level."""
    clock = np.arange(CLOCKS)
    true = np.stack([300.5 + SPEED * clock, 700.3 + HALL_SPEED * clock])
    instants = clock[::BIT]
    angle = 2 * math.pi * true[0, ::BIT] / LINE
    strength = np.where((instants < BEGINS) | (instants >= ENDS), 1.0, sine)
    bits = {
        "bit_sine": modulated(AMPLITUDE * strength * np.sin(angle)),
        "bit_cosine": modulated(AMPLITUDE * np.cos(angle)),
    }
    given = {name: np.repeat(values, BIT)[:CLOCKS] for name, values in bits.items()}
    given |= test_hall_decoder.lines(true[1], SECTOR)
    if line is not None:
        for name in "uvw":
            given[name][BEGINS:ENDS] = line
    inputs = (*host.columns, *given)
    block = Clocked("external_axes", inputs, OUTPUTS, None, (*clocked.FOLDERS, HERE))
    found = block.run(CLOCKS, **host.columns, **given)
    counts = np.stack([signed(found["position"] >> shift, 32) for shift in (0, 32)])
    # Sine and cosine count from the first sample; the front-end has a register.
    first = np.floor(300.5 + SPEED * (PERIOD - 1 + 268))
    off = counts - true + np.array([[first], [HALL_SPEED * (LATE + 1)]])
    return host.words(found), off, found["low"], counts


def test_counts__are_those_of_both_encoders():
    host = Accesses(REGMAP, CLOCKS)
    for axis in (0, 1):
        host.read(50 * PERIOD + 10 * axis, "POSITION", index=axis)
        host.read(51 * PERIOD + 10 * axis, "ILLEGAL", index=axis)
    host.read(52 * PERIOD, "STATUS")
    (sine, sine_bad, hall, hall_bad, status), off, _, counts = run(host)
    later = slice(40 * PERIOD, None)
    assert np.abs(off[0, later]).max() <= 2 * EXACT and np.abs(off[1, later]).max() <= 2
    assert [sine, hall] == pytest.approx(counts[:, 50 * PERIOD], abs=2)
    assert (sine_bad, hall_bad, status) == (0, 0, 0)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("guard", [0, 1])
def test_fault__is_of_its_axis_alone_and_trips_it_if_it_is_guarded(axis, guard):
    """A sine that is gone; Hall lines that are all low."""
    host = Accesses(REGMAP, CLOCKS)
    host.write(10, "GUARD", encoder=guard)
    host.write(12, "MODE", axis0=1, axis1=1)  # brake: low gates on
    host.read(BEGINS - 20, "STATUS")
    host.read(58 * PERIOD, "STATUS")
    for other in (0, 1):
        host.read(59 * PERIOD + 10 * other, "ILLEGAL", index=other)
    faults = {"sine": 0.0} if axis == 0 else {"line": 0}
    (before, after, *bad), _, low, _ = run(host, **faults)
    assert before == 0
    assert FIELDS["illegal"].of(after) == 1 << axis
    assert FIELDS["trip"].of(after) == guard << axis
    assert bad[axis] > 0 and bad[1 - axis] == 0
    gates = [int(low[-1]) >> 3 * one & 7 for one in (0, 1)]
    assert bool(gates[axis]) == (not guard) and gates[1 - axis] == 7


def test_clear__forgets_the_fault_of_its_axis_alone():
    """Both encoders fail for a while."""
    host = Accesses(REGMAP, CLOCKS)
    host.read(49 * PERIOD, "STATUS")
    host.write(50 * PERIOD, "CONTROL", clear=1)
    host.read(50 * PERIOD + 4, "STATUS")
    host.write(55 * PERIOD, "CONTROL", clear=2)
    host.read(55 * PERIOD + 4, "STATUS")
    for axis in (0, 1):
        host.read(56 * PERIOD + 10 * axis, "ILLEGAL", index=axis)
    words = run(host, sine=0.0, line=1)[0]
    assert [FIELDS["illegal"].of(word) for word in words[:3]] == [3, 2, 0]
    assert words[3:] == [0, 0]
