# SPDX-License-Identifier: Apache-2.0
"""Proof of quadrature_decoder: its count is the true position for any legal lines with any jitter.

The encoder is at a true position; each clock it moves by one at most, and a line changes only if it
held its level for filter_i + 1 clocks. The observer has the positions that belong to the lines
after each register (p1, p2), after the filter (p3) and after the count (p4), and how long each
line has had its level there. Where both lines wait for the filter, the one that has waited
longer changed first, which gives the direction.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bitwuzla import Term

from tests.formal import logic
from tests.formal.catalogue import Case, Context, proof
from tests.formal.induction import Observer, Values, inductive, older
from tests.formal.netlist import Run

FILTER, AGE = 4, 5  # bits of filter_i; of a saturating count, above filter_i + 5
A, B = 0, 1
META, LINE, LEVEL, PREV = range(4)  # bits of settled_q: this register holds what it should


class TruePosition(Observer):
    """Positions p0 .. p4, ages of both lines at the stages 0 .. 2, and the position at reset."""

    widths = {
        **{f"p{stage}": 32 for stage in range(5)},
        **{f"age{line}{stage}": AGE for line in "ab" for stage in range(3)},
        "zero": 32,
    }

    def after_reset(self) -> Values:
        anywhere = logic.free(32, "first position")
        positions = {name: anywhere for name, width in self.widths.items() if width == 32}
        return positions | {name: logic.bv(AGE, -1) for name in self.widths if "age" in name}

    # ---- words of the specification ----
    def level(self, position: Term, line: int) -> Term:
        """A is high at 1 and 2, B at 2 and 3, modulo 4."""
        low, high = logic.bit(position, 0), logic.bit(position, 1)
        return logic.vector(high if line == B else logic.ne(low, high))

    def lines(self, position: Term) -> Term:
        """{b, a}"""
        return logic.cat(self.level(position, B), self.level(position, A))

    def differs(self, one: Term, other: Term, line: int) -> Term:
        return logic.ne(self.level(one, line), self.level(other, line))

    def near(self, one: Term, other: Term) -> Term:
        step = logic.sub(one, other)
        return logic.any(*(logic.eq(step, way) for way in (-1, 0, 1)))

    def way(self, position: Term, line: int) -> Term:
        """Where the line changes next to a position: 1 if there is it above, else -1."""
        up = self.differs(position, logic.add(position, 1), line)
        return logic.ite(up, logic.bv(32, 1), logic.bv(32, -1))

    def settled(self, run: Run, stage: int, cycle: int) -> Term:
        return logic.bit(run.signal("settled_q", cycle), stage)

    def filter_plus(self, run: Run, clocks: int, cycle: int = 0) -> Term:
        return logic.add(logic.extend(run.input("filter_i", cycle), AGE), clocks)

    # ---- the observer ----
    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        given = logic.cat(run.input("b_i"), run.input("a_i"))
        enough = logic.all(
            *(
                logic.implies(
                    self.differs(own["p0"], then["p0"], line),
                    logic.ule(self.filter_plus(run, 1), own[f"age{name}0"]),
                )
                for line, name in enumerate("ab")
            )
        )
        return {
            "lines": logic.eq(given, self.lines(own["p0"])),
            "each level long enough": enough,
            "same filter": logic.eq(run.input("filter_i", 0), run.input("filter_i", 1)),
        }

    def next(self, run: Run, own: Values) -> Values:
        choice = logic.free(2, "move")
        move = logic.ite(
            logic.eq(choice, 0),
            logic.bv(32, 1),
            logic.ite(logic.eq(choice, 1), logic.bv(32, -1), logic.bv(32, 0)),
        )
        p0 = logic.add(own["p0"], move)
        taken = [
            logic.ne(
                logic.bit(run.signal("level_q", 1), line), logic.bit(run.signal("level_q", 0), line)
            )
            for line in (A, B)
        ]
        one_line = logic.ite(taken[A], self.way(own["p3"], A), self.way(own["p3"], B))
        filtered = logic.ite(logic.any(*taken), logic.add(own["p3"], one_line), own["p3"])
        found = {
            "p0": p0,
            "p1": own["p0"],
            "p2": own["p1"],
            "p3": logic.ite(self.settled(run, PREV, 0), filtered, own["p2"]),
            "p4": own["p3"],
            "zero": logic.ite(self.settled(run, PREV, 0), own["zero"], own["p3"]),
        }
        for line, name in enumerate("ab"):
            age = own[f"age{name}0"]
            changed = self.differs(own["p0"], p0, line)
            found[f"age{name}0"] = logic.ite(changed, logic.bv(AGE, 1), older(age))
            found[f"age{name}1"], found[f"age{name}2"] = age, own[f"age{name}1"]
        return found

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        bits = run.signal("settled_q", cycle)
        parts = {
            "settles in order": logic.any(*(logic.eq(bits, (1 << n) - 1) for n in range(5))),
            "steps": logic.all(self.near(own["p0"], own["p1"]), self.near(own["p1"], own["p2"])),
            "nothing illegal": logic.all(
                logic.eq(run.output("illegal_o", cycle), 0),
                logic.eq(run.output("illegal_count_o", cycle), 0),
            ),
        }
        for stage, name, position in (
            (META, "meta_q", "p1"),
            (LINE, "line_q", "p2"),
            (LEVEL, "level_q", "p3"),
            (PREV, "prev_q", "p4"),
        ):
            pair = logic.bits(run.signal(name, cycle), 1, 0)
            holds = logic.eq(pair, self.lines(own[position]))
            parts[f"{name} is of {position}"] = logic.implies(
                self.settled(run, stage, cycle), holds
            )
        counted = logic.ite(
            self.settled(run, PREV, cycle), logic.sub(own["p4"], own["zero"]), logic.bv(32, 0)
        )
        parts["count"] = logic.eq(run.output("position_o", cycle), counted)
        return parts | self.ages(run, own, cycle) | self.waiting(run, own, cycle)

    def ages(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        """A level ends after filter + 1 clocks at least; the next one then has age 1."""
        found = []
        for line, name in enumerate("ab"):
            for new, old in ((0, 1), (1, 2)):
                young, age = own[f"age{name}{new}"], own[f"age{name}{old}"]
                changed = self.differs(own[f"p{new}"], own[f"p{old}"], line)
                ended = logic.all(
                    logic.eq(young, 1), logic.ule(self.filter_plus(run, 1, cycle), age)
                )
                found.append(logic.ite(changed, ended, logic.eq(young, older(age))))
            found.append(logic.ne(own[f"age{name}2"], 0))
        return {"ages": logic.all(*found)}

    def waiting(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        """What the filter has not let through yet, and what it has just let through."""
        pending, lasted = [], []
        clean = []
        for line, name in enumerate("ab"):
            waits = self.differs(own["p2"], own["p3"], line)
            count = run.signal(f"lasted_q[{line}]", cycle)
            age = own[f"age{name}2"]
            clocks = logic.add(logic.extend(count, AGE), 1)
            pending.append(waits)
            lasted.append(count)
            served = logic.all(
                logic.eq(age, clocks), logic.ule(count, run.input("filter_i", cycle))
            )
            clean.append(logic.ite(waits, served, logic.eq(count, 0)))
            fresh = self.differs(own["p3"], own["p4"], line)
            recent = logic.ule(age, self.filter_plus(run, 2, cycle))
            clean.append(logic.implies(logic.all(self.settled(run, PREV, cycle), fresh), recent))
        ahead = logic.sub(own["p2"], own["p3"])
        ways = [self.way(own["p3"], line) for line in (A, B)]
        first = logic.ite(logic.ult(lasted[B], lasted[A]), ways[A], ways[B])
        both = logic.all(logic.ne(lasted[A], lasted[B]), logic.eq(ahead, logic.add(first, first)))
        one = logic.eq(ahead, logic.ite(pending[A], ways[A], ways[B]))
        far = logic.ite(
            logic.all(*pending),
            both,
            logic.ite(logic.any(*pending), one, logic.eq(ahead, 0)),
        )
        level = self.settled(run, LEVEL, cycle)
        unsettled = logic.no(self.settled(run, PREV, cycle))
        idle = logic.all(*(logic.eq(count, 0) for count in lasted))
        return {
            "waiting lines": logic.implies(level, logic.all(*clean, far)),
            "no wait before": logic.implies(unsettled, idle),
            "one count": logic.implies(
                self.settled(run, PREV, cycle), self.near(own["p3"], own["p4"])
            ),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        rested = logic.all(
            self.settled(run, PREV, 0),
            *(logic.ule(self.filter_plus(run, 5), own[f"age{name}0"]) for name in "ab"),
        )
        true = logic.sub(own["p0"], own["zero"])
        return {
            "4 + filter clocks after the last edge the count is the position": logic.implies(
                rested, logic.eq(run.output("position_o", 0), true)
            ),
        }


@proof(
    "quadrature_decoder",
    "the count follows the encoder's true position step by step, is it 4 + filter_i clocks after "
    "the last edge, and nothing is flagged",
    "any motion and jitter in which a line keeps a level for filter_i + 1 clocks and A and B "
    "change in different clocks; any filter_i, any lines at reset, unbounded time",
    quick=True,
)
def decoder_count(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "quadrature_decoder", TruePosition())
