# SPDX-License-Identifier: Apache-2.0
"""Proofs of ecat_unit, ecat_write_log and ecat_buffers: length and delay of frames, writes only of
committed frames, buffers that are never shared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bitwuzla import Term

from tests.formal.catalogue import Case, Context, proof
from tests.formal.induction import Values, inductive
from tests.formal.logic import Logic
from tests.formal.netlist import Run

DELAY = 8  # ticks of ecat_unit; a register of the output follows
VALID = 5  # bit of nibble_t


def is_one(run: Run, term: Term) -> Term:
    return run.logic.eq(term, 1)


class Delay:
    """Which of the last ticks' nibbles were valid, the newest in bit 0."""

    widths = {"history": DELAY + 1}

    def after_reset(self, logic: Logic) -> Values:
        return {"history": logic.bv(DELAY + 1, 0)}

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        logic = run.logic
        return {f"no frame circulates {n}": logic.eq(run.input("destroy_i", n), 0) for n in (0, 1)}

    def next(self, run: Run, own: Values) -> Values:
        logic = run.logic
        shifted = logic.add(own["history"], own["history"])
        came = logic.bit(run.input("nibble_i", 0), VALID)
        filled = logic.ite(came, logic.add(shifted, logic.bv(DELAY + 1, 1)), shifted)
        return {"history": logic.ite(is_one(run, run.input("tick_i", 0)), filled, own["history"])}

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        logic = run.logic
        inside = run.signal("valid_q", cycle)
        same = [logic.eq(logic.bit(inside, i), logic.bit(own["history"], i)) for i in range(DELAY)]
        leaves = logic.bit(run.output("nibble_o", cycle), VALID)
        return {
            "the stream is in the delay line": logic.all(*same),
            "nothing is destroyed": logic.eq(run.signal("destroyed_q", cycle), 0),
            "a nibble leaves when one came nine ticks before": logic.eq(
                leaves, logic.bit(own["history"], DELAY)
            ),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        return {}


@proof(
    "ecat_unit",
    "as many nibbles leave as came, each nine ticks behind its coming, whatever the frame holds",
    "any stream of nibbles, any answers, any ticks; no circulating frame",
    quick=True,
)
def frame_length_and_delay(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "ecat_unit", Delay())


class Committed:
    """Whether a commit has come since entries last went out whole."""

    widths = {"armed": 1}

    def after_reset(self, logic: Logic) -> Values:
        return {"armed": logic.bv(1, 0)}

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        return {}

    def next(self, run: Run, own: Values) -> Values:
        logic = run.logic
        commit, done = (is_one(run, run.input(n, 0)) for n in ("commit_i", "rst_ni"))
        ended = is_one(run, run.output("done_o", 0))
        kept = logic.ite(ended, logic.bv(1, 0), own["armed"])
        return {"armed": logic.ite(logic.all(commit, done), logic.bv(1, 1), kept)}

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        logic = run.logic
        busy, valid = (is_one(run, run.signal(n, cycle)) for n in ("busy_q", "valid_q"))
        return {
            "busy only behind a commit": logic.implies(busy, is_one(run, own["armed"])),
            "an entry only while busy": logic.implies(valid, busy),
            "an entry is there only while some are left": logic.implies(
                valid, logic.ne(run.signal("left_q", cycle), 0)
            ),
            "the end is waited for while some are left": logic.implies(
                logic.all(busy, logic.ne(run.signal("left_q", cycle), 0)),
                logic.ne(run.signal("drain_q", cycle), 0),
            ),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        logic = run.logic
        valid = is_one(run, run.output("valid_o", 0))
        return {
            "an entry leaves only behind a commit": logic.implies(valid, is_one(run, own["armed"]))
        }


@proof(
    "ecat_write_log",
    "no entry leaves without a commit, which only a good frame gives: a bad frame writes nothing",
    "any entries, commits and clears in any clock; four places",
    quick=True,
)
def only_committed_writes(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "ecat_write_log", Committed(), {"Depth": 4})


class Buffers:
    """Nothing of its own."""

    widths: Mapping[str, int] = {}
    names = ("writer_q", "reader_q", "middle_q")

    def after_reset(self, logic: Logic) -> Values:
        return {}

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        return {}

    def next(self, run: Run, own: Values) -> Values:
        return {}

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        logic = run.logic
        held = [run.signal(name, cycle) for name in self.names]
        pairs = [(0, 1), (0, 2), (1, 2)]
        return {
            "three different buffers": logic.all(*(logic.ne(held[a], held[b]) for a, b in pairs)),
            "of three": logic.all(*(logic.ne(each, 3) for each in held)),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        logic = run.logic
        quiet = logic.all(
            *(logic.eq(run.input(name, 0), 0) for name in ("clear_i", "opens_i")),
            is_one(run, run.input("rst_ni", 0)),
        )
        box = is_one(run, run.input("mailbox_i", 0))
        reader, writer = run.output("reader_o", 0), run.output("writer_o", 0)
        return {
            "a reader's buffer stays until it opens one": logic.implies(
                quiet, logic.eq(run.signal("reader_q", 1), run.signal("reader_q", 0))
            ),
            "writer and reader never meet": logic.any(box, logic.ne(reader, writer)),
        }


@proof(
    "ecat_buffers",
    "writer and reader never have one buffer; the reader's stays until it opens another, so that "
    "nothing that is read is torn",
    "any openings, ends, clears and modes in any clock",
    quick=True,
)
def three_buffers(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "ecat_buffers", Buffers())
