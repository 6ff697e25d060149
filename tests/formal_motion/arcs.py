# SPDX-License-Identifier: Apache-2.0
"""Proof of arc_interpolator: every node against the exact circle, for coordinates of all bits.

With N = x^2 + y^2 - R^2 of the node x, y, the circle crosses the diagonal through the node that the
step was chosen on within half a step if -(|x| + |y|) <= N <= |x| + |y| - 1: by then it lies between
the corners (|x| +- 1/2, |y| +- 1/2), where the equation is N +- (|x| + |y|) + 1/2. Likewise it is
within half a step along the axis of the greater coordinate m if -m <= N <= m - 1. The observer has
the position by adding up the steps, and N by (x +- 1)^2 = x^2 +- 2 x + 1. The induction takes as
given how N differs between two nodes, and how far out a node can be; `circle_facts` proves both.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from bitwuzla import Term

from tests.formal import logic
from tests.formal.catalogue import Case, Context, proof
from tests.formal.induction import Observer, Values, inductive, selected
from tests.formal.integers import Int, Truth, always, flag, signed
from tests.formal.netlist import Run

WIDTH = 24  # of a coordinate, with sign: the default of the interpolator
NARROW = 12  # where 24 bits are too many for the solver
IDLE, PLACE, COUNT, DECIDE, MOVE = range(5)
OWN_FACTS, LEFT = "facts of p and q", "steps left in the last quadrant"
MANY = 3  # what differences of coordinates are known to be at least, when they are


def largest(width: int) -> int:
    """Of a given coordinate."""
    return (1 << (width - 1)) - 1


def most_squares(width: int) -> int:
    """R^2 is not above this, as N of the start is -(|x| + |y|) at least."""
    return 2 * largest(width) ** 2 + 2 * largest(width)


def farthest(width: int) -> int:
    """Greatest coordinate c with c^2 - c < R^2, which nodes with N <= |x| + |y| - 1 have."""
    return (1 + math.isqrt(4 * most_squares(width) - 3)) // 2


def about(n: Int, x: Int, y: Int) -> Truth:
    """-(x + y) <= N <= x + y - 1, magnitudes x, y"""
    return (n >= -(x + y)) & (n < x + y)


def close(n: Int, x: Int, y: Int) -> Truth:
    """-m <= N <= m - 1 with m the greater of the magnitudes x, y"""
    most = (x < y).ite(y, x)
    return (n >= -most) & (n < most)


def at_least(low: Int, high: Int) -> Int:
    """A number not above high^2 - low^2 for 0 <= low <= high: k (low + high) if high >= low + k."""
    total = low + high
    double = total.twice()
    return (high >= low + 3).ite(
        double + total, (high >= low + 2).ite(double, (high > low).ite(total, total - total))
    )


def facts(n: Int, n_end: Int, at: tuple[Int, Int], end: tuple[Int, Int]) -> Truth:
    """Of N of two nodes one of which is not below the other in either magnitude."""
    (x, y), (end_x, end_y) = at, end
    inside = (x <= end_x) & (y <= end_y)
    outside = (x >= end_x) & (y >= end_y)
    return inside.implies(n <= n_end - at_least(x, end_x) - at_least(y, end_y)) & outside.implies(
        n >= n_end + at_least(end_x, x) + at_least(end_y, y)
    )


def circle_facts(width: int) -> Iterator[Case]:
    """`facts` by (high^2 - low^2) = (high - low) (high + low), N step by step, and `farthest`."""
    room = 2 * width + 4
    times = logic.mul
    x, y = (logic.free(room, name) for name in "xy")
    one, show = logic.bv(room, 1), {"x": x, "y": y}
    fewer = logic.sub(x, one)
    stepped = logic.add(logic.sub(times(x, x), logic.shl(x, 1)), one)
    yield Case("(x - 1)^2 = x^2 - 2 x + 1", logic.eq(times(fewer, fewer), stepped), (), show)
    factored = times(logic.sub(x, y), logic.add(x, y))
    squares = logic.sub(times(x, x), times(y, y))
    yield Case("x^2 - y^2 = (x - y) (x + y)", logic.eq(squares, factored), (), show)
    x, y = (logic.extend(logic.free(width, name), room) for name in "xy")
    show = {"x": x, "y": y}
    for many in range(1, MANY + 1):
        enough = logic.ule(logic.bv(room, many), x)
        multiple = times(logic.bv(room, many), y)
        yield Case(f"x y with x >= {many}", logic.ule(multiple, times(x, y)), (enough,), show)
    yield Case("x <= x^2", logic.ule(x, times(x, x)), (), show)
    near = logic.ult(logic.sub(times(x, x), x), most_squares(width))
    yield Case("farthest node", logic.ule(x, farthest(width)), (near,), show)


class Arc(Observer):
    """The job, the position reached, N there and of the end."""

    def __init__(self, width: int) -> None:
        self.width, self.at, self.room = width, width + 1, width + 4
        self.largest, self.farthest = largest(width), farthest(width)
        self.widths = {
            "started": 1,
            "clockwise": 1,
            "combined": 1,
            "close": 1,  # start and end are within half a step along an axis
            "at_u": self.at,
            "at_v": self.at,
            "end_u": width,
            "end_v": width,
            "n": self.room,
            "n_end": self.room,
        }

    def next(self, run: Run, own: Values) -> Values:
        begins = flag(run.input("start_i")) & ~flag(run.output("active_o", 0))
        ports = {
            name: Int(run.input(f"{name}_i"))
            for name in ("start_u", "start_v", "end_u", "end_v", "start_error")
        }
        n, n_end = ports["start_error"], Int(logic.free(self.room, "new n_end"))
        sizes = [ports[name].size() for name in ("start_u", "start_v", "end_u", "end_v")]
        fresh = {
            "started": logic.bv(1, 1),
            "clockwise": run.input("clockwise_i"),
            "combined": run.input("combined_i"),
            "close": logic.vector((close(n, *sizes[:2]) & close(n_end, *sizes[2:])).term),
            "at_u": ports["start_u"].bits(self.at),
            "at_v": ports["start_v"].bits(self.at),
            "end_u": ports["end_u"].bits(self.width),
            "end_v": ports["end_v"].bits(self.width),
            "n": n.bits(self.room),
            "n_end": n_end.bits(self.room),
        }
        going_on = dict(own)
        changes = []
        valid = flag(run.output("valid_o", 0))
        for index, axis in enumerate("uv"):
            moves = valid & Truth(logic.bit(run.output("step_o", 0), index))
            back = Truth(logic.bit(run.output("negative_o", 0), index))
            [at] = signed(own, f"at_{axis}")
            going_on[f"at_{axis}"] = moves.ite(back.ite(at - 1, at + 1), at).bits(self.at)
            double = at.twice()
            change = moves.ite(back.ite(-double, double) + 1, 0)
            changes.append(change.bits(self.room))
        going_on["n"] = logic.add(own["n"], logic.add(*changes))
        return selected(begins.term, fresh, going_on)

    def known(self, own: Values) -> Truth:
        """Facts about numbers."""
        n, n_end, *coordinates = signed(own, "n", "n_end", "at_u", "at_v", "end_u", "end_v")
        u, v, end_u, end_v = (each.size() for each in coordinates)
        return facts(n, n_end, (u, v), (end_u, end_v))

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        begins = flag(run.input("start_i")) & ~flag(run.output("active_o", 0))
        contract = always()
        for name in ("start_u", "start_v", "end_u", "end_v"):
            contract &= Int(run.input(f"{name}_i")) >= -self.largest
        u, v, end_u, end_v = (
            each.size() for each in signed(then, "at_u", "at_v", "end_u", "end_v")
        )
        n, n_end = signed(then, "n", "n_end")
        job = about(n, u, v) & about(n_end, end_u, end_v) & (u + v > 0) & (end_u + end_v > 0)
        contract &= begins.implies(job)
        far = always()
        for each in signed(own, "at_u", "at_v"):
            far &= (each <= self.farthest) & (each >= -self.farthest)
        started = flag(own["started"])
        return {
            "contract": contract.term,
            "facts": started.implies(self.known(own)).term,
            "facts after": started.implies(self.known(then)).term,
            "farthest": started.implies(far).term,
            OWN_FACTS: self.own_facts(run, own).term,
        }

    def own_facts(self, run: Run, own: Values) -> Truth:
        """The facts for p and q, which hold where they belong to the same axes."""
        unit = self.unit(run, 0)
        p, q, end_p, end_q = (unit[name] for name in ("p_q", "q_q", "end_p_q", "end_q_q"))
        n, n_end = signed(own, "n", "n_end")
        last = self.state(run, 0, DECIDE, MOVE) & unit["borders_q"].same(0)
        return last.implies(facts(n, n_end, (p, q), (end_p, end_q)) & about(n_end, end_p, end_q))

    # ---- the unit's own numbers ----
    def unit(self, run: Run, cycle: int) -> dict[str, Int]:
        unsigned = ("p_q", "q_q", "end_p_q", "end_q_q", "borders_q", "turns_q")
        unsigned += ("quadrant_q", "end_quadrant_q")
        with_sign = ("u_q", "v_q", "end_u_q", "end_v_q", "error_q", "left_q")
        numbers = {n: Int.unsigned(run.signal(n, cycle)) for n in unsigned}
        return numbers | {n: Int(run.signal(n, cycle)) for n in with_sign}

    def state(self, run: Run, cycle: int, *names: int) -> Truth:
        found = ~always()
        for name in names:
            found |= Truth(logic.eq(run.signal("state_q", cycle), name))
        return found

    def turned(self, own: Values, u: str, v: str) -> tuple[Int, Int]:
        """Coordinates of the counterclockwise arc: exchanged for a clockwise one."""
        clockwise = flag(own["clockwise"])
        x, y = signed(own, u, v)
        return clockwise.ite(y, x), clockwise.ite(x, y)

    def placed(self, u: Int, v: Int, quadrant: Int, p: Int, q: Int) -> Truth:
        """p and q are the shrinking and the growing coordinate of u, v in the quadrant."""
        ways = ((u, v), (v, -u), (-u, -v), (-v, u))
        found = (p > 0) & (q >= 0)
        for number, (shrinking, growing) in enumerate(ways):
            found &= quadrant.same(number).implies(p.same(shrinking) & q.same(growing))
        return found

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        unit = self.unit(run, cycle)
        started, combined = flag(own["started"]), flag(own["combined"])
        n, n_end = signed(own, "n", "n_end")
        u, v = self.turned(own, "at_u", "at_v")
        end_u, end_v = self.turned(own, "end_u", "end_v")
        p, q, end_p, end_q = (unit[name] for name in ("p_q", "q_q", "end_p_q", "end_q_q"))
        last = unit["borders_q"].same(0)
        place = self.state(run, cycle, PLACE)
        counted = self.state(run, cycle, COUNT)
        runs = self.state(run, cycle, DECIDE, MOVE)
        moving = self.state(run, cycle, MOVE)
        move_p, move_q = (flag(run.signal(name, cycle)) for name in ("move_p_q", "move_q_q"))
        # what the step under way leads to
        leaves_p, leaves_q = moving & move_p, moving & move_q
        step_p, step_q = (Int.count(leaves) for leaves in (leaves_p, leaves_q))
        next_p, next_q = p - step_p, q + step_q
        changes = (leaves_p.ite(-p.twice() + 1, 0), leaves_q.ite(q.twice() + 1, 0))
        change = logic.add(*(each.bits(self.room) for each in changes))
        next_n = Int(logic.add(own["n"], change))
        left = unit["left_q"] - step_p - step_q
        modes = flag(run.signal("combined_q", cycle)).matches(combined)
        modes &= flag(run.signal("clockwise_q", cycle)).matches(flag(own["clockwise"]))
        quadrants = (unit["quadrant_q"] + unit["borders_q"] - unit["end_quadrant_q"]).bits(2)
        forward = (next_p >= end_p) & (next_q <= end_q)
        strong = (combined & flag(own["close"])).implies(close(next_n, next_p, next_q))
        parts = {
            "state": Truth(logic.ule(run.signal("state_q", cycle), MOVE))
            & (self.state(run, cycle, IDLE) | started),
            "the job": (place | counted | runs).implies(modes & unit["error_q"].same(n)),
            "coordinates": place.implies(
                unit["u_q"].same(u)
                & unit["v_q"].same(v)
                & unit["end_u_q"].same(end_u)
                & unit["end_v_q"].same(end_v)
            ),
            "position": (counted | runs).implies(self.placed(u, v, unit["quadrant_q"], p, q)),
            "range": (counted | runs).implies((p > 0) & (q >= 0)),
            "end": (counted | runs).implies(
                self.placed(end_u, end_v, unit["end_quadrant_q"], end_p, end_q)
                & (end_p <= self.largest)
                & (end_q <= self.largest)
            ),
            "given coordinates": started.implies(
                (end_u <= self.largest)
                & (end_v <= self.largest)
                & (end_u >= -self.largest)
                & (end_v >= -self.largest)
                & (end_u.size() + end_v.size() > 0)
                & about(n_end, end_u.size(), end_v.size())
                & flag(own["close"]).implies(close(n_end, end_u.size(), end_v.size()))
            ),
            "nodes before the first step": (place | counted).implies(
                (u.size() + v.size() > 0)
                & (u <= self.largest)
                & (v <= self.largest)
                & (u >= -self.largest)
                & (v >= -self.largest)
                & flag(own["close"]).implies(close(n, u.size(), v.size()))
            ),
            "each node within half a step of the circle along the diagonal": started.implies(
                about(n, u.size(), v.size())
            ),
            "and so the next one": runs.implies(about(next_n, next_p, next_q)),
            "combined: within half a step along an axis": runs.implies(
                strong & (combined & flag(own["close"])).implies(close(n, p, q))
            ),
            "a step moves": moving.implies((move_p | move_q) & (combined | ~(move_p & move_q))),
            "borders left": runs.implies(Truth(logic.eq(quadrants, 0))),
            LEFT: (runs & last).implies(forward & left.same(next_p - end_p + end_q - next_q)),
        }
        return {name: part.term for name, part in parts.items()}

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        unit, after = self.unit(run, 0), self.unit(run, 1)
        u, v, end_u, end_v = signed(own, "at_u", "at_v", "end_u", "end_v")
        ends = flag(run.output("active_o", 0)) & ~flag(run.output("active_o", 1))
        valid, step = flag(run.output("valid_o", 0)), run.output("step_o", 0)
        step_u, step_v = (Truth(logic.bit(step, index)) for index in (0, 1))
        crosses = valid & ~after["quadrant_q"].same(unit["quadrant_q"])
        counted = self.state(run, 0, COUNT)
        passes = Int.unsigned((unit["end_quadrant_q"] - unit["quadrant_q"]).bits(2))
        behind = unit["q_q"] - unit["p_q"] >= unit["end_q_q"] - unit["end_p_q"]
        turns = unit["turns_q"] + (passes.same(0) & behind).ite(passes + 1, 0)
        borders = turns.twice().twice() + passes
        moved = ~self.state(run, 0, PLACE)
        claims = {
            "ends at the end": ends.implies(u.same(end_u) & v.same(end_v)),
            "elementary steps move one axis": (valid & ~flag(own["combined"])).implies(
                ~step_u.matches(step_v)
            ),
            "every step moves": valid.implies(step_u | step_v),
            "borders to the end, and those of the turns": counted.implies(
                after["borders_q"].same(borders)
            ),
            "every border counts": (valid & moved).implies(
                after["borders_q"].same(unit["borders_q"] - Int.count(crosses))
            ),
        }
        return {name: claim.term for name, claim in claims.items()}


def own_facts(ctx: Context, width: int) -> Iterator[Case]:
    """The facts for p and q follow from those for the coordinates, in each quadrant."""
    observer = Arc(width)
    run = ctx.run("arc_interpolator", {"Width": width})
    own = {name: logic.free(width, name) for name, width in observer.widths.items()}
    known = {
        **observer.assumed(run, own, observer.next(run, own)),
        **observer.invariant(run, own, 0),
    }
    used = [known[name] for name in ("facts", "state", "position", "end", "given coordinates")]
    claim = observer.own_facts(run, own).term
    for way in (0, 1):
        for quadrant in range(4):
            same = [logic.eq(run.signal(n, 0), quadrant) for n in ("quadrant_q", "end_quadrant_q")]
            turned = logic.eq(own["clockwise"], way)
            name = f"{OWN_FACTS}: way {way}, quadrant {quadrant}"
            yield Case(name, claim, (turned, *same, *used))
    apart = logic.ne(run.signal("quadrant_q", 0), run.signal("end_quadrant_q", 0))
    last = logic.eq(run.signal("borders_q", 0), 0)
    borders = (known["borders left"], apart, last)
    runs = observer.state(run, 0, DECIDE, MOVE)
    yield Case("the last quadrant is the end's", logic.no(runs.term), borders)


NEAR = ("and so the next one", "combined: within half a step along an axis")
HARD = (
    "the job",
    LEFT,
    "each node within half a step of the circle along the diagonal",
    *NEAR,
)


def states(run: Run, own: Values) -> Mapping[str, tuple[Term, ...]]:
    """By state, and where it steps by direction, quadrant and axes."""

    def at(name: str, value: int) -> Term:
        return logic.eq(run.signal(name, 0), value)

    def turned(way: int, quadrant: int) -> tuple[Term, ...]:
        same = logic.eq(own["clockwise"], way)
        return same, at("clockwise_q", way), at("quadrant_q", quadrant)

    found = {f"state {state}": (at("state_q", state),) for state in (IDLE, PLACE)}
    faster = logic.ult(run.signal("q_q", 0), run.signal("p_q", 0))
    inside = logic.bit(run.signal("look", 0), logic.width(run.signal("look", 0)) - 1)
    for way in (0, 1):
        for quadrant in range(4):
            here = (at("state_q", COUNT), *turned(way, quadrant))
            same = at("end_quadrant_q", quadrant)
            found[f"begins at its end, way {way}, quadrant {quadrant}"] = (*here, same)
            found[f"begins, way {way}, quadrant {quadrant}"] = (*here, logic.no(same))
    last, final = at("borders_q", 0), at("left_q", 1)
    for mode in (0, 1):
        modes = (at("combined_q", mode), logic.eq(own["combined"], mode))
        for ending, borders in (
            ("not last", (logic.no(last),)),
            ("last", (last, logic.no(final))),
            ("final", (last, final)),
        ):
            for number in range(4):
                rule = [faster if number & 1 else logic.no(faster)]
                rule += [inside if number & 2 else logic.no(inside)]
                name = f"decides, {ending}, mode {mode}, rule {number}"
                found[name] = (at("state_q", DECIDE), *modes, *borders, *rule)
        for way in (0, 1):
            for quadrant in range(4):
                for p, q in ((1, 0), (0, 1), (1, 1))[: 2 + mode]:
                    moves = (at("state_q", MOVE), at("move_p_q", p), at("move_q_q", q))
                    name = f"moves {p}{q}, way {way}, quadrant {quadrant}, mode {mode}"
                    found[name] = (*moves, *turned(way, quadrant), *modes)
    return found


LOCAL = (
    "the job",
    "range",
    "and so the next one",
    "combined: within half a step along an axis",
)
AT_END = (*LOCAL, OWN_FACTS, "state", "given coordinates", "end", "borders left", LEFT)
AT_START = ("facts", "state", "position", "range", "end", "given coordinates", HARD[2])
NEEDED = {
    f"kept: {LEFT}: begins": AT_START,
    **{f"kept: {name}: decides, not": LOCAL for name in (LEFT, *NEAR)},
    **{f"kept: {name}: decides, last": LOCAL for name in NEAR},
    **{f"kept: {name}: decides": AT_END for name in (LEFT, *NEAR)},
}


def nodes(ctx: Context, width: int) -> Iterator[Case]:
    """All of it for coordinates of so many bits."""
    parameters = {"Width": width}
    yield from circle_facts(width)
    yield from inductive(ctx, "arc_interpolator", Arc(width), parameters, "", states, HARD, NEEDED)
    yield from own_facts(ctx, width)


CLAIM = (
    "N is the exact equation of the circle; each node is within half a step of the circle along "
    "the diagonal, or in combined steps along an axis; the arc ends at its end after the "
    "quadrant borders and whole turns requested"
)


@proof(
    "arc_interpolator",
    CLAIM,
    "all coordinates of 12 bits but -2^11, start and end that near the circle too, both directions "
    "and modes, any pauses",
)
def arc_nodes(ctx: Context) -> Iterator[Case]:
    yield from nodes(ctx, NARROW)


@proof(
    "arc_interpolator",
    CLAIM,
    "as before, for coordinates of 24 bits but -2^23, the default",
    timeout=300,
)
def arc_nodes_wide(ctx: Context) -> Iterator[Case]:
    yield from nodes(ctx, WIDTH)
