# SPDX-License-Identifier: Apache-2.0
"""The pairs of programs in docs/fast_programs.md: the second of each takes fewer cycles."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from sim import Core
from tests.asip.core_bench import assembled

PAGE = Path(__file__).parents[2] / "docs/fast_programs.md"
PROGRAMS = re.findall(r'```\n(\.program "([^"]+)".*?)```', PAGE.read_text(), re.S)
PAIRS = list(zip(PROGRAMS[::2], PROGRAMS[1::2], strict=True))
# Sums and products are exact, the quotient is a small integer: both of a pair give the same bits.
INPUTS = {"a": 2.0, "b": 1.0, "c": 0.5, "d": 4.0, "x": 0.75, "limit": 1.5}


def run(text: str) -> tuple[int, int]:
    """CYCLES and the word of output F."""
    with Core(assembled(text, optimise=True)) as core:
        core.tick({name: INPUTS.get(name, 1.0) for name in core.inputs})
        return core.cycles, core.read_word("F")


def test_page__holds_pairs_of_programs():
    assert len(PAIRS) > 5


@pytest.mark.parametrize(("slow", "fast"), PAIRS, ids=[fast[1] for _, fast in PAIRS])
def test_pair__on_the_core__same_result_in_fewer_cycles(slow, fast):
    slow_cycles, slow_word = run(slow[0])
    fast_cycles, fast_word = run(fast[0])
    assert fast_word == slow_word
    assert fast_cycles < slow_cycles
