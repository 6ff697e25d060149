# SPDX-License-Identifier: Apache-2.0
"""The control tick of `ecat_tick`, clock by clock: its period, and how it comes to SYNC0."""

from __future__ import annotations

import numpy as np
import pytest

from tests.servo.clocked import Clocked

PERIOD, SLEW, PULSE = 100, 3, 10  # clocks; PULSE: SYNC0 is high
TICKS = 4  # from SYNC0 to SYNC0
CONTRACT = -(-PERIOD // (2 * SLEW))  # ticks until any distance is gone


def ticks(run: np.ndarray | int, sync: np.ndarray | int, clocks: int) -> np.ndarray:
    """Clocks in which there is a tick."""
    tick = Clocked("ecat_tick", ("run", "sync"), ("tick",), {"Period": PERIOD, "Slew": SLEW})
    return np.flatnonzero(tick.run(clocks, run=run, sync=sync)["tick"])


def pulses(begins: np.ndarray, clocks: int) -> np.ndarray:
    """SYNC0 that begins in these clocks."""
    sync = np.zeros(clocks, dtype=np.int64)
    for begin in begins:
        sync[begin : begin + PULSE] = 1
    return sync


def test_period__without_sync0_is_that_of_the_parameter() -> None:
    run = np.ones(2000, dtype=np.int64)
    runs = ((0, 899), (1037, 2000))  # the first one ends with the clock of its ninth tick
    run[899:1037] = 0
    found = ticks(run, 0, len(run))
    # A tick ends the period that begins with the first clock of the run.
    wanted = np.concatenate([np.arange(*ends, PERIOD)[1:] for ends in runs]) - 1
    assert found.tolist() == wanted.tolist()


@pytest.mark.parametrize("phase", [-40, 40])
def test_stop__in_a_correction__ends_it(phase: int) -> None:
    clocks, stop, start = 2000, 5 * PERIOD, 6 * PERIOD
    run = np.ones(clocks, dtype=np.int64)
    run[stop:start] = 0
    found = ticks(run, pulses(np.array([2 * PERIOD + phase]), clocks), clocks)
    corrected = np.diff(found[found < stop])[2:]
    assert len(corrected) and (np.abs(corrected - PERIOD) == SLEW).all(), "in a correction"
    after = found[found >= start]
    assert after.tolist() == list(range(start + PERIOD - 1, clocks, PERIOD))


@pytest.mark.parametrize("phase", range(-49, 50))
def test_phase__is_gone_after_the_ticks_of_the_contract(phase: int) -> None:
    """phase: clocks of SYNC0 after a tick. Each step goes towards SYNC0, none back."""
    clocks = (CONTRACT + 8 * TICKS) * PERIOD
    begins = np.arange(TICKS * PERIOD + phase, clocks - PULSE, TICKS * PERIOD)
    found = ticks(1, pulses(begins, clocks), clocks)
    apart = np.diff(found)
    assert np.abs(apart - PERIOD).max() <= SLEW
    assert np.abs(apart - PERIOD).sum() <= abs(phase) + 1, "the short way"
    settled = begins[begins > begins[0] + CONTRACT * PERIOD]
    nearest = np.array([found[np.abs(found - begin).argmin()] for begin in settled])
    assert len(settled) >= 4 and np.abs(nearest - settled).max() <= 1


@pytest.mark.parametrize("drift", [-4, 4])
def test_drift__is_followed_within_what_it_is_from_sync0_to_sync0(drift: int) -> None:
    """drift: clocks by which each SYNC0 comes later than a multiple of the period."""
    count = 40
    begins = TICKS * PERIOD + (TICKS * PERIOD + drift) * np.arange(count)
    clocks = int(begins[-1]) + 2 * PERIOD
    found = ticks(1, pulses(begins, clocks), clocks)
    apart = np.diff(found)
    assert np.abs(apart - PERIOD).max() <= SLEW
    nearest = np.array([found[np.abs(found - begin).argmin()] for begin in begins])
    assert np.abs(nearest - begins)[4:].max() <= abs(drift) + 1
    assert set(np.diff(np.searchsorted(found, nearest))) == {TICKS}
