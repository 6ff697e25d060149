# SPDX-License-Identifier: Apache-2.0
"""Loops on the core against the instruction-set model: order, words, cycles, faults, the host.

No cycle of a loop is lost: the issue cycles are those of its rounds written out.
"""

from __future__ import annotations

import itertools
import random

import pytest

from asip_asm.assemble import assemble
from asip_asm.diagnostics import AssemblyError
from asip_asm.disassemble import disassemble
from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.image import Image
from asip_asm.isa import LOOP_BITS
from asip_asm.link import link
from sim.core.iss import Iss
from sim.rtl.asip_bus import CLEAR, CSR, START, register_address
from tests.asip import core_bench as bench
from tests.asip.core_bench import HALT, ISA, op
from tests.asip.test_core_random import check
from tests.bench.seed import SEED
from tests.debug.campaigns import random_halts

PROGRAMS = 20  # random ones
HALTS = 50  # runs that are halted
LEVELS = ISA.configurations["stream"].loops
MOST = 1 << LOOP_BITS  # rounds of a loop


def program(*rows: str, head: str = "") -> Image:
    """Image of bundles in braces; c0..c3 and the integer constants one and two are there."""
    lines = [".config stream", *(f".state s{i} : int = 0, pin c{i}" for i in range(4))]
    lines += [".const k1 = 1 : int", ".const k2 = 2 : int", head]
    return bench.assembled("\n".join([*lines, *rows, "{ nop } halt", ""]))


def count(i: int) -> str:
    """Bundle that counts how often it runs, in c<i>."""
    return f"{{ iadd c{i}, c{i}, k1 }}"


def test_random_programs__order_words_flags_and_cycles_of_the_model():
    print(f"SEED={SEED}")
    assert sum(check("stream", "loops", number) for number in range(PROGRAMS)) > 3_500


@pytest.mark.full
def test_random_programs__many__order_words_flags_and_cycles_of_the_model():
    print(f"SEED={SEED}")
    for number in range(1000, 1400):
        check("stream", "loops", number)


@pytest.mark.parametrize("bundles", [3, 4, 7])
def test_rounds__cost_their_bundles_and_nothing_else(bundles):
    got = bench.verify(program("{ loop 11 }", *["{ nop }"] * bundles, "endloop"))
    assert got.issue_cycles == list(range(11 * bundles + 2))
    assert sum(got.stalls.values()) == got.stalls["DRAIN"]


@pytest.mark.parametrize(
    ("level", "rounds"), [(n, r) for n in range(LEVELS) for r in (1, 2, 3, 4, 255, 256, 257)]
)
def test_count__every_level__as_many_rounds_as_written(level, rounds):
    rows = ["{ loop 1 }"] * level + [f"{{ loop {rounds} }}", count(0), "{ nop }", "{ nop }"]
    got = bench.verify(program(*rows, *["endloop"] * (level + 1)))
    assert got.writes["c0"] == list(range(1, rounds + 1))


def test_count__the_largest():
    image = program(".watchdog 200000", f"{{ loop {MOST} }}", count(0), *["{ nop }"] * 2, "endloop")
    core = bench.load(image)
    core.write(CSR["CONTROL"], START)
    for _ in range(20):
        core.clock(5_000)
    assert core.read(CSR["CYCLES"]) == image.cycles
    assert image.cycles > 3 * MOST
    assert core.read(register_address("c0")) == MOST


@pytest.mark.parametrize("tails", list(itertools.product(range(5), repeat=LEVELS - 1)), ids=str)
def test_ends__any_distance_from_each_other__each_body_runs_its_rounds(tails):
    # Bodies of the shortest length, so that marks of the outer loops are in the inner ones.
    rows = ["{ loop 2 }"] * LEVELS + [count(0), "{ nop }", "{ nop }", "endloop"]
    for i, tail in enumerate(tails):
        rows += [count(i + 1), *["{ nop }"] * (tail - 1)] if tail else []
        rows.append("endloop")
    got = bench.verify(program(*rows), str(tails))
    times = {f"c{i}": len(got.writes.get(f"c{i}", [])) for i in range(LEVELS)}
    want = {"c0": 8, "c1": 4 if tails[0] else 0, "c2": 2 if tails[1] else 0}
    assert times == want


def test_loops_one_after_the_other__use_one_level_again():
    rows = ["{ loop 5 }", count(0), "{ nop }", "{ nop }", "endloop"]
    rows += ["{ loop 2 }", count(1), "{ nop }", "{ nop }", "endloop"]
    got = bench.verify(program(*rows))
    assert (len(got.writes["c0"]), len(got.writes["c1"])) == (5, 2)


@pytest.mark.parametrize("taken", [0, 1])
@pytest.mark.parametrize("gap", range(9))
def test_branch__before_a_loop__what_was_fetched_on_the_way_changes_no_count(taken, gap):
    # The branch leaves loops in the fetch stages that never run, or skips bundles before one.
    rows = [
        *["{ nop }"] * gap,
        f"{{ {'bnz' if taken else 'bz'} k1, there }}",
        "{ loop 9 }",
        count(0),
        "{ nop }",
        "{ nop }",
        "endloop",
        "there: { loop 3 }",
        count(1),
        "{ nop }",
        "{ nop }",
        "endloop",
    ]
    image = program(*rows)
    got = bench.verify(image, timing=False)
    assert len(got.writes["c1"]) == 3 and len(got.writes.get("c0", [])) == (0 if taken else 9)


def test_branch_back_over_a_loop__runs_it_again():
    rows = ["again: { loop 4 }", count(0), "{ nop }", "{ nop }", "endloop"]
    rows += ["{ iadd c3, c3, k1 }", "{ isub c2, c3, k2 }", "{ bnz c2, again }"]
    got = bench.verify(program(*rows), timing=False)
    assert len(got.writes["c0"]) == 8


@pytest.mark.parametrize("cycles", range(8, 40, 3))
def test_watchdog_inside_a_loop__the_next_run_is_as_ever(cycles):
    rows = [
        "{ loop 2 }",
        "{ loop 3 }",
        count(0),
        "{ nop }",
        "{ nop }",
        "endloop",
        count(1),
        "endloop",
    ]
    image = program(*rows)
    whole = bench.run(image)
    got = bench.run(image, {"WATCHDOG": cycles})
    assert got.fault == ("WATCHDOG" if cycles < whole.cycles else "NONE")
    core = bench.load(image)
    core.write(CSR["CONTROL"], CLEAR)
    again = bench.run(image, loaded=True)
    assert (again.bundle_order, again.cycles) == (whole.bundle_order, whole.cycles)


def test_address_fault_inside_a_loop__ends_the_run_at_its_bundle():
    rows = ["{ loop 3 }", "{ ld c1, 1022[c0] }", "{ iadd c0, c0, k1 }", "{ nop }", "endloop"]
    image = program(*rows)
    got, (_, want) = bench.run(image), bench.iss_run(image)
    assert (got.fault, got.info) == (want.fault.name, want.fault_bundle) == ("ADDRESS", 1)


def test_reset_inside_a_loop__the_next_run_is_as_ever():
    image = program("{ loop 9 }", count(0), "{ nop }", "{ nop }", "endloop")
    whole = bench.run(image)
    for clocks in range(9, 30, 4):
        core = bench.load(image)
        core.write(CSR["CONTROL"], START)
        core.clock(clocks)
        core.reset()
        assert bench.run(image).bundle_order == whole.bundle_order


@pytest.mark.full
def test_halted_inside_loops__program_written__goes_on_as_if_nothing_had_been():
    # Words of program memory are written as they are, at random bundles: fetch begins again.
    print(f"SEED={SEED}")
    found = list(random_halts(HALTS, SEED, "stream"))
    assert len(found) >= HALTS
    assert [text for text in found if text] == [], f"SEED={SEED}"


def test_streams__step_on_from_round_to_round():
    head = ".stream W, pin A = " + ", ".join(str(i) for i in range(1, 13))
    rows = ["{ seek W }", "{ loop 3 }", "{ fmul a1, W+, k3 }", "{ nop }", "{ fmul a2, W+, k3 }"]
    got = bench.verify(program(*rows, "endloop", head=head + "\n.const k3 = 1.0"))
    one = [bench.texts([word])[0] for word in got.writes["a1"]]
    assert one == ["3f800000", "40400000", "40a00000"]  # 1, 3, 5


@pytest.mark.parametrize(
    "operation",
    [op("loop", imm=LEVELS << LOOP_BITS | 1), op("loop", imm=1)],
    ids=["level beyond the last", "core without loops"],
)
def test_loop_that_the_core_has_not__is_illegal(operation, configuration):
    name = "stream" if operation.imm != 1 else configuration
    image = bench.image(name, [operation, HALT], outputs=0)
    assert (bench.run(image).fault, bench.run(image).info) == ("ILLEGAL", 0)
    assert bench.iss_run(image)[1].fault.name == "ILLEGAL"


@pytest.mark.parametrize("bit", range(1, ISA.control_width))
def test_marks__of_a_core_without_loops__are_reserved(bit, configuration):
    for name in (configuration, "stream"):
        width = ISA.word_width * len(ISA.configurations[name].slots)
        first = bench.image(name, [HALT], outputs=0).bundles[0]
        word = (int(first, 16) & ~(1 << width)) | 1 << width + bit
        image = bench.image(name, [f"{word:0{len(first)}x}", HALT], outputs=0)
        known = name == "stream" and bit <= LEVELS
        assert bench.run(image).fault == bench.iss_run(image)[1].fault.name
        assert bench.run(image).fault == ("NONE" if known else "ILLEGAL")


def test_register__says_how_many_levels_the_core_has(configuration):
    field = REGMAP.registers["STREAM"].fields["loops"]
    assert field.of(bench.core(configuration).read(CSR["STREAM"])) == 0
    assert field.of(bench.core("stream").read(CSR["STREAM"])) == LEVELS


# ---------------------------------------------------------------------- the assembler

LINEAR = """\
.config stream
.param x = 0.75
.watchdog 90000
.output y, safe = 0
.output z, safe = 0
"""


def linear(rng: random.Random) -> list[str | tuple[int, list]]:
    """A random body as lines and loops: names that cross the borders, and names of one round."""
    rows: list[str | tuple[int, list]] = []
    for _ in range(rng.randrange(2, 7)):
        one, two = rng.sample(["p", "q", "r"], 2)
        t = f"t{rng.randrange(3)}"
        rows.append(f"fmul {t}, {one}, x")
        rows.append(f"fmadd {two}, {t}, {rng.choice(['x', '0.5', one])}, {two}")
        rows.append(f"fsat {two}c, {two}, -9.0, 9.0")
        rows.append(f"fadd {two}, {two}c, 0.125")
    return rows


def nested(rng: random.Random, depth: int) -> list[str | tuple[int, list]]:
    rows = linear(rng)
    if depth:
        for _ in range(rng.randrange(1, 3)):
            rows.append((rng.randrange(1, 5), nested(rng, depth - 1)))
            rows += linear(rng) if rng.random() < 0.5 else []
    return rows


def text(rows: list[str | tuple[int, list]], unrolled: bool) -> list[str]:
    """Lines of a body, its loops written as such or out."""
    lines: list[str] = []
    for row in rows:
        if isinstance(row, str):
            lines.append(row)
            continue
        rounds, body = row
        inner = text(body, unrolled)
        lines += inner * rounds if unrolled else [f"loop {rounds}", *inner, "endloop"]
    return lines


@pytest.mark.parametrize("optimise", [False, True])
def test_linear_loops__compute_what_their_rounds_written_out_do(optimise):
    print(f"SEED={SEED}")
    compared = 0
    for number in range(12):
        rng = random.Random(f"{SEED} linear {number}")
        rows = nested(rng, rng.randrange(1, LEVELS + 1))
        outputs = []
        for unrolled in (False, True):
            lines = [*(f"fmul {name}, x, {i}.5" for i, name in enumerate("pqr"))]
            lines += [*text(rows, unrolled), "fmadd u, p, q, r", "fsat y, u, -99.0, 99.0"]
            lines += ["fsat z, r, -99.0, 99.0", "halt", ""]
            if len(lines) > 400:
                break
            image = bench.assembled(LINEAR + "\n".join(lines), optimise=optimise)
            if not unrolled:
                bench.verify(image, f"SEED={SEED}, linear program {number}")
            outputs.append(Iss(image).run().outputs)
        compared += len(outputs) == 2
        assert len(outputs) < 2 or outputs[0] == outputs[1], f"SEED={SEED}, program {number}"
    assert compared > 4


def test_disassembly__assembles_to_the_same_words(tmp_path):
    rows = ["{ loop 3 }", "{ loop 4 }", count(0), "{ nop }", "{ nop }", "endloop", "endloop"]
    image = program(*rows, "{ loop 2 }", count(1), "endloop")
    source = tmp_path / "again.s"
    source.write_text(disassemble(image))
    assert assemble(source).bundles == image.bundles


def test_functions__each_with_its_own_loops():
    body = "fmul s, x, {0}\nloop {0}\nfadd s, s, x\nendloop\nmov y, s\nhalt\n"
    head = ".config stream\n.input x\n.output y, safe = 0\n.data 0.0\n"
    programs = {n: bench.assembled(head + body.format(k)) for n, k in {"f": 2, "g": 5}.items()}
    both = link("both", programs)
    model = Iss(both)
    for name, want in {"f": 4.0, "g": 10.0}.items():
        model.select(both.function(name))
        model.set_inputs({"x": 1.0})
        assert model.run().outputs == {"y": want}


def test_more_cycles_than_the_watchdog_allows__are_refused():
    with pytest.raises(AssemblyError, match="the watchdog stops it after 10000"):
        program(f"{{ loop {MOST} }}", "{ nop }", "{ nop }", "{ nop }", "endloop")


def test_cycles_of_any_count__are_announced_at_once():
    rows = [f"{{ loop {MOST} }}"] * LEVELS + ["{ fmul a1, a1, k1 }", *["endloop"] * LEVELS]
    image = program(".watchdog 4294967295", *rows[:2], rows[-LEVELS - 1], "endloop", "endloop")
    # The product of each round waits for that of the round before.
    latency = bench.machine("stream").units["fma"].ranks
    assert image.cycles is not None and abs(image.cycles - MOST**2 * (latency + 1)) < 40
