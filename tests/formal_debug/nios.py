# SPDX-License-Identifier: Apache-2.0
"""Proofs of the debug module of the Nios core: halt, instructions of the host, resume."""

from __future__ import annotations

from collections.abc import Iterator

from tests.formal import logic
from tests.formal.catalogue import Case, Context, proof

EVENT = {"en": 36, "issue_d": 35, "break_m": 34, "return_m": 33}
"""Bits of n2_pkg::debug_event_t."""


@proof(
    "n2_debug",
    "no breakpoint acts without a debugger or in a halted core; a halt is pending until it is"
    " taken; a core stays halted until bret, after which one instruction always issues; an"
    " instruction of the host goes only to a halted core, and is valid for one moving clock",
    "any state and inputs, the core not in reset",
    quick=True,
)
def halted_nios(ctx: Context) -> Iterator[Case]:
    run = ctx.run("n2_debug")
    event = run.input("event_i")
    does = {name: logic.bit(event, bit) for name, bit in EVENT.items()}
    enabled, halted, first, pending = (
        run.on(f"{n}_q") for n in ("enable", "halted", "first", "pending")
    )
    breaks = run.on("break_d_o", 0)
    watched = run.on("watch_e_o", 0)
    stops = logic.any(breaks, watched)
    on = logic.all(*(run.on("core_rst_ni", cycle) for cycle in (0, 1)))
    yield Case("nothing without a debugger", logic.no(stops), (logic.no(enabled),))
    yield Case("nothing in a halted core", logic.no(stops), (halted,))
    yield Case("first instruction behind bret", logic.no(breaks), (first,))
    some = logic.ne(run.signal("stops_d", 0), 0)
    runs = (enabled, logic.no(halted), logic.no(first))
    yield Case("a breakpoint stops", breaks, (*runs, some))
    yield Case("a request stops", breaks, (*runs, pending))
    taken = logic.all(does["break_m"], enabled)
    yield Case("a request is kept", run.on("pending_q", 1), (pending, logic.no(taken)))
    yield Case(
        "a request is taken", logic.no(run.on("pending_q", 1)), (taken, logic.no(run.on("halt")))
    )
    seen = logic.all(watched, does["en"], logic.no(taken))
    yield Case("a watched access asks", run.on("pending_q", 1), (seen,))
    yield Case("halts", run.on("halted_q", 1), (on, taken))
    returns = does["return_m"]
    yield Case("stays halted", run.on("halted_q", 1), (on, halted, logic.no(returns)))
    yield Case("goes on", logic.no(run.on("halted_q", 1)), (on, halted, returns, logic.no(taken)))
    yield Case("one instruction is next", run.on("first_q", 1), (on, halted, returns))
    yield Case("until it issues", run.on("first_q", 1), (on, first, logic.no(does["issue_d"])))
    none = logic.no(logic.all(halted, returns))
    yield Case("and no other", logic.no(run.on("first_q", 1)), (on, does["issue_d"], none))
    idle, busy = logic.eq(run.signal("count_q", 0), 0), logic.ne(run.signal("count_q", 1), 0)
    yield Case("host's instructions go to a halted core", halted, (idle, busy))
    valid = [logic.eq(run.signal("count_q", cycle), 4) for cycle in (0, 1)]
    yield Case("valid for one clock", logic.no(valid[1]), (on, valid[0], does["en"]))
    yield Case("valid until the pipeline moves", valid[1], (on, valid[0], logic.no(does["en"])))
