# SPDX-License-Identifier: Apache-2.0
"""Proofs of the line interpolators: every node against the exact line, for lengths of all bits.

With N steps to the end and lengths a, b of the axes, the node n_u, n_v after n steps is off the
ideal point (n a / N, n b / N) by F / N in each axis (elementary steps, N = a + b), with
F = a n_v - b n_u, or in the shorter axis (combined ones, N = max(a, b)). With the steps left,
r_u = a - n_u and r_v = b - n_v, F is b r_u - a r_v. The observers add F up, b less for a step in u
and a more for one in v; `line_facts` proves that this is b r_u - a r_v, and what F is where an axis
has no steps left, which the induction takes as given.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bitwuzla import Term

from tests.formal import logic
from tests.formal.catalogue import Case, Context, proof
from tests.formal.induction import Observer, Values, inductive, selected
from tests.formal.integers import Int, Truth, always, flag, signed
from tests.formal.netlist import Run

WIDTH = 24  # of a length, with sign: the default of the interpolators
STEPS = WIDTH + 2  # of numbers of steps, signed
OFF = WIDTH + 4  # of F, signed


def facts(a: Int, b: Int, left_u: Int, left_v: Int, f: Int) -> Truth:
    """Of F = b left_u - a left_v where one of the axes has no steps left, lengths not negative."""
    none_u, none_v, some_u, some_v = left_u.same(0), left_v.same(0), left_u > 0, left_v > 0
    return (
        (none_u & none_v).implies(f.same(0))
        & (none_u & some_v).implies(f <= -a)
        & (some_u & none_v).implies(f >= b)
    )


def line_facts() -> Iterator[Case]:
    """What the observers add up is F, and `facts` hold of it."""
    room = 2 * WIDTH + 2
    names = ("a", "b", "left_u", "left_v")
    a, b, left_u, left_v = (logic.extend(logic.free(WIDTH, name), room) for name in names)
    show = dict(zip(names, (a, b, left_u, left_v), strict=True))

    def f(left_u: Term, left_v: Term) -> Term:
        return logic.sub(*(logic.mul(x, y) for x, y in ((b, left_u), (a, left_v))))

    one = logic.bv(room, 1)
    step_u = logic.eq(f(logic.sub(left_u, one), left_v), logic.sub(f(left_u, left_v), b))
    step_v = logic.eq(f(left_u, logic.sub(left_v, one)), logic.add(f(left_u, left_v), a))
    yield Case("a step in u takes b off F", step_u, (), show)
    yield Case("a step in v adds a to F", step_v, (), show)
    yield Case("F is 0 at the start", logic.eq(f(a, b), 0), (), show)
    numbers = (Int(term) for term in (a, b, left_u, left_v, f(left_u, left_v)))
    claim = facts(*numbers).term
    for name, left in (("u", left_u), ("v", left_v)):
        yield Case(f"F with no steps left in {name}", claim, (logic.eq(left, 0),), show)


class Line(Observer):
    """The job, the steps left in each axis, F, and the position reached."""

    widths = {
        "started": 1,
        "negative": 2,  # of the job: {v, u}
        "size_u": WIDTH,
        "size_v": WIDTH,
        "at_u": STEPS,
        "at_v": STEPS,
        "left_u": STEPS,
        "left_v": STEPS,
        "off": OFF,
    }

    def sizes(self, own: Values) -> tuple[Int, Int]:
        return tuple(Int.unsigned(own[name]) for name in ("size_u", "size_v"))

    def next(self, run: Run, own: Values) -> Values:
        start = flag(run.input("start_i"))
        steps = flag(run.input("advance_i")) & flag(run.output("active_o", 0))
        off, factors = Int(own["off"]), self.sizes(own)
        ends = [Int(run.input(f"end_{axis}_i")) for axis in "uv"]
        after, fresh = {}, {"started": logic.bv(1, 1), "off": logic.bv(OFF, 0)}
        for index, axis in enumerate("uv"):
            moves = steps & Truth(logic.bit(run.output("step_o", 0), index))
            back = Truth(logic.bit(run.output("negative_o", 0), index))
            at, left = signed(own, f"at_{axis}", f"left_{axis}")
            one = Int(logic.bv(2, 1))
            at, left = at + moves.ite(back.ite(-one, one), 0), left - moves.ite(one, 0)
            off = off + moves.ite(factors[0] if axis == "v" else -factors[1], 0)
            after |= {f"at_{axis}": at.bits(STEPS), f"left_{axis}": left.bits(STEPS)}
            size = ends[index].size()
            fresh |= {f"size_{axis}": size.bits(WIDTH), f"left_{axis}": size.bits(STEPS)}
            fresh |= {f"at_{axis}": logic.bv(STEPS, 0)}
        after["off"] = off.bits(OFF)
        fresh["negative"] = logic.vector((ends[1] < 0).term, (ends[0] < 0).term)
        return selected(start.term, fresh, {**own, **after})

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        ends = [Int(run.input(f"end_{axis}_i")) for axis in "uv"]
        inside = [(end > -(1 << (WIDTH - 1))).term for end in ends]
        known = facts(*self.sizes(own), *signed(own, "left_u", "left_v", "off"))
        return {"lengths": logic.all(*inside), "facts": known.term}

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        started = flag(own["started"])
        combined = flag(run.signal("combined_q", cycle))
        swapped = flag(run.signal("swapped_q", cycle))
        a, b = self.sizes(own)
        long, short = (Int.unsigned(run.signal(name, cycle)) for name in ("long_q", "short_q"))
        left_u, left_v, off, at_u, at_v = signed(own, "left_u", "left_v", "off", "at_u", "at_v")
        error = Int(run.signal("error_q", cycle))
        left = Int.unsigned(run.signal("left_q", cycle))
        parts = {
            "the job": combined.pick(long >= short, ~swapped)
            & swapped.pick(long.same(b) & short.same(a), long.same(a) & short.same(b))
            & Truth(logic.eq(run.output("negative_o", cycle), own["negative"])),
            "error register, elementary": combined | error.same(a - b + off.twice()),
            "error register, combined, u longer": (combined & ~swapped).implies(
                error.same(b.twice() - a - off.twice())
            ),
            "error register, combined, v longer": (combined & swapped).implies(
                error.same(a.twice() - b + off.twice())
            ),
            "each node within half a step per axis": self.near(combined, a, b, off),
            "steps left": left.same(combined.ite(swapped.ite(left_v, left_u), left_u + left_v)),
            "no axis goes beyond": (left_u >= 0) & (left_v >= 0) & (left_u <= a) & (left_v <= b),
            "position": always(),
        }
        for index, (at, size, rest) in enumerate(((at_u, a, left_u), (at_v, b, left_v))):
            back = Truth(logic.bit(own["negative"], index))
            parts["position"] &= at.same(back.ite(rest - size, size - rest))
        held = {name: started.implies(part).term for name, part in parts.items()}
        return held | {"before a job": (started | left.same(0)).term}

    def near(self, combined: Truth, a: Int, b: Int, off: Int) -> Truth:
        """|2 F| <= N"""
        count = combined.ite((a < b).ite(b, a), a + b)
        return (off.twice() <= count) & (off.twice() >= -count)

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        started = flag(own["started"])
        combined = flag(run.signal("combined_q", 0))
        active = flag(run.output("active_o", 0))
        a, b = self.sizes(own)
        step = run.output("step_o", 0)
        step_u, step_v = (Truth(logic.bit(step, index)) for index in (0, 1))
        begins = flag(run.input("start_i"))
        advances = flag(run.input("advance_i")) & active
        left = [Int.unsigned(run.signal("left_q", cycle)) for cycle in (0, 1)]
        ends = [Int(run.input(f"end_{axis}_i")) for axis in "uv"]
        new_u, new_v = (end.size() for end in ends)
        wanted = flag(run.input("combined_i"))
        taken = wanted.ite((new_u < new_v).ite(new_v, new_u), new_u + new_v)
        reached = always()
        for axis, size, back in zip("uv", (a, b), (0, 1), strict=True):
            end = Truth(logic.bit(own["negative"], back)).ite(-size, size)
            reached &= Int(own[f"at_{axis}"]).same(end)
        rule = combined.pick((a < b).pick(step_v, step_u), ~step_u.matches(step_v))
        claims = {
            "ends at the end": (started & ~active).implies(reached),
            "one axis per elementary step, the longer one always per combined step": (
                started & active
            ).implies(rule),
            "as many steps as stated": left[1].same(
                begins.ite(taken, left[0] - Int.count(advances))
            ),
            "active_o while steps are left": active.matches(left[0] > 0),
            "no step without a job": active | ~(step_u | step_v),
        }
        return {name: claim.term for name, claim in claims.items()}


@proof(
    "line_interpolator",
    "the error register is the exact equation of the line; each node is within half a step per "
    "axis of the ideal point; no axis goes back or beyond; the steps are as many as stated, of one "
    "axis or with the longer one always; the last ends at the end",
    "all lengths of 24 bits but -2^23, all directions, both modes, any pauses and restarts",
)
def line_nodes(ctx: Context) -> Iterator[Case]:
    yield from line_facts()
    yield from inductive(ctx, "line_interpolator", Line())


AXES = 5


class Synchronised(Observer):
    """One axis of the line: its job, its steps left, the steps left of the longest axis, and
    F = left longest - left_longest size, which the facts of a line give for lengths size, longest.
    """

    widths = {
        "started": 1,
        "negative": 1,
        "size": WIDTH,
        "longest": WIDTH,
        "left": STEPS,
        "left_longest": STEPS,
        "off": OFF,
    }

    def __init__(self, axis: int) -> None:
        self.axis = axis

    def lengths(self, term: Term) -> list[Int]:
        """Parts of a bit vector, signed."""
        return [
            Int(logic.bits(term, WIDTH * axis + WIDTH - 1, WIDTH * axis)) for axis in range(AXES)
        ]

    def numbers(self, own: Values) -> tuple[Int, ...]:
        """Size, longest, left, left_longest, off."""
        unsigned = (Int.unsigned(own[name]) for name in ("size", "longest"))
        return (*unsigned, *signed(own, "left", "left_longest", "off"))

    def longest(self, sizes: list[Int]) -> Int:
        most = sizes[0]
        for other in sizes[1:]:
            most = (most < other).ite(other, most)
        return most

    def next(self, run: Run, own: Values) -> Values:
        begins = flag(run.input("start_i"))
        lengths = self.lengths(run.input("lengths_i"))
        sizes = [each.size() for each in lengths]
        size, longest, left, left_longest, off = self.numbers(own)
        steps = flag(run.input("advance_i")) & flag(run.output("ready_o", 0))
        moves = steps & Truth(logic.bit(run.output("step_o", 0), self.axis))
        fresh = {
            "started": logic.bv(1, 1),
            "negative": logic.vector((lengths[self.axis] < 0).term),
            "size": sizes[self.axis].bits(WIDTH),
            "longest": self.longest(sizes).bits(WIDTH),
            "left": sizes[self.axis].bits(STEPS),
            "left_longest": self.longest(sizes).bits(STEPS),
            "off": logic.bv(OFF, 0),
        }
        going_on = {
            "left": (left - Int.count(moves)).bits(STEPS),
            "left_longest": (left_longest - Int.count(steps)).bits(STEPS),
            "off": (off + steps.ite(size, 0) - moves.ite(longest, 0)).bits(OFF),
        }
        return selected(begins.term, fresh, {**own, **going_on})

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        lengths = self.lengths(run.input("lengths_i"))
        idle = ~flag(run.output("active_o", 0))
        contract = flag(run.input("start_i")).implies(idle)
        for length in lengths:
            contract &= length > -(1 << (WIDTH - 1))
        return {"contract": contract.term, "facts": facts(*self.numbers(own)).term}

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        started = flag(own["started"])
        measures, places = (flag(run.signal(name, cycle)) for name in ("measure_q", "place_q"))
        runs = started & ~measures & ~places
        size, longest, left, left_longest, off = self.numbers(own)
        sizes = self.lengths(run.signal("size_q", cycle))  # below 2^23
        found = Int.unsigned(run.signal("longest_q", cycle))
        at = Int.unsigned(run.signal("axis_q", cycle))
        behind = Int(run.signal(f"gen_axis[{self.axis}].behind_q", cycle))
        ahead = Int.unsigned(run.signal(f"gen_axis[{self.axis}].ahead_q", cycle))
        waiting = Int.unsigned(run.signal("left_q", cycle))
        way = logic.bits(run.output("negative_o", cycle), self.axis, self.axis)
        job = sizes[self.axis].same(size) & self.longest(sizes).same(longest)
        job &= Truth(logic.eq(way, own["negative"]))
        searched = at.same(0).implies(found.same(0))
        for axis, each in enumerate(sizes):
            job &= each >= 0
            searched &= at.same(axis + 1).implies(found.same(self.longest(sizes[: axis + 1])))
        whole = left.same(size) & left_longest.same(longest) & off.same(0)
        parts = {
            "the job": started.implies(job),
            "the longest axis so far": measures.implies(started & (at < AXES) & searched),
            "the longest axis": (places | runs).implies(started & found.same(longest)),
            "either": ~(measures & places) & places.implies(at < AXES),
            "no step before": (runs & (longest > 0)) | (waiting.same(0) & started.implies(whole)),
            "registers of the axis": ((runs & (longest > 0)) | (places & (at > self.axis))).implies(
                ahead.same(longest - size) & behind.same(off.twice() + size.twice() - longest)
            ),
            "each node within half a step of the line": started.implies(
                (off.twice() <= longest) & (off.twice() >= -longest)
            ),
            "strictly below the middle": (started & (longest > 0)).implies(off.twice() < longest),
            "steps left": runs.implies(waiting.same(left_longest)),
            "steps left in range": started.implies(
                (left >= 0) & (left <= size) & (left_longest >= 0) & (left_longest <= longest)
            ),
        }
        return {name: part.term for name, part in parts.items()}

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        started = flag(own["started"])
        active, ready = (flag(run.output(f"{name}_o", 0)) for name in ("active", "ready"))
        size, longest, left, *_ = self.numbers(own)
        step = Truth(logic.bit(run.output("step_o", 0), self.axis))
        claims = {
            "all steps made at the end": (started & ~active).implies(left.same(0)),
            "the longest axis always moves": (ready & size.same(longest)).implies(step),
            "no step without a line": ready | ~step,
        }
        return {name: claim.term for name, claim in claims.items()}


@proof(
    "synchronised_line",
    "every axis makes exactly its steps while the longest makes all of its own, and each node is "
    "within half a step of the ideal line in every axis",
    "all lengths of 24 bits but -2^23, five axes, any pauses",
)
def synchronised_nodes(ctx: Context) -> Iterator[Case]:
    yield from line_facts()
    for axis in range(AXES):
        yield from inductive(ctx, "synchronised_line", Synchronised(axis), None, f"axis {axis}, ")
