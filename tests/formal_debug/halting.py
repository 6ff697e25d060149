# SPDX-License-Identifier: Apache-2.0
"""Proofs of the debug block: a held core issues nothing, a page is taken between two runs."""

from __future__ import annotations

from collections.abc import Iterator

from tests.formal import logic
from tests.formal.catalogue import Case, Context, proof

CONFIGURATIONS = {
    "fast": {"FmaPipes": 2, "Slots": 3},
    "small": {"FmaPipes": 1, "Slots": 1},
}


@proof(
    "asip_issue",
    "a bundle that is marked in Q or D does not issue in the next clock, both configurations",
    "any state and inputs",
    quick=True,
)
def marked_bundle(ctx: Context) -> Iterator[Case]:
    for name, parameters in CONFIGURATIONS.items():
        run = ctx.run("asip_issue", parameters)
        moves = run.on("advance_o", 0)
        in_q, in_d = run.on("bad_q_i"), run.on("bad_d_i")
        marked = logic.ite(moves, in_q, in_d)
        yield Case(name, logic.eq(run.output("issue_o", 1), 0), (marked,))


@proof(
    "debug_run",
    "a core that is held has the bundles in Q and D marked, except one that a step or resume "
    "releases; nothing but a register write ends the hold; a bundle with a breakpoint is marked",
    "any state and inputs",
    quick=True,
)
def held_core(ctx: Context) -> Iterator[Case]:
    run = ctx.run("debug_run")
    held, kept = run.on("held_q"), logic.no(run.on("release_q"))
    no_write = logic.eq(run.input("csr_write_i"), 0)
    stops = [run.on(port, 0) for port in ("stop_q_o", "stop_d_o")]
    yield Case("marked in Q", stops[0], (held,))
    yield Case("marked in D", stops[1], (held, kept))
    yield Case("hold stays", run.on("held_q", 1), (held, no_write))
    issued = run.on("issue_i")
    yield Case("one release, one bundle", logic.no(run.on("release_q", 1)), (issued, no_write))
    yield Case("no release by itself", logic.no(run.on("release_q", 1)), (kept, no_write))
    halted = run.on("halted_q", 1)
    waits = run.on("waits", 0)
    entered = logic.all(waits, held, kept)
    yield Case("halted at a bundle that waits", logic.any(run.on("halted_q"), entered), (halted,))
    for stage, stop in (("q", stops[0]), ("d", stops[1])):
        some = logic.ne(run.signal(f"match_{stage}_q", 0), 0)
        assumed = (some,) if stage == "q" else (some, kept)
        yield Case(f"breakpoint in {stage.upper()}", stop, assumed)
    disabled = logic.eq(run.signal("enable_q", 0), 0)
    yield Case("disabled, none in D", logic.eq(run.signal("match_d_q", 1), 0), (disabled,))


@proof(
    "debug_stage",
    "staged words are written while the core is idle, one a clock to the last; a run keeps the "
    "version it began with; the version counts whole pages",
    "any state and inputs",
    quick=True,
)
def staged_page(ctx: Context) -> Iterator[Case]:
    run = ctx.run("debug_stage")
    write = run.on("write_o", 0)
    busy = [run.on("core_busy_i", cycle) for cycle in (0, 1)]
    taken = logic.eq(run.input("wait_i"), 0)
    last = run.on("last", 0)
    yield Case("only while idle", logic.no(busy[0]), (write,))
    goes_on = run.on("write_o", 1)
    yield Case("to the last word", goes_on, (write, taken, logic.no(last), logic.no(busy[1])))
    version = [run.output("version_o", cycle) for cycle in (0, 1)]
    counted = logic.add(version[0], 1)
    yield Case("a page more", logic.eq(version[1], counted), (last,))
    yield Case("no page more", logic.eq(version[1], version[0]), (logic.no(last),))
    start = run.on("run_start_i")
    own = [run.output("run_version_o", cycle) for cycle in (0, 1)]
    yield Case("version of a run", logic.eq(own[1], version[0]), (start,))
    yield Case("kept during the run", logic.eq(own[1], own[0]), (logic.no(start),))


@proof(
    "core_bus",
    "an access of the first side goes to the core alone once the other side's is finished",
    "any state and inputs",
    quick=True,
)
def bus_of_a_commit(ctx: Context) -> Iterator[Case]:
    run = ctx.run("core_bus")
    write = run.on("sequencer_write_i")
    free = logic.eq(run.signal("begun_q", 0), 0)
    same = [
        logic.eq(run.output(f"{port}_o", 0), run.input(f"sequencer_{port}_i"))
        for port in ("address", "data", "write", "read")
    ]
    waits = run.on("host_wait_o", 0)
    yield Case("its own word", logic.all(*same), (write, free))
    yield Case("the other side waits", waits, (write, free))
    yield Case("nothing begins meanwhile", logic.eq(run.signal("begun_q", 1), 0), (write, free))


@proof(
    "asip_control",
    "busy matches the state, and an idle core without a start request stays idle",
    "any state that busy matches, any inputs",
    quick=True,
)
def idle_core(ctx: Context) -> Iterator[Case]:
    run = ctx.run("asip_control")
    busy = [run.on("busy_o", cycle) for cycle in (0, 1)]
    state = [
        logic.any(*(run.on(name, cycle) for name in ("active", "start_q"))) for cycle in (0, 1)
    ]
    known = logic.eq(busy[0], state[0])
    unasked = logic.eq(run.input("start_i"), 0)
    yield Case("busy is the state", logic.eq(busy[1], state[1]), (known,))
    yield Case("no run by itself", logic.no(busy[1]), (known, logic.no(busy[0]), unasked))
