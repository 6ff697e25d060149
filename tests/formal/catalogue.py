# SPDX-License-Identifier: Apache-2.0
"""What a proof is: cases, planted faults (faults.toml), and the list that the other modules fill.

A proof yields cases; a case claims that its assumptions imply a property for all values of the
free bit vectors. Where the cases split the inputs, a case of its own claims that they cover them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from bitwuzla import Term

from sim.rtl.sources import sources_of
from tests.bench.faults import Fault, load
from tests.formal import ieee, logic
from tests.formal.ieee import Outcome
from tests.formal.netlist import Netlist, Run, elaborate

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Case:
    """`assume` implies `claim`; `show` are the bit vectors that a counterexample lists."""

    name: str
    claim: Term
    assume: tuple[Term, ...] = ()
    show: Mapping[str, Term] = field(default_factory=dict)


@cache
def all_faults() -> list[Fault]:
    """The table of planted faults. Raises TableError."""
    return load(HERE / "faults.toml")


@dataclass(frozen=True)
class Context:
    """Where a proof has its modules from. `rtl` has the sources, `build` takes netlists."""

    rtl: Path
    build: Path

    def run(
        self, top: str, parameters: Mapping[str, int] | None = None, cut: tuple[str, ...] = ()
    ) -> Run:
        """Symbolic run of a module."""
        text = elaborate(top, sources_of(top, (self.rtl, HERE)), self.build, parameters)
        return Run(Netlist(text), cut)


def delivers(
    name: str, run: Run, latency: int, outcome: Outcome, assume: tuple[Term, ...] = ()
) -> Case:
    """Result, flags and valid of a unit `latency` cycles after its operands."""
    result, flags, valid = (
        run.output(port, latency) for port in ("result_o", "flags_o", "valid_o")
    )
    claim = logic.all(ieee.matches(result, flags, outcome), logic.eq(valid, run.input("valid_i")))
    show = {port: run.input(port) for port in run.netlist.inputs if port.endswith("_i")}
    show |= {"result_o": result, "flags_o": flags, "expected flags": outcome.flags}
    return Case(name, claim, assume, show)


@dataclass(frozen=True)
class Proof:
    """One line of the table in docs/formal.md."""

    name: str
    unit: str
    claim: str
    inputs: str
    cases: Callable[[Context], Iterator[Case]]
    timeout: int = 120  # seconds per case
    quick: bool = False  # also run by make test

    @property
    def faults(self) -> list[Fault]:
        """Those of faults.toml that a case must refute."""
        return [fault for fault in all_faults() if self.name in fault.found]


PROOFS: list[Proof] = []


def proof(unit: str, claim: str, inputs: str, **options: bool | int) -> Callable:
    """Register the decorated function, a generator of cases, as a proof of its own name."""

    def register(cases: Callable[[Context], Iterator[Case]]) -> Callable:
        PROOFS.append(Proof(cases.__name__, unit, claim, inputs, cases, **options))
        return cases

    return register


def covered(
    splits: list[tuple[str, tuple[Term, ...]]],
    run: Run,
    latency: int,
    outcome: Outcome,
    given: tuple[Term, ...] = (),
) -> Iterator[Case]:
    """A case per split and one that claims that `given` implies at least one of them."""
    yield Case(
        "the cases cover all inputs",
        logic.any(*(logic.all(*terms) for _, terms in splits)),
        given,
    )
    for name, terms in splits:
        yield delivers(name, run, latency, outcome, (*given, *terms))


def exponent_of(bits: Term, width: int = 10) -> Term:
    """Biased exponent of a binary32 number, that of the least normal for subnormals and zero."""
    field = logic.bits(bits, 30, 23)
    return logic.extend(logic.ite(logic.eq(field, 0), logic.bv(8, 1), field), width)


def significand_of(bits: Term, width: int = 24) -> Term:
    """Significand as an integer, hidden bit included."""
    hidden = logic.vector(logic.ne(logic.bits(bits, 30, 23), 0))
    return logic.extend(logic.cat(hidden, logic.bits(bits, 22, 0)), width)
