# SPDX-License-Identifier: Apache-2.0
"""Goals of the workbench that the debug block itself has to reach."""

from __future__ import annotations

from collections.abc import Iterator

from sim.report.goals import Goal, depth, exactly
from tests.debug import campaigns
from tests.debug.test_scope import FAST_LINE, uart_stream

SEED = 1
FULL = "RUN=full makes them all"
DEPTH = 10_000
"""Sequences and changes that are requested; a quick form says that it made fewer."""


def same_runs(full: bool) -> Iterator[Goal]:
    """Runs with the block and without."""
    from tests.debug.test_block import plain_and_debug

    different = sum(alone != beside for alone, beside in plain_and_debug(SEED, 40 if full else 8))
    yield exactly("programs whose runs differ with the block", different, 0, "", "cycles and bits")


def halted_runs(full: bool) -> Iterator[Goal]:
    """Random halt, step, continue and read sequences."""
    found = list(campaigns.random_halts(DEPTH if full else 200, SEED))
    bad = sum(bool(text) for text in found)
    yield exactly("disturbed runs that end differently", bad, 0, "", f"of {len(found)}")
    yield depth("disturbed runs made", len(found), DEPTH, "", FULL)


def live_parameters(full: bool) -> Iterator[Goal]:
    """Changes of sixteen parameters at a time, under load."""
    changes, torn, wrong = campaigns.torn_pages(DEPTH if full else 200, SEED)
    yield exactly("torn pages of live parameters", torn, 0, "", f"of {changes} changes")
    yield depth("changes of live parameters made", changes, DEPTH, "", FULL)
    yield exactly("runs with a wrong version", wrong, 0, "", f"of {2 * changes}")


def scope(full: bool) -> Iterator[Goal]:
    """Recorded words, and the stream over the serial line."""
    pairs = list(campaigns.recorded(3000 if full else 60, SEED))
    bad = sum(got != want for got, want in pairs)
    yield exactly("recorded words that differ from the model's", bad, 0, "", f"of {len(pairs)}")
    rows, got, lost = uart_stream(3000, 10_000, 33) if full else uart_stream(120, *FAST_LINE)
    note = f"of {len(rows)}, 8 channels at 10 kHz over 3 Mbit/s"
    yield exactly("records lost on the line", lost + (got != rows), 0, "", note)
