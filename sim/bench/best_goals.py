# SPDX-License-Identifier: Apache-2.0
"""What `asip-model --best` reaches on the shown laws: rows of `make goals T=robots`."""

from __future__ import annotations

from collections.abc import Iterator

from asip_asm.model.compiler import Options
from sim.bench.certificate_goals import subjects
from sim.laws.asip_model.effects import Forms, allowed_sets, words
from sim.report.goals import Goal, at_most, exactly, not_measured, paced

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


def rows(full: bool) -> Iterator[Goal]:
    """Of each law the cycles above the lower bound; and the laws that one option alone makes
    shorter than `--best` does.
    """
    longer: list[str] = []
    tried = 0
    for name, subject in paced(list(subjects().items()), "laws with every set of options"):
        if not full and name not in QUICK:
            cure = "make goals T=robots RUN=full"
            yield not_measured(f"{name}, --best above bound", f"<= {ABOVE:g}", "%", cure)
            continue
        forms = Forms(subject.law())
        ranked = forms.ranked(allowed_sets(Options(), None, None, None))
        best, last = ranked[0], ranked[-1]
        singles = [built.cycles for built in map(forms.build, SINGLE) if built]
        note = (
            f"{best.cycles} cycles with {words(best.compiled.options)}, at most {last.cycles} with "
            f"{words(last.compiled.options)}, {min(singles)} to {max(singles)} with one option or "
            "none"
        )
        above = 100 * (best.cycles / best.bound_cycles - 1)
        yield at_most(f"{name}, --best above bound", above, ABOVE, "%", note)
        tried += 1
        if best.cycles > min(singles):
            longer.append(f"{name} {best.cycles} instead of {min(singles)}")
    what = f"of {tried} laws, those that one option makes shorter than --best"
    yield exactly(what, len(longer), 0, "laws", "; ".join(longer))
