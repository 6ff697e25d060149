# SPDX-License-Identifier: Apache-2.0
"""What `asip-model --best` reaches on the shown laws: rows of `make goals T=robots`."""

from __future__ import annotations

from collections.abc import Iterator

from asip_asm.model.compiler import Options
from sim.bench.certificate_goals import subjects
from sim.laws.asip_model.effects import Forms, allowed_sets, words
from sim.report.goals import Goal, at_most, not_measured

ABOVE = 5.0
"""Percent by which a program may be longer than its lower bound."""
QUICK = ("scara", "quadrotor", "pendulum", "current loop 0")


def rows(full: bool) -> Iterator[Goal]:
    """Of each law the cycles above the lower bound. That no set of options is shorter needs no row:
    the program is the shortest of all of them.
    """
    for name, subject in subjects().items():
        if not full and name not in QUICK:
            cure = "measured by RUN=full"
            yield not_measured(f"{name}, --best above bound", f"<= {ABOVE:g}", cure, "%")
            continue
        ranked = Forms(subject.law()).ranked(allowed_sets(Options(), None, None, None))
        best, last = ranked[0], ranked[-1]
        note = (
            f"{best.cycles} cycles with {words(best.compiled.options)}, at most {last.cycles} with "
            f"{words(last.compiled.options)}"
        )
        above = 100 * (best.cycles / best.bound_cycles - 1)
        yield at_most(f"{name}, --best above bound", above, ABOVE, "%", note)
