# SPDX-License-Identifier: Apache-2.0
"""Proof of step_interpolator: steps of the interpolator reach the axes of the plane."""

from __future__ import annotations

from collections.abc import Iterator

from tests.formal import logic
from tests.formal.catalogue import Case, Context, proof

PLANES = (("G17", "xy"), ("G18", "zx"), ("G19", "yz"))  # code: axes of u and v
OUTPUT = "zyx"  # of step_o and negative_o, most significant bit first


@proof(
    "step_interpolator",
    "steps and directions of the line or arc interpolator reach the two axes of the plane G17, "
    "G18, G19, the third axis stays; no step without valid_o",
    "any steps of the interpolators",
    quick=True,
)
def plane_axes(ctx: Context) -> Iterator[Case]:
    run = ctx.run("step_interpolator")
    arc = run.on("arc_q", 1)
    line_step, arc_step = run.signal("line_step", 0), run.signal("arc_step", 1)
    step = logic.ite(arc, arc_step, line_step)  # the line's a clock later
    way = logic.ite(arc, run.signal("arc_negative", 1), run.signal("line_negative", 1))
    valid = run.on("valid_o", 1)
    taken = logic.all(
        run.on("advance_i"),
        logic.eq(run.signal("arc_q", 0), 0),
        run.on("line_active", 0),
    )
    by_arc = run.on("arc_valid", 1)
    running = logic.eq(run.input("flush_i"), 0)
    yield Case("valid_o", logic.eq(valid, logic.ite(arc, by_arc, taken)), (running,))
    yield Case("no step else", logic.implies(logic.no(valid), logic.eq(run.output("step_o", 1), 0)))
    for code, (name, axes) in enumerate(PLANES):
        here = logic.eq(run.signal("plane_q", 1), code)

        def spread(bits, axes=axes):
            parts = {axis: logic.bits(bits, i, i) for i, axis in enumerate(axes)}
            return logic.cat(*(parts.get(axis, logic.bv(1, 0)) for axis in OUTPUT))

        same = [
            logic.eq(run.output(port, 1), spread(bits))
            for port, bits in (("step_o", step), ("negative_o", way))
        ]
        yield Case(name, logic.all(*same), (here, valid))
    kept = [logic.eq(run.signal(n, 1), run.signal(n, 0)) for n in ("plane_q", "arc_q")]
    taken_over = [
        logic.eq(run.signal(n, 1), run.input(port))
        for n, port in (("plane_q", "plane_i"), ("arc_q", "arc_i"))
    ]
    begins = run.on("start_i")
    job = logic.ite(begins, logic.all(*taken_over), logic.all(*kept))
    yield Case("plane of the job", job, (running,))
    yield Case("nothing after a flush", logic.no(valid), (logic.no(running),))
