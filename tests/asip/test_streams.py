# SPDX-License-Identifier: Apache-2.0
"""Streams on the core against the instruction-set model: words, places, cycles, faults, the host.

Programs without a branch also check the cycles that the machine description gives: a stream makes
no bundle wait.
"""

from __future__ import annotations

import msgspec
import pytest

from asip_asm.assemble import assemble
from asip_asm.disassemble import disassemble
from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.image import Image, ImageError, StreamEntry
from asip_asm.isa import STREAM_BITS
from asip_asm.link import link
from sim.bench.matrix_goals import PROGRAM, rows
from sim.core.iss import Iss
from sim.rtl.asip_bus import CSR
from tests.asip import core_bench as bench
from tests.asip.core_bench import HALT, ISA, op
from tests.asip.test_core_random import check
from tests.bench.seed import SEED

PROGRAMS = 16  # random ones
ONE, TWO, FOUR, EIGHT = 0x3F800000, 0x40000000, 0x40800000, 0x41000000
WORDS = (ONE, TWO, FOUR, EIGHT)
PAGE = REGMAP.blocks["streams"].words


def streams(**words: list[int]) -> list[StreamEntry]:
    """A block for each pipe named."""
    return [
        StreamEntry(f"s{pin}", pin, 0, [f"{w:08x}" for w in block]) for pin, block in words.items()
    ]


def seek(pipe: int, address: int) -> object:
    return op("seek", imm=pipe << STREAM_BITS | address)


def image(bundles: list, labels: dict[str, int] | None = None, **blocks: list[int]) -> Image:
    """Image whose multiply-adds read the blocks; k0 is 1."""
    constants = {"k0": ONE}
    return bench.image(
        "stream", bundles, constants, labels=labels or {}, outputs=0, streams=streams(**blocks)
    )


def take(register: str) -> object:
    """Writes the next word of its pipe's stream to a register."""
    return op("fmul", register, f"s{'ab'.index(register[0])}", "k0")


def test_random_programs__words_flags_outputs_and_cycles_of_the_model():
    print(f"SEED={SEED}")
    assert sum(check("stream", "straight", number) for number in range(PROGRAMS)) > 1000


def test_seek__a_word_in_its_own_bundle_is_the_one_before__the_next_bundle_has_the_new_one():
    program = image(
        [
            (seek(0, 1),),
            (take("a1"), take("b1"), seek(1, 3)),
            (take("a2"), take("b2"), seek(0, 0)),
            (take("a3"), HALT),
        ],
        A=list(WORDS),
        B=list(WORDS),
    )
    got = bench.verify(program)
    assert {name: words for name, (words,) in got.writes.items()} == {
        **{"a1": TWO, "a2": FOUR, "a3": ONE},
        **{"b1": ONE, "b2": EIGHT},
    }


def test_stall__a_bundle_that_waits__takes_one_word():
    # The second bundle waits for the first one's result with a word of its stream in hand.
    bundles = [
        take("a1"),
        op("fadd", "a2", "s0", "a1"),
        op("fadd", "a3", "s0", "a2"),
        (take("a4"), HALT),
    ]
    got = bench.verify(image(bundles, A=list(WORDS)))
    assert got.stalls["STALL_OPERAND"] > 0
    assert [got.writes[name] for name in ("a1", "a2", "a3", "a4")] == [
        [ONE],
        [0x40400000],  # 1 + 2
        [0x40E00000],  # 3 + 4
        [EIGHT],
    ]


def test_stall__before_a_branch__took_one_word_too():
    bundles = [
        take("a1"),
        op("fadd", "a2", "s0", "a1"),
        op("bnz", "k0", target="there"),
        take("a3"),
        (take("a4"), HALT),
    ]
    got = bench.verify(image(bundles, {"there": 4}, A=list(WORDS)), timing=False)
    assert got.stalls["STALL_OPERAND"] > 0 and got.writes["a4"] == [FOUR]


@pytest.mark.parametrize("taken", [0, 1])
@pytest.mark.parametrize("gap", range(8))
def test_branch__words_and_seeks_that_were_fetched_on_the_way__are_as_if_they_were_not(taken, gap):
    bundles = [(take("a1"), take("b1"), seek(0, 2)), *[op("nop")] * gap]
    bundles += [op("bnz" if taken else "bz", "k0", target="there"), (take("a2"), seek(1, 2))]
    bundles += [take("a3"), take("b3")]
    there = len(bundles)
    bundles += [(take("a4"), take("b4")), (take("a5"), HALT)]
    words = [*WORDS, ONE, TWO]
    got = bench.verify(image(bundles, {"there": there}, A=words, B=words), timing=False)
    want = {"a4": FOUR, "b4": TWO, "a5": EIGHT} if taken else {"a4": ONE, "b4": EIGHT, "a5": TWO}
    assert {name: got.writes[name][0] for name in want} == want


def test_run__begins_at_the_first_words_whatever_the_last_one_took():
    branch = op("bnz", "k0", target="there")  # words are fetched again after it
    for between in ([], [branch]):
        bundles = [take("a1"), *between, (take("a2"), HALT)]
        program = image(bundles, {"there": len(bundles) - 1}, A=list(WORDS))
        first, again = bench.run(program), bench.run(program, loaded=True)
        assert first.writes == again.writes == {"a1": [ONE], "a2": [TWO]}


def test_memory_written_between_runs__the_first_bundle_takes_the_new_word():
    program = image([take("a1"), (take("a2"), HALT)], A=list(WORDS))
    bench.run(program)
    core = bench.core("stream")
    core.write(CSR["STREAM"], 0)
    core.write(REGMAP.blocks["streams"].base, EIGHT)
    assert bench.run(program, loaded=True).writes == {"a1": [EIGHT], "a2": [TWO]}


def test_memory__every_page_of_both_streams__and_the_words_behind_the_last():
    room = ISA.configurations["stream"].stream_words
    words = [0x3F800000 + i for i in range(room)]
    far = (0, PAGE - 1, PAGE, room // 2 + 7, room - 1)
    bundles = []
    for i, address in enumerate(far):
        bundles += [(seek(0, address),), (seek(1, address),), (take(f"a{i}"), take(f"b{i}"))]
    # The first word follows the last one.
    bundles.append((take("a9"), take("b9"), HALT))
    program = image(bundles, A=words, B=[word ^ 0x40000 for word in words])
    got = bench.verify(program)
    assert [got.writes[f"a{i}"] for i in range(len(far))] == [[words[place]] for place in far]
    assert got.writes["a9"] == [words[0]] and got.writes["b9"] == [words[0] ^ 0x40000]


@pytest.mark.parametrize("page", [64, 128, 255])
def test_page_beyond_the_streams__changes_no_word(page):
    program = image([take("a1"), (take("a2"), HALT)], A=list(WORDS))
    bench.run(program)
    core = bench.core("stream")
    core.write(CSR["STREAM"], page)
    core.write(REGMAP.blocks["streams"].base, EIGHT)
    assert bench.run(program, loaded=True).writes == {"a1": [ONE], "a2": [TWO]}


def test_register__says_how_many_words_a_stream_has(configuration):
    register = REGMAP.registers["STREAM"].fields["words_log2"]
    assert register.of(bench.core(configuration).read(CSR["STREAM"])) == 0
    words = ISA.configurations["stream"].stream_words
    assert 1 << register.of(bench.core("stream").read(CSR["STREAM"])) == words


@pytest.mark.parametrize(
    "operation",
    [
        op("fmul", "a1", "s1", "k0"),
        op("fmul", "b1", "s0", "k0"),
        op("fmadd", "a1", "k0", "k0", "s1"),
        op("mov", "c1", "s0"),
        op("fsat", "c1", "k0", "k0", "s1"),
    ],
    ids=lambda operation: f"{operation.mnemonic} {operation.dst}",
)
def test_stream_of_another_slot__is_illegal(operation):
    program = image([take("a5"), operation, HALT], A=list(WORDS))
    assert (bench.run(program).fault, bench.run(program).info) == ("ILLEGAL", 1)
    _, want = bench.iss_run(program)
    assert (want.fault.name, want.fault_bundle) == ("ILLEGAL", 1)


@pytest.mark.parametrize("operation", [seek(0, 0), op("fmul", "a1", "s0", "k0")], ids=str)
def test_core_without_streams__words_of_one__are_illegal(operation, configuration):
    program = bench.image(configuration, [operation, HALT], {"k0": ONE}, outputs=0)
    assert (bench.run(program).fault, bench.run(program).info) == ("ILLEGAL", 0)
    assert bench.iss_run(program)[1].fault.name == "ILLEGAL"


def test_image__words_that_the_configuration_has_not__is_refused():
    program = image([HALT], A=list(WORDS))
    for changes, message in (
        ({"configuration": "fast"}, "the stream of pipe A has 4 words, 'fast' holds 0"),
        (
            {"streams": streams(A=[ONE] * 8193)},
            "the stream of pipe A has 8193 words, 'stream' holds",
        ),
        (
            {"streams": [StreamEntry("s", "B", 1, ["3f800000"])]},
            "stream 's' is at 1, the words before end at 0",
        ),
    ):
        with pytest.raises(ImageError, match=message):
            msgspec.structs.replace(program, **changes).check()


def test_disassembly__assembles_to_the_same_words(tmp_path):
    program = assemble(PROGRAM)
    source = tmp_path / "again.s"
    source.write_text(disassemble(program))
    again = assemble(source)
    assert (again.bundles, again.streams) == (program.bundles, program.streams)


def test_functions__each_with_its_own_words():
    text = """\
.program "{0}"
.config stream
.input x
.output y, safe = 0
.stream W, pin A = {1}, {2}
.stream V, pin B = {1}5
        seek W+1
        seek V
        fmul p, W+, x
        fmadd q, V+, x, p
        mov y, q
        halt
"""
    programs = {
        n: bench.assembled(text.format(n, *w)) for n, w in {"f": (1, 2), "g": (3, 4)}.items()
    }
    both = link("both", programs)
    assert both.stream("A") == [ONE, TWO, 0x40400000, FOUR]
    model = Iss(both)
    for name, want in {"f": 2 + 15, "g": 4 + 35}.items():
        model.select(both.function(name))
        model.set_inputs({"x": 1.0})
        assert model.run().outputs == {"y": want}


def test_matrix_product__announced_cycles_bits_of_the_model_and_error_within_its_bound():
    found = list(rows(full=False))
    assert [goal.name for goal in found if goal.met is False] == []
    assert len(found) == 12
