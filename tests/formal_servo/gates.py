# SPDX-License-Identifier: Apache-2.0
"""Proofs of pwm_phase, pwm_bridge and pwm_carrier: gates, dead time, trip, and sums of duty."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bitwuzla import Term

from tests.formal.catalogue import Case, Context, proof
from tests.formal.induction import Observer, Values, inductive
from tests.formal.logic import Logic
from tests.formal.netlist import Run

DEAD, WIDTH = 8, 12  # parameters of the blocks
AGE = DEAD + 1  # bits of a saturating count: above every dead time
GATES = ("high_o", "low_o")


class DeadTime(Observer):
    """Clocks that both gates have been off, this one included, and the dead time asked for in the
    last clock of a gate. Before the first one: the longest."""

    widths = {"off": AGE, "wanted": DEAD}

    def after_reset(self, logic: Logic) -> Values:
        return {"off": logic.bv(AGE, 1), "wanted": logic.bv(DEAD, -1)}

    def gate(self, run: Run, cycle: int) -> Term:
        return run.logic.any(*(run.on(name, cycle) for name in GATES))

    def next(self, run: Run, own: Values) -> Values:
        logic = run.logic
        most, one = logic.bv(AGE, -1), logic.bv(AGE, 1)
        older = logic.ite(logic.eq(own["off"], most), most, logic.add(own["off"], one))
        was, on = self.gate(run, 0), self.gate(run, 1)
        return {
            "off": logic.ite(on, logic.bv(AGE, 0), logic.ite(was, one, older)),
            "wanted": logic.ite(was, run.input("dead_time_i"), own["wanted"]),
        }

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        logic = run.logic
        high, low = (run.on(name, cycle) for name in GATES)
        left = logic.extend(run.signal("wait_q", cycle), AGE + 1)
        served = logic.extend(own["off"], AGE + 1)
        asked = logic.extend(own["wanted"], AGE + 1)
        none = logic.no(self.gate(run, cycle))
        one = logic.bv(AGE + 1, 1)
        return {
            "never both gates": logic.no(logic.all(high, low)),
            "off counts": logic.eq(none, logic.ne(own["off"], 0)),
            "the wait covers the dead time": logic.implies(
                none, logic.ule(logic.add(asked, one), logic.add(left, served))
            ),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        logic = run.logic
        on = logic.all(logic.no(self.gate(run, 0)), self.gate(run, 1))
        swap = logic.any(*(logic.all(run.on(a, 0), run.on(b, 1)) for a, b in (GATES, GATES[::-1])))
        off = run.on("off_i")
        return {
            "no gate turns on before the dead time": logic.implies(
                on, logic.ule(logic.extend(own["wanted"], AGE), own["off"])
            ),
            "never from one gate to the other at once": logic.no(swap),
            "off_i turns both off with the next edge": logic.implies(
                off, logic.no(self.gate(run, 1))
            ),
        }


@proof(
    "pwm_phase",
    "both gates are never on together; a gate turns on only after both were off for the dead time "
    "of the last clock of a gate, and one clock at least; off_i turns both off with the next edge",
    "any carrier, compare values, modes, dead times and faults, changing in any clock",
    quick=True,
)
def no_shoot_through(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "pwm_phase", DeadTime())


class Trip(Observer):
    """Nothing of its own: what a fault does in two clocks."""

    widths: Mapping[str, int] = {}

    def next(self, run: Run, own: Values) -> Values:
        return {}

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        logic = run.logic
        high, low = (run.output(name, cycle) for name in GATES)
        least = logic.bv(DEAD, 12)
        parts = {
            "never both gates of a phase": logic.all(
                *(logic.no(logic.all(logic.bit(high, i), logic.bit(low, i))) for i in range(3))
            ),
            "least dead time": logic.ule(least, run.signal("dead_time_q", cycle)),
        }
        return parts

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        logic = run.logic
        dark = [logic.all(*(logic.eq(run.output(name, n), 0) for name in GATES)) for n in (1, 2)]
        hit = logic.any(*(run.on(name, 0) for name in ("fault_i", "alarm_i")))
        trip = [run.on("trip_o", n) for n in range(3)]
        clear = run.on("clear_i", 0)
        return {
            "all gates off two clocks behind a fault": logic.implies(hit, dark[1]),
            "and the trip is there": logic.implies(hit, trip[2]),
            "a trip stays until it is cleared": logic.implies(
                logic.all(trip[0], logic.no(clear)), trip[1]
            ),
            "no gate in a trip": logic.implies(trip[0], dark[0]),
        }


@proof(
    "pwm_bridge",
    "a fault in any one clock turns all six gates off behind the second edge and trips; the trip "
    "stays until clear_i; the dead time is LeastDeadTime at least",
    "any registers, values, faults and clears in any clock",
    quick=True,
)
def trip_in_two_clocks(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "pwm_bridge", Trip())


class Duty(Observer):
    """Carrier by its contract, clocks of the present half so far and those ordered on in it."""

    widths = {"count": WIDTH, "half": WIDTH, "up": 1, "on": WIDTH + 1, "since": WIDTH}

    def __init__(self, logic: Logic) -> None:
        self.logic = logic

    def after_reset(self, logic: Logic) -> Values:
        half = logic.bv(WIDTH, 64)
        zero = logic.bv(WIDTH, 0)
        return {
            "count": zero,
            "half": half,
            "up": logic.bv(1, 1),
            "on": logic.bv(WIDTH + 1, 0),
            "since": zero,
        }

    def last(self, own: Values) -> Term:
        logic = self.logic
        return logic.eq(logic.add(own["since"], logic.bv(WIDTH, 1)), own["half"])

    def ordered(self, run: Run, cycle: int) -> Term:
        """What the order is for the carrier of this cycle: the register a clock later."""
        return run.signal("ordered_q", cycle + 1)

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        logic = run.logic
        return {
            "carrier": logic.all(
                logic.eq(run.input("count_i"), own["count"]),
                logic.eq(run.input("up_i"), own["up"]),
                logic.eq(run.on("load_i"), self.last(own)),
            ),
        }

    def next(self, run: Run, own: Values) -> Values:
        logic = run.logic
        new_half = logic.free(WIDTH, "new half")
        half = logic.ite(logic.ult(new_half, logic.bv(WIDTH, 64)), logic.bv(WIDTH, 64), new_half)
        last, up = self.last(own), logic.eq(own["up"], 1)
        one, zero = logic.bv(WIDTH, 1), logic.bv(WIDTH, 0)
        moved = logic.ite(up, logic.add(own["count"], one), logic.sub(own["count"], one))
        more = logic.add(own["on"], logic.extend(self.ordered(run, 0), WIDTH + 1))
        return {
            "count": logic.ite(last, logic.ite(up, half, zero), moved),
            "half": logic.ite(last, half, own["half"]),
            "up": logic.ite(last, logic.vector(logic.no(up)), own["up"]),
            "on": logic.ite(last, logic.bv(WIDTH + 1, 0), more),
            "since": logic.ite(last, zero, logic.add(own["since"], one)),
        }

    def so_far(self, run: Run, own: Values, cycle: int) -> Term:
        """Clocks ordered on before this one: the first `compare` of a half up, the last down."""
        logic = run.logic
        compare, since = run.signal("compare_q", cycle), own["since"]
        rising = logic.ite(logic.ult(since, compare), since, compare)
        start = logic.ite(
            logic.ult(compare, own["half"]), logic.sub(own["half"], compare), logic.bv(WIDTH, 0)
        )
        falling = logic.ite(logic.ult(start, since), logic.sub(since, start), logic.bv(WIDTH, 0))
        return logic.extend(logic.ite(logic.eq(own["up"], 1), rising, falling), WIDTH + 1)

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        logic = run.logic
        down = logic.sub(own["half"], own["since"])
        place = logic.ite(logic.eq(own["up"], 1), own["since"], down)
        return {
            "place": logic.all(logic.ult(own["since"], own["half"]), logic.eq(own["count"], place)),
            "half": logic.ule(logic.bv(WIDTH, 64), own["half"]),
            "ordered so far": logic.eq(own["on"], self.so_far(run, own, cycle)),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        logic = run.logic
        compare = run.signal("compare_q", 0)
        total = logic.add(own["on"], logic.extend(self.ordered(run, 0), WIDTH + 1))
        whole = logic.ite(logic.ult(compare, own["half"]), compare, own["half"])
        last = self.last(own)
        return {
            "a half orders its compare value of clocks": logic.implies(
                last, logic.eq(total, logic.extend(whole, WIDTH + 1))
            ),
            "the value changes between halves only": logic.implies(
                logic.no(last), logic.eq(run.signal("compare_q", 1), compare)
            ),
        }


@proof(
    "pwm_phase",
    "in each half of the carrier the high state is ordered for exactly as many clocks as the value "
    "compared, or for all of them, and the value changes between halves only",
    "any compare values and half periods; the carrier as its contract has it",
    quick=True,
)
def duty_sums(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "pwm_phase", Duty(ctx.logic))


class Triangle(Observer):
    """The carrier's contract as a machine: clocks of the present half so far, half, direction."""

    widths = {"half": WIDTH, "up": 1, "since": WIDTH}

    def after_reset(self, logic: Logic) -> Values:
        return {"half": logic.bv(WIDTH, 64), "up": logic.bv(1, 1), "since": logic.bv(WIDTH, 0)}

    def last(self, run: Run, own: Values) -> Term:
        logic = run.logic
        return logic.eq(logic.add(own["since"], logic.bv(WIDTH, 1)), own["half"])

    def next(self, run: Run, own: Values) -> Values:
        logic = run.logic
        asked, least = run.input("half_period_i"), logic.bv(WIDTH, 64)
        last = self.last(run, own)
        fresh = logic.ite(logic.ult(asked, least), least, asked)
        step = logic.add(own["since"], logic.bv(WIDTH, 1))
        return {
            "half": logic.ite(last, fresh, own["half"]),
            "up": logic.ite(last, logic.vector(logic.ne(own["up"], 1)), own["up"]),
            "since": logic.ite(last, logic.bv(WIDTH, 0), step),
        }

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        logic = run.logic
        down = logic.sub(own["half"], own["since"])
        place = logic.ite(logic.eq(own["up"], 1), own["since"], down)
        one = logic.bv(WIDTH, 1)
        left = logic.sub(logic.sub(own["half"], own["since"]), one)
        return {
            "count": logic.eq(run.output("count_o", cycle), place),
            "direction": logic.eq(run.output("up_o", cycle), own["up"]),
            "half": logic.all(
                logic.eq(run.output("half_o", cycle), own["half"]),
                logic.ule(logic.bv(WIDTH, 64), own["half"]),
            ),
            "clocks": logic.all(
                logic.ult(own["since"], own["half"]),
                logic.eq(run.signal("since_q", cycle), own["since"]),
                logic.eq(run.signal("left_q", cycle), left),
            ),
            "load": logic.eq(run.on("load_o", cycle), self.last(run, own)),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        logic = run.logic
        opened = [run.on("opened_q", cycle) for cycle in (0, 1)]
        window, last = run.on("window_o", 0), self.last(run, own)
        return {
            "a window in every half": logic.implies(last, logic.any(opened[0], window)),
            "and no second one": logic.implies(opened[0], logic.no(window)),
            "opened is remembered": logic.eq(
                opened[1], logic.all(logic.no(last), logic.any(opened[0], window))
            ),
        }


@proof(
    "pwm_carrier",
    "the carrier is the triangle of its contract: up 0 .. half - 1, down half .. 1, load_o in the "
    "last clock of a half, the half taken over there, one window in each",
    "any half periods and window starts, changing in any clock",
    quick=True,
)
def triangle(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "pwm_carrier", Triangle())
