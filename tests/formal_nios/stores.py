# SPDX-License-Identifier: Apache-2.0
"""Proof of the store buffer of n2_lsu: a load reads what the last stores before it wrote.

The observer watches one word, which may be any word of a memory. It has the word as stores change
it in stage E (`told`) and as the memory's port writes it (`stored`), what the port read (`read`),
and what a load of the word in stage M must get (`due`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bitwuzla import Term

from tests.formal import logic
from tests.formal.catalogue import Case, Context, proof
from tests.formal.induction import Observer, Values, inductive
from tests.formal.netlist import Run

WORD = 14  # bits of a word address in a memory of 64 KiB
BASES = {"itcm": 0x1000_0000, "dtcm": 0x1004_0000}  # as the module has them by default


def merged(old: Term, new: Term, lanes: Term) -> Term:
    """`new` in the bytes of `lanes`, `old` in the others."""
    parts = []
    for lane in reversed(range(4)):
        high, low = 8 * lane + 7, 8 * lane
        chosen = (logic.bits(new, high, low), logic.bits(old, high, low))
        parts.append(logic.ite(logic.bit(lanes, lane), *chosen))
    return logic.cat(*parts)


class WatchedWord(Observer):
    """One word of one memory. `at` is its address, which does not change."""

    widths = {
        "at": WORD,
        **{name: 32 for name in ("told", "stored", "read", "due")},
        **{name: 1 for name in ("is_read", "is_due")},
    }

    def __init__(self, memory: str) -> None:
        self.memory = memory

    def after_reset(self) -> Values:
        word = logic.free(32, "first content")
        anything = {name: logic.free(32, f"first {name}") for name in ("read", "due")}
        none = {name: logic.bv(1, 0) for name in ("is_read", "is_due")}
        return {"at": logic.free(WORD, "at"), "told": word, "stored": word, **anything, **none}

    # ---- words of the specification ----
    def here(self, run: Run, own: Values) -> Term:
        """The access in E is to the watched word."""
        address = self.address(run)
        upper = logic.eq(logic.bits(address, 31, WORD + 2), BASES[self.memory] >> (WORD + 2))
        return logic.all(upper, logic.eq(logic.bits(address, WORD + 1, 2), own["at"]))

    def address(self, run: Run) -> Term:
        """Byte address of the access in E."""
        return logic.add(run.input("base_e_i"), logic.sign_extend(run.input("offset_e_i"), 32))

    def store(self, run: Run) -> tuple[Term, Term, Term]:
        """Whether E has an aligned store that will complete; its word and its bytes."""
        low, size = logic.bits(self.address(run), 1, 0), run.input("size_e_i")
        byte, half = logic.eq(size, 0), logic.eq(size, 1)
        data = run.input("data_e_i")
        aligned = logic.any(
            byte,
            logic.all(half, logic.no(logic.bit(low, 0))),
            logic.eq(low, 0),
        )
        one = logic.shl(logic.bv(4, 1), logic.extend(low, 4))
        two = logic.shl(logic.bv(4, 3), logic.extend(low, 4))
        lanes = logic.ite(byte, one, logic.ite(half, two, logic.bv(4, 15)))
        bytes_ = logic.cat(*[logic.bits(data, 7, 0)] * 4)
        halves = logic.cat(*[logic.bits(data, 15, 0)] * 2)
        word = logic.ite(byte, bytes_, logic.ite(half, halves, data))
        return logic.all(run.on("live_e_i"), run.on("store_e_i"), aligned), word, lanes

    def buffered(self, run: Run, own: Values, cycle: int) -> Term:
        """The buffer has bytes of the watched word."""
        address = logic.bits(run.signal("buffer_address_q", cycle), WORD - 1, 0)
        return logic.all(run.on(f"buffer_{self.memory}_q", cycle), logic.eq(address, own["at"]))

    def with_buffer(self, run: Run, own: Values, word: Term, cycle: int) -> Term:
        """`word` after the buffer is written to it."""
        newer = merged(word, *(run.signal(f"buffer_{n}_q", cycle) for n in ("wdata", "lanes")))
        return logic.ite(self.buffered(run, own, cycle), newer, word)

    # ---- the observer ----
    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        read = run.input(f"{self.memory}_rdata_i", 0)
        return {
            "one access": logic.no(logic.all(run.on("load_e_i"), run.on("store_e_i"))),
            "the memory reads": logic.implies(
                logic.eq(own["is_read"], 1), logic.eq(read, own["read"])
            ),
        }

    def next(self, run: Run, own: Values) -> Values:
        moves, here = run.on("en_i"), self.here(run, own)
        stores, word, lanes = self.store(run)
        at_port = logic.eq(run.output(f"{self.memory}_address_o", 0), own["at"])
        enabled = run.on(f"{self.memory}_en_o", 0)
        written = merged(
            own["stored"],
            run.output(f"{self.memory}_wdata_o", 0),
            run.output(f"{self.memory}_we_o", 0),
        )
        loads = logic.all(run.on("live_e_i"), run.on("load_e_i"), here)
        return {
            "at": own["at"],
            "told": logic.ite(
                logic.all(moves, stores, here), merged(own["told"], word, lanes), own["told"]
            ),
            "stored": logic.ite(logic.all(enabled, at_port), written, own["stored"]),
            "read": logic.ite(enabled, own["stored"], own["read"]),
            "is_read": logic.ite(enabled, logic.vector(at_port), own["is_read"]),
            "due": logic.ite(moves, own["told"], own["due"]),
            "is_due": logic.ite(moves, logic.vector(loads), own["is_due"]),
        }

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        due = logic.eq(own["is_due"], 1)
        other = next(name for name in BASES if name != self.memory)
        at = logic.eq(logic.bits(run.signal("address_m_q", cycle), WORD + 1, 2), own["at"])
        in_m = (run.on(f"{self.memory}_m_q", cycle), logic.no(run.on(f"{other}_m_q", cycle)))
        now = self.with_buffer(run, own, own["read"], cycle)
        both = (run.on(f"buffer_{name}_q", cycle) for name in BASES)
        return {
            "memory and buffer": logic.eq(
                own["told"], self.with_buffer(run, own, own["stored"], cycle)
            ),
            "one memory": logic.no(logic.all(*both)),
            "load in M": logic.implies(
                due, logic.all(at, *in_m, logic.eq(own["is_read"], 1), logic.eq(now, own["due"]))
            ),
        }

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        in_m = logic.all(run.on("en_i"), logic.eq(own["is_due"], 1))
        stored = logic.eq(then["stored"], own["told"])
        free = logic.all(run.on("en_i"), logic.no(run.on("load_e_i")))
        return {
            "a load gets its word": logic.implies(
                in_m, logic.eq(run.signal("raw_a_q", 1), own["due"])
            ),
            "written unless E has a load": logic.implies(free, stored),
        }


@proof(
    "n2_lsu",
    "a load from either memory gets the bytes of the last stores before it, whatever waits in the"
    " store buffer; the buffer is written in the first clock in which the pipeline moves without a"
    " load in stage E",
    "any state and inputs, no load and store at once",
    quick=True,
)
def buffered_stores(ctx: Context) -> Iterator[Case]:
    for memory in BASES:
        yield from inductive(ctx, "n2_lsu", WatchedWord(memory), prefix=f"{memory}: ")
