# SPDX-License-Identifier: Apache-2.0
"""Proofs of step_output and pulse_generator: what a drive sees, for any inputs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bitwuzla import Term

from tests.formal import logic
from tests.formal.catalogue import Case, Context, proof
from tests.formal.induction import Observer, Values, inductive, older, selected
from tests.formal.netlist import Run

TIME, BACKLOG = 10, 8  # parameters of step_output in motion_axis
AGE = TIME + 1  # bits of a saturating count of clocks: its greatest value is above every time
TIMES = ("length_i", "space_i", "setup_i", "hold_i")


class DriveTiming(Observer):
    """Clocks that step_o and direction_o have been as they are, the present one included, and the
    sum of the requests that were taken.

    A time counts from when it is 1; the counts begin, and after a change of the times in idleness
    go on, at their greatest value.
    """

    widths = {"level": AGE, "steady": AGE, "taken": 32}
    reset = {"level": -1, "steady": -1}

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        idle = run.on("idle_o", 0)
        return {"times": logic.any(idle, self.same_times(run))}

    def same_times(self, run: Run) -> Term:
        return logic.all(*(logic.eq(run.input(name, 0), run.input(name, 1)) for name in TIMES))

    def next(self, run: Run, own: Values) -> Values:
        most, one = logic.bv(AGE, -1), logic.bv(AGE, 1)

        def aged(name: str, port: str) -> Term:
            same = logic.eq(run.output(port, 0), run.output(port, 1))
            forgotten = logic.ite(self.same_times(run), older(own[name]), most)
            return logic.ite(same, forgotten, one)

        clear = run.on("clear_i")
        after_clear = run.output("position_o", 1)
        request = logic.ite(
            self.accepted(run),
            logic.ite(run.on("negative_i"), logic.bv(32, -1), logic.bv(32, 1)),
            logic.bv(32, 0),
        )
        return {
            "level": aged("level", "step_o"),
            "steady": aged("steady", "direction_o"),
            "taken": logic.ite(clear, after_clear, logic.add(own["taken"], request)),
        }

    def accepted(self, run: Run) -> Term:
        """A request that finds room: fewer than the most that may wait in its direction."""
        waiting, most = run.signal("backlog_q", 0), (1 << (BACKLOG - 1)) - 1
        negative = run.on("negative_i")
        full = logic.eq(
            waiting, logic.ite(negative, logic.bv(BACKLOG, -most), logic.bv(BACKLOG, most))
        )
        return logic.all(run.on("request_i"), logic.no(full))

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        length, space, setup, hold = (self.time(run, name, cycle) for name in TIMES)
        high, turned = (run.on(name, cycle) for name in ("step_q", "turned_q"))
        level, keep = (self.running(run, name, cycle) for name in ("level_q", "keep_q"))
        low = logic.no(high)
        backlog, most = run.signal("backlog_q", cycle), (1 << (BACKLOG - 1)) - 1

        def reached(count: Term, left: Term, wanted: Term) -> Term:
            """A count reaches a time when what is left of it is over."""
            wide = logic.add(logic.extend(count, AGE + 1), logic.extend(left, AGE + 1))
            return logic.ule(logic.extend(wanted, AGE + 1), wide)

        none = logic.bv(AGE, 0)
        exact = logic.eq(logic.add(own["level"], level), length)
        return {
            "the pulse ends after its length": logic.implies(
                high, logic.all(exact, logic.ule(own["level"], length))
            ),
            "the space ends in time": logic.implies(low, reached(own["level"], level, space)),
            "the hold ends in time": logic.implies(
                low, reached(own["level"], logic.ite(turned, none, keep), hold)
            ),
            "the setup ends in time": reached(
                own["steady"], logic.ite(logic.all(turned, low), keep, none), setup
            ),
            "requests taken are sent or waiting": logic.eq(
                own["taken"],
                logic.add(run.output("position_o", cycle), logic.sign_extend(backlog, 32)),
            ),
            "no more wait than may": logic.sle(logic.bv(BACKLOG, -most), backlog),
        }

    def time(self, run: Run, name: str, cycle: int) -> Term:
        """A time; 0 acts as 1."""
        value = run.input(name, cycle)
        return logic.extend(logic.ite(logic.eq(value, 0), logic.bv(TIME, 1), value), AGE)

    def running(self, run: Run, name: str, cycle: int) -> Term:
        """Clocks after the present one that a time of the unit still runs."""
        value = run.signal(name, cycle)
        left = logic.ite(logic.eq(value, 0), value, logic.sub(value, 1))
        return logic.extend(left, AGE)

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        length, space, setup, hold = (self.time(run, name, 0) for name in TIMES)
        step, after = (run.on("step_o", cycle) for cycle in (0, 1))
        rises, falls = logic.all(logic.no(step), after), logic.all(step, logic.no(after))
        old, new = (run.output("direction_o", cycle) for cycle in (0, 1))
        turns = logic.ne(old, new)
        moved = logic.sub(run.output("position_o", 1), run.output("position_o", 0))
        one = logic.ite(logic.eq(new, 1), logic.bv(32, -1), logic.bv(32, 1))
        refused = logic.all(run.on("request_i"), logic.no(self.accepted(run)))
        overrun = [run.on("overrun_o", cycle) for cycle in (0, 1)]
        waits = logic.ne(run.signal("backlog_q", 0), 0)
        left = [
            logic.add(*(self.running(run, name, cycle) for name in ("level_q", "keep_q")))
            for cycle in (0, 1)
        ]
        idle = run.on("idle_o", 0)
        return {
            "step_o is high for its length": logic.implies(
                step, logic.eq(logic.eq(own["level"], length), falls)
            ),
            "and low for its space": logic.implies(rises, logic.ule(space, own["level"])),
            "direction_o is stable before a step": logic.implies(
                rises, logic.all(logic.ule(setup, own["steady"]), logic.no(turns))
            ),
            "and until the hold is over": logic.implies(
                turns, logic.all(logic.no(step), logic.no(after), logic.ule(hold, own["level"]))
            ),
            "a step counts as one in its direction, modulo 2^32": logic.eq(
                moved, logic.ite(rises, one, logic.bv(32, 0))
            ),
            "a request refused sets overrun_o until it is cleared": logic.eq(
                overrun[1],
                logic.all(logic.eq(run.input("clear_i"), 0), logic.any(overrun[0], refused)),
            ),
            "while requests wait something goes on": logic.implies(
                waits, logic.any(step, rises, turns, logic.ult(left[1], left[0]))
            ),
            "idle_o means all is over": logic.implies(
                idle,
                logic.all(
                    logic.no(step),
                    logic.eq(own["taken"], run.output("position_o", 0)),
                    *(logic.ule(wanted, own["level"]) for wanted in (space, hold)),
                    logic.ule(setup, own["steady"]),
                ),
            ),
        }


@proof(
    "step_output",
    "step_o is high for exactly its length and low for its space at least, direction_o is stable "
    "from its setup before a step until its hold after it; requests taken are the steps sent and "
    "those waiting, refused ones set overrun_o; while requests wait something goes on",
    "any requests, times and clears; times change only in idleness, and counting then restarts",
    quick=True,
)
def step_timing(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "step_output", DriveTiming())


MODULUS = 1_600_000_000  # 16 x 100 MHz, the default
SUM = 96  # bits of sums of rates that no run exceeds


class PulseSum(Observer):
    """Sum of the rates, from half a pulse on, and of a modulus for every pulse started, both since
    the phase was last centred; whether every rate since then was at most half a pulse per clock,
    less in a clock in which a pulse due at the centring is given."""

    widths = {"sum": SUM, "pulses": SUM, "moderate": 1}

    def __init__(self, modulus: int) -> None:
        self.modulus = modulus
        self.reset = {"sum": modulus // 2, "moderate": 1}  # and when the phase is centred

    def centres(self, run: Run) -> Term:
        """Requested, or in the first clock after reset."""
        return logic.any(run.on("clear_i"), run.on("start_q", 0))

    def moderate(self, run: Run, cycle: int = 0) -> Term:
        rate = run.input("rate_i", cycle)
        less = logic.any(logic.no(self.owed(run, cycle)), logic.ne(rate, self.modulus // 2))
        return logic.all(logic.ule(rate, self.modulus // 2), less)

    def owed(self, run: Run, cycle: int) -> Term:
        """A pulse of the time before the phase was centred is given."""
        pulse = run.on("pulse_o", cycle)
        return logic.all(pulse, logic.eq(run.signal("wrap_q", cycle), 0))

    def next(self, run: Run, own: Values) -> Values:
        pulse, modulus = run.on("pulse_o", 1), logic.bv(SUM, self.modulus)
        going_on = {
            "sum": logic.add(own["sum"], logic.extend(run.input("rate_i"), SUM)),
            "pulses": logic.add(own["pulses"], logic.ite(pulse, modulus, logic.bv(SUM, 0))),
            "moderate": logic.ite(self.moderate(run), own["moderate"], logic.bv(1, 0)),
        }
        return selected(self.centres(run), self.after_reset(), going_on)

    def remainder(self, run: Run, cycle: int) -> Term:
        """What is left of the sum when a modulus was taken off for every pulse; signed."""
        phase, wraps = run.signal("phase_q", cycle), run.on("wrap_q", cycle)
        return logic.ite(wraps, phase, logic.add(phase, self.modulus))

    def due(self, run: Run) -> Term:
        """What is left and the rate are a modulus."""
        sum_ = logic.add(
            logic.sign_extend(self.remainder(run, 0), 40), logic.extend(run.input("rate_i"), 40)
        )
        return logic.sle(logic.bv(40, self.modulus), sum_)

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        rest, half = self.remainder(run, cycle), logic.bv(34, self.modulus // 2)
        pulse = run.on("pulse_o", cycle)
        wraps = run.on("wrap_q", cycle)
        phase = run.signal("phase_q", cycle)
        exact = logic.all(
            logic.sle(logic.bv(34, 0), rest),
            logic.slt(rest, logic.ite(wraps, half, logic.bv(34, self.modulus))),
            logic.eq(own["sum"], logic.add(own["pulses"], logic.sign_extend(rest, SUM))),
        )
        begins = run.on("start_q", cycle)
        bounded = logic.ite(
            wraps,
            logic.all(logic.sle(logic.bv(34, 0), phase), logic.slt(phase, 1 << 32)),
            logic.all(logic.sle(logic.bv(34, -self.modulus), phase), logic.slt(phase, 0)),
        )
        return {
            "pulses are the whole moduli in the sum": logic.any(
                begins, logic.eq(own["moderate"], 0), exact
            ),
            "phase in range": logic.any(begins, bounded),
            "no pulse at the start": logic.implies(begins, logic.no(pulse)),
            "a modulus is taken off for a pulse": logic.implies(wraps, pulse),
            "but for one due when the phase was centred": logic.implies(
                self.owed(run, cycle), logic.eq(rest, half)
            ),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        now, after, later = (run.on("pulse_o", cycle) for cycle in range(3))
        counts = [run.output("count_o", cycle) for cycle in (0, 1)]
        high = [logic.no(self.moderate(run, cycle)) for cycle in (0, 1)]
        undisturbed = [logic.eq(run.input("clear_i", cycle), 0) for cycle in (0, 1)] + [
            logic.eq(run.signal("start_q", 0), 0)
        ]
        counted = logic.add(counts[0], logic.extend(run.output("pulse_o", 0), 32))
        return {
            "never two pulses in a row": logic.no(logic.all(now, after)),
            "above half a pulse per clock one in every two clocks": logic.implies(
                logic.all(*high, *undisturbed), logic.ne(after, later)
            ),
            "count_o counts them": logic.eq(counts[1], counted),
            "no pulse in the clock after the first": logic.implies(
                run.on("start_q", 0), logic.no(after)
            ),
            "in the clock after clear_i the one that is due": logic.implies(
                logic.all(run.on("clear_i"), undisturbed[-1]),
                logic.eq(after, logic.all(logic.no(now), self.due(run))),
            ),
        }


@proof(
    "pulse_generator",
    "while rates are at most half a pulse per clock, as many pulses have started since the phase "
    "was centred as there are whole moduli in the sum of the rates and half a modulus, besides one "
    "that was due then; above, a pulse every other clock; never two in a row; count_o counts them",
    "any rates and clears; two moduli",
)
def pulse_sum(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "pulse_generator", PulseSum(MODULUS))
    other = 16 * 83_333_334  # with one trailing zero less
    yield from inductive(
        ctx, "pulse_generator", PulseSum(other), {"Modulus": other}, f"modulus {other}, "
    )
