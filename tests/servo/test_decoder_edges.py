# SPDX-License-Identifier: Apache-2.0
"""The decoder at its highest rate, jitter and turns; 10^9 edges in `microtick drive --full`."""

from __future__ import annotations

from tests.servo.decoder_edges import illegal, legal


def test_legal_edges__the_count_is_right_in_every_clock():
    wrong, clocks = legal(1, 1_000_000)
    assert wrong == 0 and clocks > 4_000_000


def test_illegal_changes__are_flagged_and_counted_and_do_not_move():
    assert illegal(1, 1000) == 0
