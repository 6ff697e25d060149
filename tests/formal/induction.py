# SPDX-License-Identifier: Apache-2.0
"""Invariants of a unit, proved for every clock after reset by induction.

An observer is a machine next to the unit: registers of its own, which it computes from the unit's
ports and which the claims are about (clocks since an edge, the position reached, a running sum). A
proof has a case that reset makes the invariant true, and for each of its parts a case that one
clock from any state in which all of it holds, with any inputs that the contract allows, keeps the
part. Claims may also compare the two cycles of that clock.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Protocol

from bitwuzla import Term

from tests.formal import logic
from tests.formal.catalogue import Case, Context
from tests.formal.netlist import Run

Values = Mapping[str, Term]
Splits = Callable[[Run, Values], Mapping[str, tuple[Term, ...]]]


class Observer(Protocol):
    """What `inductive` needs of an observer. Bit vectors in `Values` are its registers."""

    widths: Mapping[str, int]  # its registers
    reset: Mapping[str, int] = {}  # those that are not 0 after reset

    def after_reset(self) -> Values:
        """Its registers after reset."""
        return {name: logic.bv(bits, self.reset.get(name, 0)) for name, bits in self.widths.items()}

    def next(self, run: Run, own: Values) -> Values:
        """Its registers after the clock edge between cycles 0 and 1."""

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        """Contract of the inputs in cycles 0 and 1, and facts about numbers proved apart."""
        return {}

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        """What holds in every cycle, part by part."""

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        """What else holds of cycle 0 and of the edge to cycle 1."""
        return {}


def selected(condition: Term, then: Values, other: Values) -> Values:
    """Registers of one of two."""
    return {name: logic.ite(condition, value, other[name]) for name, value in then.items()}


def older(age: Term) -> Term:
    """A count of clocks a clock later; it stays at its greatest value."""
    most = logic.bv(logic.width(age), -1)
    return logic.ite(logic.eq(age, most), most, logic.add(age, 1))


def inductive(
    ctx: Context,
    top: str,
    observer: Observer,
    parameters: Mapping[str, int] | None = None,
    prefix: str = "",
    splits: Splits | None = None,
    split: Collection[str] = (),
    needed: Mapping[str, Collection[str]] | None = None,
) -> Iterator[Case]:
    """The cases of an observer's invariant and claims.

    `splits` divides the states of cycle 0; the parts of the invariant in `split` are proved for
    each division, and a case of its own shows that there is no state outside. `needed` names the
    assumptions (contract, facts, parts of the invariant) for divided cases whose names begin so;
    fewer of them only make a proof harder to find, or easier for the solver.
    """
    run = ctx.run(top, parameters)
    started = Run(run.netlist, reset=(0,))
    show = {f"{port}": run.input(port) for port in run.netlist.inputs if port != "clk_i"}
    first = observer.invariant(started, observer.after_reset(), 1)
    yield Case(f"{prefix}after reset", logic.all(*first.values()))
    no_flush: tuple[Term, ...] = ()
    if "flush_i" in run.netlist.inputs:
        flush = run.on("flush_i")
        no_flush = (logic.no(flush),)
        dropped = observer.invariant(run, observer.after_reset(), 1)
        yield Case(f"{prefix}after a flush", logic.all(*dropped.values()), (flush,), show)

    own = {name: logic.free(width, name) for name, width in observer.widths.items()}
    then = observer.next(run, own)
    known = {**observer.assumed(run, own, then), **observer.invariant(run, own, 0)}
    assume = (*known.values(), *no_flush)
    show |= own
    divisions, needed = splits(run, own) if splits else {}, needed or {}
    if divisions:
        cover = logic.any(*(logic.all(*terms) for terms in divisions.values()))
        yield Case(f"{prefix}the cases cover all states", cover, assume, show)
    wanted = {f"kept: {name}": term for name, term in observer.invariant(run, then, 1).items()}
    wanted |= observer.claims(run, own, then)
    divided = [f"kept: {name}" for name in split]
    for name, claim in wanted.items():
        if name not in divided:
            yield Case(f"{prefix}{name}", claim, assume, show)
    for name in divided:
        for division, terms in divisions.items():
            full = f"{name}: {division}"
            names = next((n for key, n in needed.items() if full.startswith(key)), known)
            used = [known[each] for each in names]
            yield Case(f"{prefix}{full}", wanted[name], (*terms, *used, *no_flush), show)
