# SPDX-License-Identifier: Apache-2.0
"""Proofs of pwm_phase, pwm_bridge and pwm_carrier: gates, dead time, trip, and sums of duty."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bitwuzla import Term

from tests.formal import logic
from tests.formal.catalogue import Case, Context, proof
from tests.formal.induction import Observer, Values, inductive, older
from tests.formal.netlist import Run

DEAD, WIDTH = 8, 12  # parameters of the blocks
AGE = DEAD + 1  # bits of a saturating count: above every dead time
LEAST_HALF = 64  # clocks
GATES = ("high_o", "low_o")


class DeadTime(Observer):
    """Clocks that both gates have been off, this one included, and the dead time requested in the
    last clock of a gate. Before the first one: the longest."""

    widths = {"off": AGE, "wanted": DEAD}
    reset = {"off": 1, "wanted": -1}

    def gate(self, run: Run, cycle: int) -> Term:
        return logic.any(*(run.on(name, cycle) for name in GATES))

    def next(self, run: Run, own: Values) -> Values:
        was, on = self.gate(run, 0), self.gate(run, 1)
        off = logic.ite(was, logic.bv(AGE, 1), older(own["off"]))
        return {
            "off": logic.ite(on, logic.bv(AGE, 0), off),
            "wanted": logic.ite(was, run.input("dead_time_i"), own["wanted"]),
        }

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
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
    "set when a gate was last on, at least one clock; off_i turns both off with the next edge",
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
        high, low = (run.output(name, cycle) for name in GATES)
        least = logic.bv(DEAD, 12)
        return {
            "never both gates of a phase": logic.all(
                *(logic.no(logic.all(logic.bit(high, i), logic.bit(low, i))) for i in range(3))
            ),
            "least dead time": logic.ule(least, run.signal("dead_time_q", cycle)),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
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
    "a fault in any one clock turns all six gates off after the second edge and trips; the trip "
    "stays until clear_i; the dead time is LeastDeadTime at least",
    "any registers, values, faults and clears in any clock",
    quick=True,
)
def trip_in_two_clocks(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "pwm_bridge", Trip())


class Carrier(Observer):
    """The carrier's contract as a machine: clocks of the present half so far, half, direction."""

    widths = {"half": WIDTH, "up": 1, "since": WIDTH}
    reset = {"half": LEAST_HALF, "up": 1}

    def last(self, own: Values) -> Term:
        return logic.eq(logic.add(own["since"], 1), own["half"])

    def place(self, own: Values) -> Term:
        """Its count."""
        down = logic.sub(own["half"], own["since"])
        return logic.ite(logic.eq(own["up"], 1), own["since"], down)

    def moved(self, own: Values, half: Term) -> Values:
        """Its registers a clock later; `half` is the next one."""
        last = self.last(own)
        return {
            "half": logic.ite(last, half, own["half"]),
            "up": logic.ite(last, logic.vector(logic.ne(own["up"], 1)), own["up"]),
            "since": logic.ite(last, logic.bv(WIDTH, 0), logic.add(own["since"], 1)),
        }


def at_least(half: Term) -> Term:
    """The half that is taken over where this one is requested."""
    least = logic.bv(WIDTH, LEAST_HALF)
    return logic.ite(logic.ult(half, least), least, half)


class Duty(Carrier):
    """Carrier by its contract, its count, and the clocks ordered on in the present half."""

    widths = {**Carrier.widths, "count": WIDTH, "on": WIDTH + 1}

    def ordered(self, run: Run, cycle: int) -> Term:
        """What the order is for the carrier of this cycle: the register a clock later."""
        return run.signal("ordered_q", cycle + 1)

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        return {
            "carrier": logic.all(
                logic.eq(run.input("count_i"), own["count"]),
                logic.eq(run.input("up_i"), own["up"]),
                logic.eq(run.on("load_i"), self.last(own)),
            ),
        }

    def next(self, run: Run, own: Values) -> Values:
        half = at_least(logic.free(WIDTH, "new half"))
        last, up = self.last(own), logic.eq(own["up"], 1)
        moved = logic.ite(up, logic.add(own["count"], 1), logic.sub(own["count"], 1))
        more = logic.add(own["on"], logic.extend(self.ordered(run, 0), WIDTH + 1))
        return {
            **self.moved(own, half),
            "count": logic.ite(last, logic.ite(up, half, logic.bv(WIDTH, 0)), moved),
            "on": logic.ite(last, logic.bv(WIDTH + 1, 0), more),
        }

    def so_far(self, run: Run, own: Values, cycle: int) -> Term:
        """Clocks ordered on before this one: the first `compare` of a half up, the last down."""
        compare, since = run.signal("compare_q", cycle), own["since"]
        rising = logic.ite(logic.ult(since, compare), since, compare)
        start = logic.ite(
            logic.ult(compare, own["half"]), logic.sub(own["half"], compare), logic.bv(WIDTH, 0)
        )
        falling = logic.ite(logic.ult(start, since), logic.sub(since, start), logic.bv(WIDTH, 0))
        return logic.extend(logic.ite(logic.eq(own["up"], 1), rising, falling), WIDTH + 1)

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        within, place = logic.ult(own["since"], own["half"]), self.place(own)
        return {
            "place": logic.all(within, logic.eq(own["count"], place)),
            "half": logic.ule(logic.bv(WIDTH, LEAST_HALF), own["half"]),
            "ordered so far": logic.eq(own["on"], self.so_far(run, own, cycle)),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
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
    yield from inductive(ctx, "pwm_phase", Duty())


class Triangle(Carrier):
    """The carrier itself."""

    def next(self, run: Run, own: Values) -> Values:
        return self.moved(own, at_least(run.input("half_period_i")))

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        left = logic.sub(logic.sub(own["half"], own["since"]), 1)
        return {
            "count": logic.eq(run.output("count_o", cycle), self.place(own)),
            "direction": logic.eq(run.output("up_o", cycle), own["up"]),
            "half": logic.all(
                logic.eq(run.output("half_o", cycle), own["half"]),
                logic.ule(logic.bv(WIDTH, LEAST_HALF), own["half"]),
            ),
            "clocks": logic.all(
                logic.ult(own["since"], own["half"]),
                logic.eq(run.signal("since_q", cycle), own["since"]),
                logic.eq(run.signal("left_q", cycle), left),
            ),
            "load": logic.eq(run.on("load_o", cycle), self.last(own)),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        opened = [run.on("opened_q", cycle) for cycle in (0, 1)]
        window, last = run.on("window_o", 0), self.last(own)
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
