# SPDX-License-Identifier: Apache-2.0
"""What `asip-model --best` reaches on the shown laws: rows of `make goals T=robots`."""

from __future__ import annotations

from collections.abc import Iterator

from asip_asm.model.compiler import Options
from sim.asip_model.effects import Forms, allowed_sets, words
from sim.goals import Goal, at_most, not_measured
from sim.robots.job import SHOWN

ABOVE = 5.0
"""Percent by which a program may be longer than its lower bound."""
QUICK = ("scara", "quadrotor", "pendulum")


def rows(full: bool) -> Iterator[Goal]:
    """Of each law the cycles above the lower bound, and above the best with one option alone."""
    singles = [Options(), Options(reassociate=True), Options(reciprocal=True)]
    singles += [Options(sine="unit"), Options(sine="pipes")]
    for name, shown in SHOWN.items():
        if not full and name not in QUICK:
            cure = "measured by RUN=full"
            yield not_measured(f"{name}, --best above bound", f"<= {ABOVE:g}", cure, "%")
            continue
        forms = Forms(shown.law())
        best = forms.ranked(allowed_sets(Options(), None, None, None))[0]
        fastest = min(one.cycles for options in singles if (one := forms.build(options)))
        note = f"{best.cycles} cycles with {words(best.compiled.options)}"
        above = 100 * (best.cycles / best.bound_cycles - 1)
        yield at_most(f"{name}, --best above bound", above, ABOVE, "%", note)
        slower = best.cycles - fastest
        yield at_most(f"{name}, --best beside one option alone", slower, 0, "cycles", note)
