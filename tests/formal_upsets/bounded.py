# SPDX-License-Identifier: Apache-2.0
"""Proof that a tick with redundancy ends: a rank of its state falls in every clock.

The state is any, legal or not, as an upset may leave it, and control may answer what it likes. The
rank is a number of clocks: what is left of this run, and a whole run for each one after it. It is
at most 3 (WATCHDOG + Drain + MARGIN) when a run is on, so busy_o falls within that.
"""

from __future__ import annotations

from collections.abc import Iterator

from tests.formal import logic
from tests.formal.catalogue import Case, Context, proof

WIDTH = 40  # bits of a rank
DRAIN, MARGIN = 256, 80  # parameter of the RTL; clocks of a copy, a reset and a launch, rounded up
IDLE, LAUNCH, RUN, SCRUB, COPY = 0, 1, 2, 3, 4  # states
STATE, TIMES, START, FAULT, DIRTY, SAVE = (15, 13), (12, 11), 10, 8, 6, 5  # in control_q


@proof(
    "asip_redundancy",
    "busy_o falls within 3 (WATCHDOG + 256 + 80) clocks once a run is on, whatever control does, "
    "and a start that waits becomes a run: a rank falls in every clock",
    "any state, legal or not; no write of registers and no clear meanwhile, and a core that is not "
    "running is not busy",
)
def busy_ends(ctx: Context) -> Iterator[Case]:
    run = ctx.run("asip_redundancy")

    def number(value: int):
        return logic.bv(WIDTH, value)

    limit = logic.add(logic.extend(run.input("watchdog_i"), WIDTH), DRAIN)
    whole = logic.add(limit, MARGIN)  # a run with all that comes before it

    def copied(cycle: int):
        return logic.extend(logic.bits(run.signal("count_q", cycle), 6, 0), WIDTH)

    def rank(cycle: int):
        control = run.signal("control_q", cycle)
        state, times = logic.bits(control, *STATE), logic.bits(control, *TIMES)
        spent = logic.add(logic.sign_extend(run.signal("count_q", cycle), WIDTH), DRAIN)
        copy = copied(cycle)
        rest = logic.sub(number(66), logic.ite(logic.ule(copy, 64), copy, number(64)))
        inside = logic.ite(logic.ule(spent, limit), logic.sub(limit, spent), number(0))
        later = logic.ite(logic.eq(times, 1), logic.add(whole, whole), number(0))
        later = logic.ite(logic.eq(times, 2), whole, later)
        now = logic.add(limit, 75)  # a state that is none
        now = logic.ite(logic.eq(state, SCRUB), logic.add(limit, 70), now)
        now = logic.ite(logic.eq(state, COPY), logic.add(limit, 2, rest), now)
        now = logic.ite(logic.eq(state, LAUNCH), logic.add(limit, 1), now)
        now = logic.ite(logic.eq(state, RUN), inside, now)
        return logic.add(later, now)

    start = [logic.bit(run.signal("control_q", c), START) for c in (0, 1)]
    busy = [run.on("busy_o", cycle) for cycle in (0, 1)]
    on = [logic.ne(logic.bits(run.signal("control_q", cycle), *TIMES), 0) for cycle in (0, 1)]
    same = logic.eq(run.input("watchdog_i", 1), run.input("watchdog_i"))
    quiet = [logic.eq(run.input(name), 0) for name in ("clear_i", "write_register_i")]
    show = {name: run.signal(name, 0) for name in ("control_q", "inverse_q", "count_q")}
    lower = logic.ult(rank(1), rank(0))
    falls = logic.any(
        logic.no(busy[1]), logic.all(on[1], lower), logic.all(start[1], logic.no(on[1]))
    )
    state = logic.bits(run.signal("control_q", 0), *STATE)
    negative = logic.bit(run.signal("count_q", 0), 32)
    inside = logic.eq(state, RUN)
    for name, part in (
        ("behind Drain", logic.all(inside, logic.no(negative))),
        ("within Drain", logic.all(inside, negative)),
        ("copy", logic.eq(state, COPY)),
        ("no run or copy", logic.no(logic.any(inside, logic.eq(state, COPY)))),
    ):
        yield Case(f"a run that is on, {name}", falls, (on[0], same, part, *quiet), show)
    bound = logic.add(whole, whole, whole)
    yield Case("the bound", logic.ule(rank(0), bound), (on[0],), show)
    broken = run.on("broken", 0)
    yield Case("no code, no run", logic.no(busy[1]), (broken, *quiet), show)

    # A start that waits while nothing runs: copies of pages, then the run.
    def waiting(cycle: int):
        control = run.signal("control_q", cycle)
        state = logic.bits(control, *STATE)
        copy = copied(cycle)
        rest = logic.sub(number(70), logic.ite(logic.ule(copy, 64), copy, number(64)))
        pages = number(0)
        for bit, clocks in ((DIRTY, 200), (SAVE, 100)):
            pages = logic.ite(logic.bit(control, bit), logic.add(number(clocks), pages), pages)
        now = number(90)
        now = logic.ite(logic.eq(state, IDLE), number(80), now)
        now = logic.ite(logic.eq(state, SCRUB), number(85), now)
        idle_copy = logic.all(logic.eq(state, COPY), logic.eq(pages, 0))
        now = logic.ite(logic.eq(state, COPY), rest, now)
        return logic.add(pages, now, logic.ite(idle_copy, number(100), number(0)))

    waits = logic.all(start[0], logic.no(on[0]))
    still = logic.eq(run.input("busy_i"), 0)
    goes_on = logic.any(on[1], logic.no(busy[1]), logic.ult(waiting(1), waiting(0)))
    yield Case("a start that waits", goes_on, (waits, still, *quiet), show)


@proof(
    "asip_redundancy",
    "a fault stays until CLEAR, and no run is on or waits meanwhile; a start that waits is none of "
    "a run that is on",
    "any state that meets this, any inputs",
    quick=True,
)
def fault_stays(ctx: Context) -> Iterator[Case]:
    run = ctx.run("asip_redundancy")

    def state(cycle: int):
        control = run.signal("control_q", cycle)
        fault, start = logic.bit(control, FAULT), logic.bit(control, START)
        idle = logic.eq(logic.bits(control, *TIMES), 0)
        alone = logic.any(idle, logic.no(start))
        return fault, logic.all(alone, logic.any(logic.no(fault), logic.all(idle, logic.no(start))))

    (before, holds), (after, kept) = state(0), state(1)
    clear = run.on("clear_i")
    show = {"control_q": run.signal("control_q", 0), "inverse_q": run.signal("inverse_q", 0)}
    yield Case("each clock", kept, (holds,), show)
    yield Case("until CLEAR", after, (holds, before, logic.no(clear)), show)
