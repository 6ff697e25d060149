# SPDX-License-Identifier: Apache-2.0
"""What `asip-model --best` reaches on the shown laws: rows of `make goals T=robots`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from asip_asm.model.compiler import Options
from sim.bench import law_results
from sim.bench.certificate_goals import subjects
from sim.laws.asip_model.effects import Forms, allowed_sets, words
from sim.report.goals import Goal, at_most, exactly, not_measured

ABOVE = 5.0
"""Percent by which a program may be longer than its lower bound."""
QUICK = ("scara", "quadrotor", "pendulum", "current loop 0")


SINGLE = (
    Options(),
    Options(reassociate=True),
    Options(reciprocal=True),
    Options(sine="unit"),
    Options(sine="pipes"),
)
"""No option, and each by itself."""


def measure(law_name: str) -> dict[str, Any]:
    """Cycles and lower bound of `--best`, its options, the slowest set, and single options."""
    forms = Forms(subjects()[law_name].law())
    ranked = forms.ranked(allowed_sets(Options(), None, None, None))
    best, last = ranked[0], ranked[-1]
    return {
        "cycles": best.cycles,
        "bound": best.bound_cycles,
        "options": words(best.compiled.options),
        "most": last.cycles,
        "most_options": words(last.compiled.options),
        "single": [built.cycles for built in map(forms.build, SINGLE) if built],
    }


def rows(full: bool) -> Iterator[Goal]:
    """Of each law the cycles above the lower bound; and the laws that one option alone makes
    shorter than `--best` does.
    """
    laws = [name for name in subjects() if full or name in QUICK]
    found = law_results.results(f"{__name__}:measure", laws)
    for name in subjects():
        what = f"{name}, --best above bound"
        if name not in found:
            yield not_measured(what, f"<= {ABOVE:g}", "%", "make goals T=robots RUN=full")
            continue
        best = found[name]
        note = (
            f"{best['cycles']} cycles with {best['options']}, at most {best['most']} with "
            f"{best['most_options']}, {min(best['single'])} to {max(best['single'])} with one "
            "option or none"
        )
        yield at_most(what, 100 * (best["cycles"] / best["bound"] - 1), ABOVE, "%", note)
    longer = [
        f"{name}: {best['cycles']}, not {min(best['single'])}"
        for name, best in found.items()
        if best["cycles"] > min(best["single"])
    ]
    what = f"of {len(found)} laws, those that one option makes shorter than --best"
    yield exactly(what, len(longer), 0, "laws", "; ".join(longer))
