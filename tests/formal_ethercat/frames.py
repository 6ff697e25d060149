# SPDX-License-Identifier: Apache-2.0
"""Proofs of ecat_unit, ecat_write_log and ecat_buffers: length and delay of frames, commits only of
good frames and writes only of committed ones, buffers that never tear."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bitwuzla import Kind, Term

from tests.formal import logic
from tests.formal.catalogue import Case, Context, proof
from tests.formal.induction import Observer, Values, inductive, selected
from tests.formal.netlist import Run

DELAY = 8  # ticks of ecat_unit; a register of the output follows
VALID = 5  # bit of nibble_t


class Delay(Observer):
    """Which of the last ticks' nibbles were valid, the newest in bit 0."""

    widths = {"history": DELAY + 1}

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        whole = {f"no frame circulates {n}": run.input("destroy_i", n) for n in (0, 1)}
        whole |= {f"none is a fragment {n}": run.signal("fragment", n) for n in (0, 1)}
        return {name: logic.eq(term, 0) for name, term in whole.items()}

    def next(self, run: Run, own: Values) -> Values:
        shifted = logic.add(own["history"], own["history"])
        came = logic.bit(run.input("nibble_i", 0), VALID)
        filled = logic.ite(came, logic.add(shifted, 1), shifted)
        return {"history": logic.ite(run.on("tick_i", 0), filled, own["history"])}

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
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


@proof(
    "ecat_unit",
    "as many nibbles leave as came, each nine ticks after its arrival, whatever the frame holds",
    "any stream of nibbles, any answers, any ticks; no circulating frame, none below 64 bytes "
    "while port 0 is closed",
    quick=True,
)
def frame_length_and_delay(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "ecat_unit", Delay())


PLACES = 4


class Committed(Observer):
    """The present frame's entries in their order, and what of them has left since its commit."""

    widths = {
        **{"pushed": 3, "over": 1, "armed": 1, "committed": 3, "left": 3},
        **{f"entry{n}": 40 for n in range(PLACES)},
    }

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        busy = run.on("busy_o", 0)
        quiet = logic.all(*(logic.eq(run.input(n, 0), 0) for n in ("push_i", "commit_i")))
        return {"nothing comes while entries go out": logic.implies(busy, quiet)}

    def next(self, run: Run, own: Values) -> Values:
        names = ("clear_i", "push_i", "commit_i", "ready_i", "rst_ni")
        clear, push, commit, ready, live = (run.on(n, 0) for n in names)
        zero, one = logic.bv(3, 0), logic.bv(3, 1)
        full = logic.eq(own["pushed"], PLACES)
        comes = logic.all(push, logic.no(clear), logic.no(full))
        more = logic.ite(comes, logic.add(own["pushed"], one), own["pushed"])
        over = logic.any(logic.eq(own["over"], 1), logic.all(push, full))
        begins = logic.all(commit, logic.ne(own["pushed"], 0), logic.eq(own["over"], 0))
        taken = logic.all(run.on("valid_o", 0), ready)
        out = logic.ite(taken, logic.add(own["left"], one), own["left"])
        ended = run.on("done_o", 0)
        armed = logic.ite(ended, logic.bv(1, 0), own["armed"])
        after = {
            "pushed": logic.ite(clear, zero, more),
            "over": logic.vector(logic.all(logic.no(clear), over)),
            "armed": logic.ite(begins, logic.bv(1, 1), armed),
            "committed": logic.ite(begins, own["pushed"], own["committed"]),
            "left": logic.ite(begins, zero, out),
        }
        for n in range(PLACES):
            here = logic.all(comes, logic.eq(own["pushed"], n))
            after[f"entry{n}"] = logic.ite(here, run.input("entry_i", 0), own[f"entry{n}"])
        return selected(live, after, self.after_reset())

    def entry(self, run: Run, own: Values) -> Term:
        """The one whose turn it is."""
        found = own["entry0"]
        for n in range(1, PLACES):
            found = logic.ite(logic.eq(own["left"], n), own[f"entry{n}"], found)
        return found

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        busy, valid = (run.on(n, cycle) for n in ("busy_q", "valid_q"))
        left, place = run.signal("left_q", cycle), run.signal("place_q", cycle)
        kept = []
        for n in range(PLACES):
            same = logic.eq(run.signal(f"u_store.memory[{n}]", cycle), own[f"entry{n}"])
            going = logic.all(busy, logic.ult(logic.bv(3, n), own["committed"]))
            kept.append(
                logic.implies(logic.any(going, logic.ult(logic.bv(3, n), own["pushed"])), same)
            )
        return {
            "the present frame's entries are counted": logic.all(
                logic.eq(run.signal("count_q", cycle), own["pushed"]),
                logic.ule(own["pushed"], PLACES),
                logic.eq(run.signal("over_q", cycle), own["over"]),
            ),
            "and kept": logic.all(*kept),
            "busy only behind a commit": logic.implies(busy, logic.eq(own["armed"], 1)),
            "an entry only while busy": logic.implies(valid, busy),
            "what is left of it": logic.implies(
                busy,
                logic.all(
                    logic.eq(left, logic.sub(own["committed"], own["left"])),
                    logic.ule(own["left"], own["committed"]),
                    logic.ule(own["committed"], PLACES),
                    logic.eq(place, logic.bits(own["left"], 1, 0)),
                ),
            ),
            "an entry is there only while some are left": logic.implies(valid, logic.ne(left, 0)),
            "it is the one whose turn it is": logic.implies(
                valid, logic.eq(run.output("entry_o", cycle), self.entry(run, own))
            ),
            "the end is waited for while some are left": logic.implies(
                logic.all(busy, logic.ne(left, 0)), logic.ne(run.signal("drain_q", cycle), 0)
            ),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        valid = run.on("valid_o", 0)
        mine = logic.all(
            logic.eq(own["armed"], 1),
            logic.ult(own["left"], own["committed"]),
            logic.eq(run.output("entry_o", 0), self.entry(run, own)),
        )
        return {"what leaves is an entry of the committed frame": logic.implies(valid, mine)}


@proof(
    "ecat_write_log",
    "what leaves after a commit are the entries since the clear before it, those of the frame, "
    "in their order; nothing leaves without a commit",
    "any entries and commits in any clock but while entries go out, clears in any clock; four "
    "places",
    quick=True,
)
def only_committed_writes(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "ecat_write_log", Committed(), {"Depth": PLACES})


ONES, POLYNOMIAL, RESIDUE = 0xFFFFFFFF, 0x04C11DB7, 0xC704DD7B  # IEEE 802.3, 3.2.9
DELIMITER = 0xD
LATER = 3  # ticks from a frame's end until it is reported


class Sequence(Observer):
    """Frames of the stream, their check sequences computed from the highest power on, and which of
    the ends in the last ticks were those of good frames: the newest in bit 0."""

    widths = {
        **{"sum": 32, "inside": 1, "odd": 1, "error": 1, "few": 2},
        **{"ends": LATER, "good": LATER, "told": 1, "told_good": 1, "seen": 1, "newest": 1},
    }
    reset = {"sum": ONES}

    def next(self, run: Run, own: Values) -> Values:
        nibble = run.input("nibble_i", 0)
        data, valid, error = (
            logic.bits(nibble, 3, 0),
            logic.bit(nibble, VALID),
            logic.bit(nibble, VALID - 1),
        )
        inside = logic.eq(own["inside"], 1)
        before = logic.all(logic.no(inside), valid)
        begins = logic.all(before, logic.eq(data, DELIMITER))
        goes_on = logic.all(inside, valid)
        total = own["sum"]
        for n in range(4):
            feedback = logic.ne(logic.bits(total, 31, 31), logic.bits(data, n, n))
            shifted = logic.shl(total, 1)
            turned = logic.xor(shifted, POLYNOMIAL)
            total = logic.ite(feedback, turned, shifted)
        ends = logic.all(inside, logic.no(valid))
        good = logic.all(
            ends,
            logic.eq(own["sum"], RESIDUE),
            logic.eq(own["odd"], 0),
            logic.eq(own["error"], 0),
        )

        def pick(at_begin: Term, on: Term, kept: Term) -> Term:
            return logic.ite(before, at_begin, logic.ite(goes_on, on, kept))

        bit = {flag: logic.vector(term) for flag, term in (("error", error), ("ends", ends))}
        more = logic.ite(logic.ult(own["few"], 2), logic.add(own["few"], 1), own["few"])
        either = logic.op(Kind.BV_OR, own["error"], bit["error"])
        after = {
            "sum": pick(logic.bv(32, ONES), total, own["sum"]),
            "inside": logic.vector(logic.any(begins, goes_on)),
            "odd": pick(logic.bv(1, 0), logic.op(Kind.BV_NOT, own["odd"]), own["odd"]),
            "error": pick(bit["error"], either, own["error"]),
            "few": pick(logic.bv(2, 0), more, own["few"]),
            "ends": logic.cat(logic.bits(own["ends"], LATER - 2, 0), bit["ends"]),
            "good": logic.cat(logic.bits(own["good"], LATER - 2, 0), logic.vector(good)),
            "seen": logic.op(Kind.BV_OR, own["seen"], bit["ends"]),
            "newest": logic.ite(ends, logic.vector(good), own["newest"]),
        }
        tick = run.on("tick_i", 0)
        after = selected(tick, after, own)
        last = logic.bit(own["ends"], LATER - 1)
        after["told"] = logic.vector(logic.all(tick, last))
        after["told_good"] = logic.bits(own["good"], LATER - 1, LATER - 1)
        return selected(run.on("rst_ni", 0), after, self.after_reset())

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        state = run.signal("u_check.state_q", cycle)
        turned = logic.cat(*(logic.bits(state, n, n) for n in range(32)))
        flags = (("body_q", "inside"), ("odd_q", "odd"), ("error_q", "error"))
        newest, inside = logic.eq(own["newest"], 1), logic.eq(own["inside"], 1)
        ends = [logic.bit(own["ends"], n) for n in range(LATER)]
        goods = [logic.bit(own["good"], n) for n in range(LATER)]
        told, told_good = logic.eq(own["told"], 1), logic.eq(own["told_good"], 1)
        few = own["few"]
        return {
            "the sum is the check sequence": logic.eq(turned, own["sum"]),
            "frames begin and end alike": logic.all(
                *(logic.eq(run.signal(f"u_check.{a}", cycle), own[b]) for a, b in flags)
            ),
            "ends are told alike": logic.all(
                logic.eq(run.signal("end_q", cycle), own["ends"]),
                logic.eq(run.signal("end_pulse_q", cycle), own["told"]),
            ),
            "the newest end is known": logic.implies(
                logic.eq(own["seen"], 1), logic.ne(run.signal("end_bad_q", cycle), own["newest"])
            ),
            "an end was seen": logic.implies(logic.any(*ends, told), logic.eq(own["seen"], 1)),
            "few nibbles": logic.all(
                logic.implies(
                    logic.eq(few, 0),
                    logic.all(logic.eq(own["sum"], ONES), logic.eq(own["odd"], 0)),
                ),
                logic.implies(logic.eq(few, 1), logic.eq(own["odd"], 1)),
                logic.ule(few, 2),
            ),
            "few behind an end": logic.implies(
                inside,
                logic.all(
                    logic.no(ends[0]),
                    logic.implies(ends[1], logic.eq(few, 0)),
                    logic.implies(ends[2], logic.ule(few, 1)),
                ),
            ),
            "a good one is not behind a bad one that waits": logic.implies(
                newest,
                logic.all(
                    *(logic.implies(end, good) for end, good in zip(ends, goods, strict=True)),
                    logic.implies(told, told_good),
                ),
            ),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        right = logic.all(
            logic.eq(own["told"], 1),
            logic.eq(own["told_good"], 1),
            logic.eq(run.input("spoilt_i", 0), 0),
        )
        return {
            "a frame is called good only if it is": logic.implies(run.on("frame_good_o", 0), right)
        }


@proof(
    "ecat_unit",
    "the commit comes only after a frame whose check sequence is right (the residue of IEEE "
    "802.3), that has whole bytes, no RX_ER, and datagrams that are not malformed",
    "any stream of nibbles, frames as short and as near to each other as they may be, any ticks",
    quick=True,
)
def only_good_frames(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "ecat_unit", Sequence())


class Buffers(Observer):
    """A byte of the area, any one, in each of the three buffers; bit n of a word: in buffer n.

    whole: what it holds was written in the access that handed the buffer over. fresh: it was
    written since the writer's last access to the first byte. late, later: where a write of it
    went in the clock before and in the one before that; reads do not see those yet. begun,
    open: writer and reader are after the first byte and before the end. opened: the present
    frame has read the first byte. Constant, but any: whether the bus' side writes, whether the
    area is a mailbox.
    """

    widths: Mapping[str, int] = {
        **{"whole": 3, "late": 3, "later": 3},
        **{"fresh": 1, "begun": 1, "open": 1, "opened": 1},
    }
    reset = {"whole": 7}
    names = ("writer_q", "reader_q", "middle_q")
    kinds = ("passing", "commit", "reads", "writes", "first", "ends")

    def __init__(self) -> None:
        self.bus, self.box, self.byte = (
            logic.eq(logic.free(1, name), 1) for name in ("bus_writes", "mailbox", "is_the_byte")
        )

    def access(self, run: Run, own: Values) -> dict[str, Term]:
        """What the access of cycle 0 is and does, as truth values."""
        now = {name: run.on(f"{name}_i", 0) for name in self.kinds}
        now["live"] = run.on("rst_ni", 0)
        now["clear"] = run.on("clear_i", 0)
        now["start"] = run.on("frame_start_i", 0)
        allowed = run.on("begun_o", 0)
        now["handed"] = run.on("is_written_o", 0)
        now["write"] = logic.all(now["writes"], logic.no(now["passing"]))
        now["read"] = logic.all(now["reads"], logic.no(now["commit"]), allowed)
        now["begun"] = logic.any(now["first"], logic.eq(own["begun"], 1))
        # Good frames' writes are in the log already; the application's may be refused.
        now["store"] = logic.all(now["write"], logic.any(now["commit"], allowed), self.byte)
        kept = logic.all(logic.eq(own["fresh"], 1), logic.no(now["first"]))
        now["fresh"] = logic.any(now["store"], kept)
        return now

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        now = self.access(run, own)
        by_bus = logic.any(now["passing"], now["commit"])
        boxes = [logic.eq(run.on("mailbox_i", n), self.box) for n in (0, 1)]
        return {
            "an access is of one kind": logic.no(logic.all(now["passing"], now["commit"])),
            "and reads or writes": logic.no(logic.all(now["reads"], now["writes"])),
            "one side writes": logic.implies(now["writes"], logic.eq(by_bus, self.bus)),
            "the other one reads": logic.implies(now["reads"], logic.ne(by_bus, self.bus)),
            "the mode stays": logic.all(*boxes),
            "a writer that begins leaves no byte out": logic.implies(
                logic.all(now["write"], now["ends"], now["begun"]), now["fresh"]
            ),
            "no write in the two clocks after the last byte": logic.implies(
                now["write"], logic.eq(run.signal("settle_q", 0), 0)
            ),
        }

    def next(self, run: Run, own: Values) -> Values:
        now = self.access(run, own)
        writer = self.only(run.output("writer_o", 0))
        none, truth = logic.bv(3, 0), logic.vector
        store = logic.ite(now["store"], writer, none)
        others = logic.op(Kind.BV_AND, own["whole"], logic.op(Kind.BV_NOT, writer))
        handed = logic.op(Kind.BV_OR, others, logic.ite(now["fresh"], writer, none))
        ends, no = now["ends"], logic.no
        bus_ends = logic.all(now["reads"], now["commit"], ends)
        app_ends = logic.all(now["read"], no(now["passing"]), ends)
        opens = logic.all(now["read"], now["first"])
        after = {
            "whole": logic.ite(
                now["handed"], handed, logic.ite(now["store"], others, own["whole"])
            ),
            "late": store,
            "later": own["late"],
            "fresh": truth(logic.all(now["fresh"], no(now["handed"]))),
            "begun": logic.ite(
                now["write"], truth(logic.all(now["begun"], no(ends))), own["begun"]
            ),
            "open": truth(
                logic.all(
                    no(logic.any(bus_ends, app_ends)), logic.any(opens, logic.eq(own["open"], 1))
                )
            ),
            "opened": truth(
                logic.all(
                    no(now["start"]),
                    logic.any(logic.all(now["passing"], opens), logic.eq(own["opened"], 1)),
                )
            ),
        }
        cleared = logic.any(now["clear"], no(now["live"]))
        return selected(cleared, self.after_reset(), after)

    def only(self, buffer: Term) -> Term:
        """The word with this buffer's bit."""
        return logic.vector(*(logic.eq(buffer, n) for n in (2, 1, 0)))

    def has(self, word: Term, buffer: Term) -> Term:
        return logic.ne(logic.op(Kind.BV_AND, word, self.only(buffer)), 0)

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        held = [run.signal(name, cycle) for name in self.names]
        writer, reader, middle = held
        pairs = [(0, 1), (0, 2), (1, 2)]
        flag = {
            name: run.on(f"{name}_q", cycle)
            for name in ("new", "passing", "committed", "application", "opened")
        }
        settle = run.signal("settle_q", cycle)
        side = logic.ite(self.bus, flag["committed"], flag["application"])
        reads = logic.ite(
            self.bus, flag["application"], logic.any(flag["passing"], flag["committed"])
        )
        buffered = {
            "a buffer that the reader has not opened keeps its event": logic.implies(
                flag["new"], run.on("written_o", cycle)
            ),
            "what is or comes next is whole": logic.all(
                self.has(own["whole"], reader),
                logic.implies(flag["new"], self.has(own["whole"], middle)),
            ),
            "no write is on its way to the reader": logic.no(
                logic.any(*(self.has(own[name], reader) for name in ("late", "later")))
            ),
            "nor to the newest": logic.no(
                logic.any(*(self.has(own[name], middle) for name in ("late", "later")))
            ),
            "what settles is whole": logic.implies(
                logic.ne(settle, 0), self.has(own["whole"], writer)
            ),
            "and its writer has not begun again": logic.implies(
                logic.ne(settle, 0), logic.eq(own["begun"], 0)
            ),
            "its last byte is on its way": logic.all(
                logic.ne(settle, 3), logic.implies(logic.eq(settle, 2), logic.eq(own["late"], 0))
            ),
        }
        return {
            "three different buffers": logic.all(*(logic.ne(held[a], held[b]) for a, b in pairs)),
            "of three": logic.all(*(logic.ne(each, 3) for each in held)),
            "the writer is where it was seen": logic.eq(side, logic.eq(own["begun"], 1)),
            "the reader is where it was seen": logic.implies(reads, logic.eq(own["open"], 1)),
            "the frame has opened": logic.implies(logic.eq(own["opened"], 1), flag["opened"]),
            **{name: logic.any(self.box, term) for name, term in buffered.items()},
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        now = self.access(run, own)
        reader, writer = run.output("reader_o", 0), run.output("writer_o", 0)
        same = logic.eq(run.signal("reader_q", 1), run.signal("reader_q", 0))
        quiet = logic.all(now["live"], logic.no(now["clear"]))
        opens = logic.all(now["read"], now["first"])
        again = logic.all(now["passing"], logic.eq(own["opened"], 1))
        late = (self.has(own[name], reader) for name in ("late", "later"))
        whole = logic.all(self.has(own["whole"], reader), logic.no(logic.any(*late)))
        return {
            "a reader's buffer stays until it opens one": logic.implies(
                logic.all(quiet, logic.any(logic.no(opens), again)), same
            ),
            "writer and reader never meet": logic.any(self.box, logic.ne(reader, writer)),
            "what is read is of one write": logic.any(
                self.box, logic.implies(logic.all(quiet, now["read"]), whole)
            ),
            "only what was begun is handed over": logic.implies(now["handed"], now["begun"]),
            "nothing is read before the first byte": logic.implies(
                now["read"], logic.any(now["first"], logic.eq(own["open"], 1))
            ),
        }


@proof(
    "ecat_buffers",
    "three buffers never tear: each byte that is read, from the first one on, was written in the "
    "one access that handed its buffer over, and is in the memory; writer and reader never have "
    "one buffer; the reader's stays until it opens another, a frame's for the whole frame; a "
    "complete buffer that the reader has not opened keeps its event",
    "any accesses of frames, commits and the application, in any clock, that end or break off "
    "anywhere; a writer that reaches the end has written each byte since the first, and pauses for "
    "two clocks",
    quick=True,
)
def three_buffers(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, "ecat_buffers", Buffers())
