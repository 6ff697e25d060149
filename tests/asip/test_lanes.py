# SPDX-License-Identifier: Apache-2.0
"""Lanes on the core against the instruction-set model: words of every lane, flags, cycles, host.

A lane's register is read by taking it (`vout`), so every test takes what it looks at.
"""

from __future__ import annotations

import msgspec
import pytest

from asip_asm.assemble import assemble
from asip_asm.c_image import to_c
from asip_asm.diagnostics import AssemblyError
from asip_asm.disassemble import disassemble
from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.image import Image, ImageError, StreamEntry
from asip_asm.isa import STREAM_BITS
from sim.rtl.asip_bus import CSR
from tests.asip import core_bench as bench
from tests.asip.core_bench import HALT, ISA, op
from tests.asip.test_core_random import check
from tests.bench.seed import SEED

PROGRAMS = 14  # random ones of each kind
LANES = 1 + ISA.configurations["wide"].lanes
ONE, TWO = 0x3F800000, 0x40000000


def program(*rows: str, head: str = "") -> Image:
    """Image of lines; the stream of each pipe has the vectors (1, 2, 3, 4) and (10, 20, 30, 40)."""
    lines = [".config wide", ".const one = 1.0, pin k1", ".const two = 2.0, pin k2"]
    for pin in "AB":
        lines.append(f".vectors W{pin}, pin {pin} = 1, 2, 3, 4, 10, 20, 30, 40")
    return bench.assembled("\n".join([*lines, head, *rows, "{ nop } halt", ""]))


def taken(pipe: str, register: int) -> list[str]:
    """Bundles that take every lane of a register: to 10, 11, ..."""
    return [f"{{ vout {pipe}{10 + n}, zero, {pipe}{register}, {n} }}" for n in range(LANES)]


def lanes(got: bench.CoreRun, pipe: str) -> list[str]:
    """What `taken` took."""
    return [bench.texts(got.writes[f"{pipe}{10 + n}"])[-1] for n in range(LANES)]


def floats(*values: float) -> list[str]:
    return [f"{bench.arithmetic.bits_of(bench.arithmetic.from_float(v)):08x}" for v in values]


@pytest.mark.parametrize("kind", ["straight", "loops"])
def test_random_programs__words_flags_and_cycles_of_the_model(kind):
    print(f"SEED={SEED}")
    assert sum(check("wide", kind, number) for number in range(PROGRAMS)) > 1_000


@pytest.mark.full
def test_random_programs__many__words_flags_and_cycles_of_the_model():
    print(f"SEED={SEED}")
    for number in range(1000, 1400):
        check("wide", ("straight", "loops")[number % 2], number)


@pytest.mark.parametrize("pipe", "ab")
@pytest.mark.parametrize("gap", range(12))
def test_vector__read_at_any_distance_from_its_write__every_lane(pipe, gap):
    # Waiting, the bypass of each stage, and the bank.
    rows = [f"{{ seek {pipe.upper()} }}", f"{{ vfmul {pipe}1, {pipe.upper()}+, k2 }}"]
    rows += ["{ nop }"] * gap + [f"{{ vfmadd {pipe}2, {pipe.upper()}+, k1, {pipe}1 }}"]
    got = bench.verify(program(*rows, *taken(pipe, 2)))
    assert lanes(got, pipe) == floats(12, 24, 36, 48)


OPERANDS = """\
.const least = -40, pin k3
.vectors N{pin}, pin {pin} = 1, -2, -40, 5, 12582912, 12582913, 12582917, 12582910
"""


@pytest.mark.parametrize("pipe", "ab")
@pytest.mark.parametrize(
    ("line", "want"),
    [
        ("vmadd {0}4, {0}1, {0}1, k1", (2, 5, 1601, 26)),
        ("vmadd {0}4, {0}1, k2, {0}1", (3, -6, -120, 15)),
        ("vmadd {0}4, k2, {0}1, zero", (2, -4, -80, 10)),
        ("vscale {0}4, {0}1, {0}2, k1", (2, -3, -1279, 2.25)),
        ("vbelow {0}4, {0}1, k2", (0, -4, -64, 0)),
        ("vbelow {0}4, {0}1, {0}1", (0, 4, 1280, 0)),
        ("vabove {0}4, {0}1, k2, {0}1", (3, -2, -40, 15)),
        # One operand of the pipe for every lane.
        ("vmadd {0}4, k3, {0}1, k1", (-39, 81, 1601, -199)),
        ("vbelow {0}4, {0}1, k3", (0, 80, 1280, 0)),
        ("vabove {0}4, {0}1, k2, k3", (-38, -40, -40, -30)),
        ("vscale {0}4, k2, {0}2, k1", (3, 5, 65, 1.5)),
    ],
)
def test_operands_of_a_vector_operation__every_lane(pipe, line, want):
    pin = pipe.upper()
    rows = [f"{{ seek N{pin} }}", f"{{ vfmul {pipe}1, {pin}+, k1 }}"]
    rows += [f"{{ vfmul {pipe}2, {pin}+, k1 }}", f"{{ {line.format(pipe)} }}"]
    got = bench.verify(program(*rows, *taken(pipe, 4), head=OPERANDS.format(pin=pin)))
    assert lanes(got, pipe) == floats(*want)


NOT_NUMBERS = (0x7FC00000, 0xFFC00001, 0x7F800001, 0xFFBFFFFF)
INFINITIES = (0x7F800000, 0xFF800000, 0x7F7FFFFF, 0xC2000001)


def limited(name: str, source: str, words: tuple[int, ...]) -> list[str]:
    """Lanes of `vbelow` or `vabove` times 1, of the words of a stream or of a vector of them."""
    texts = [f"{bits:08x}" for bits in words]
    stream = StreamEntry("s", "A", 0, texts[:1], [[word] for word in texts[1:]])
    addend = ["zero"] if name == "vabove" else []
    bundles = [(op("seek", imm=0),), (op(name, "a1", "s0", "k0", *addend),)]
    if source != "s0":
        bundles = [(op("seek", imm=0),), (op("vmadd", source, "s0", "k0", "zero"),)]
        bundles += [(op(name, "a1", source, "k0", *addend),)]
    bundles += [(op("vout", f"a{10 + n}", "zero", "a1", imm=n, pipe=0),) for n in range(LANES)]
    image = bench.image("wide", [*bundles, HALT], {"k0": ONE}, outputs=0, streams=[stream])
    return lanes(bench.verify(image), "a")


@pytest.mark.parametrize("name", ["vbelow", "vabove"])
def test_not_a_number__stays_one_in_every_lane(name):
    for source in ("s0", "a2"):
        assert limited(name, source, NOT_NUMBERS) == ["7fc00000"] * 4


@pytest.mark.parametrize(
    ("name", "want"),
    [
        ("vbelow", ("00000000", "c2000000", "00000000", "c2000000")),
        ("vabove", ("7f800000", "00000000", "7f7fffff", "00000000")),
    ],
)
def test_infinity_and_what_is_just_beyond_a_limit__every_lane(name, want):
    for source in ("s0", "a2"):
        assert limited(name, source, INFINITIES) == list(want)


# By vector: numbers on both sides of each limit, signed zeros, words that are not finite, sums of
# `vscale`.
EXTREMES = (
    (0x00000000, 0xC2200000, 0x40400000, 0x80000000),
    (0xC2000001, 0x41FFFFFF, 0xC1FFFFFF, 0xC2000000),
    (0xFFBFFFFF, 0x7F800001, 0xFF800000, 0x7F800000),
    (0x4B400001, 0x4B40007F, 0x4B3FFF82, 0x4B400000),
)
READERS = (("vbelow", "{0}1", "k0"), ("vabove", "{0}1", "k0", "k0"), ("vscale", "k0", "{0}1", "k0"))


@pytest.mark.parametrize("pipe", "ab")
@pytest.mark.parametrize("gap", range(12))
def test_limit_and_power_of_a_vector__at_any_distance_from_its_write(pipe, gap):
    number = "ab".index(pipe)
    bundles: list[bench.Item] = []
    for name, *operands in READERS:
        texts = [text.format(pipe) for text in operands]
        bundles.append((op("seek", imm=number << STREAM_BITS),))
        for _ in EXTREMES:
            bundles += [
                (op("vmadd", f"{pipe}1", f"s{number}", "k0", "zero"),),
                *[bench.EMPTY] * gap,
            ]
            bundles.append((op(name, f"{pipe}2", *texts),))
            bundles += [
                (op("vout", f"{pipe}{10 + n}", "zero", f"{pipe}2", imm=n, pipe=number),)
                for n in range(LANES)
            ]
    words = [[f"{vector[n]:08x}" for vector in EXTREMES] for n in range(LANES)]
    stream = StreamEntry("s", pipe.upper(), 0, words[0], words[1:])
    image = bench.image("wide", [*bundles, HALT], {"k0": ONE}, outputs=0, streams=[stream])
    bench.verify(image)


@pytest.mark.parametrize("pipe", "ab")
@pytest.mark.parametrize("gap", range(12))
def test_lane__taken_at_any_distance_from_its_write(pipe, gap):
    rows = [f"{{ seek {pipe.upper()} }}", f"{{ vfmul {pipe}1, {pipe.upper()}+, k2 }}"]
    rows += ["{ nop }"] * gap + [f"{{ vout {pipe}3, k1, {pipe}1, 3 }}"]
    got = bench.verify(program(*rows))
    assert bench.texts(got.writes[f"{pipe}3"]) == floats(9)


@pytest.mark.parametrize("gap", range(12))
def test_write_of_one_word__leaves_the_other_lanes_as_they_are(gap):
    rows = ["{ seek A }", "{ vfmul a1, A+, k2 }", "{ fadd a1, k1, k1 }", *["{ nop }"] * gap]
    got = bench.verify(program(*rows, "{ vfmadd a2, A+, k1, a1 }", *taken("a", 2)))
    assert lanes(got, "a") == floats(12, 24, 36, 48)
    rows[2] = "{ fsub a1, k2, k1 }"
    got = bench.verify(program(*rows, "{ vfmadd a2, A+, k1, a1 }", *taken("a", 2)))
    assert lanes(got, "a") == floats(11, 24, 36, 48)


def test_both_pipes_in_one_bundle__each_with_its_own_lanes():
    rows = ["{ seek A }", "{ seek B+1 }", "{ vfmul a1, A+, k2 | vfmul b1, B+, k1 }"]
    got = bench.verify(program(*rows, *taken("a", 1), *taken("b", 1)))
    assert (lanes(got, "a"), lanes(got, "b")) == (floats(2, 4, 6, 8), floats(10, 20, 30, 40))


def test_addend_zero__is_zero_in_every_lane():
    # Register 0 has a vector by then.
    rows = ["{ seek A }", "{ vfmul a0, A+, k2 }", *["{ nop }"] * 9, "{ vfmadd a1, A+, k1, zero }"]
    assert lanes(bench.verify(program(*rows, *taken("a", 1))), "a") == floats(10, 20, 30, 40)


def test_flags__of_one_lane_alone__are_those_of_the_run():
    head = ".vectors Z, pin A = 1, 1, 1, 3e38"
    rows = [".config wide", ".const two = 2.0, pin k2", head, "{ seek Z }"]
    for last in ("{ vfmul a1, A+, k2 }\n{ nop } halt\n", "{ vfmul a1, A+, k2 } halt\n"):
        image = bench.assembled("\n".join([*rows, last]))
        got = bench.verify(image)
        assert got.flags == bench.iss_run(image)[1].flags != 0


def test_memory__pages_of_every_lane_and_pipe():
    words = ISA.configurations["wide"].stream_words
    page = REGMAP.blocks["streams"].words
    far = (0, page - 1, page, words - 1)
    blocks = []
    for pipe, pin in enumerate("AB"):
        first, *others = (
            [f"{0x3F800000 + (lane << 20) + (pipe << 18) + i:08x}" for i in range(words)]
            for lane in range(LANES)
        )
        blocks.append(StreamEntry(f"s{pin}", pin, 0, first, others))
    bundles: list = []
    for i, address in enumerate(far):
        for pipe, bank in enumerate("ab"):
            register = f"{bank}{i}"
            bundles += [(op("seek", imm=pipe << 15 | address),)]
            bundles += [(op("vfmul", register, f"s{pipe}", "k0"),)]
            bundles += [
                (op("vout", f"{bank}{10 + LANES * i + n}", "zero", register, imm=n, pipe=pipe),)
                for n in range(LANES)
            ]
    image = bench.image("wide", [*bundles, HALT], {"k0": ONE}, outputs=0, streams=blocks)
    got = bench.verify(image)
    for i, address in enumerate(far):
        for n in range(LANES):
            want = 0x3F800000 + (n << 20) + address
            assert got.writes[f"a{10 + LANES * i + n}"] == [want]
            assert got.writes[f"b{10 + LANES * i + n}"] == [want + (1 << 18)]


@pytest.mark.parametrize(
    "operation",
    [
        op("vfmul", "a1", "k0", "k0"),
        op("vfmul", "a1", "a0", "k0"),
        op("vfmadd", "a1", "s0", "k0", "b1"),
        op("vfmadd", "a1", "s0", "k0", "k0"),
        op("vfmadd", "b1", "s1", "k0", "c1"),
        op("vout", "a1", "k0", "b1", imm=1),
        op("vout", "a1", "k0", "a1", imm=LANES),
        op("vout", "a1", "k0", "k1", imm=1),
        op("vbelow", "a1", "k0", "a1"),
        op("vbelow", "b1", "a1", "b1"),
        op("vabove", "a1", "c1", "a1", "a1"),
        op("vabove", "a1", "zero", "a1", "a1"),
        op("vscale", "a1", "a1", "k0", "a1"),
        op("vscale", "b1", "b1", "c1", "b1"),
    ],
    ids=lambda o: f"{o.mnemonic} {o.a} {o.c} {o.imm}",
)
def test_vector_of_no_stream_or_another_bank__is_illegal(operation):
    image = bench.image("wide", [operation, HALT], {"k0": ONE}, outputs=0)
    got = bench.run(image)
    assert (got.fault, got.info) == (bench.iss_run(image)[1].fault.name, 0) == ("ILLEGAL", 0)


@pytest.mark.full
@pytest.mark.parametrize("name", ["fast", "stream"])
def test_core_without_lanes__their_operations_are_illegal(name):
    for operation in (op("vfmul", "a1", "zero", "k0"), op("vout", "a1", "k0", "a1", imm=0)):
        image = bench.image(name, [operation, HALT], {"k0": ONE}, outputs=0)
        assert bench.run(image).fault == bench.iss_run(image)[1].fault.name == "ILLEGAL"


def test_register__says_how_many_lanes_the_core_has():
    field = REGMAP.registers["STREAM"].fields["lanes"]
    assert field.of(bench.core("stream").read(CSR["STREAM"])) == 0
    assert field.of(bench.core("wide").read(CSR["STREAM"])) == LANES - 1


# ---------------------------------------------------------------------- the assembler

LINEAR = """\
.config wide
.param x = 0.5
.output y, safe = 0
.vectors W, pin A = 1, 2, 3, 4, 10, 20, 30, 40
        seek W
        vfmul s, W+, x
        vfmadd s, W+, x, s
        vout p, x, s, 0
        vout q, p, s, 3
        mov y, q
        halt
"""


@pytest.mark.parametrize("optimise", [False, True])
def test_linear_vectors__are_scheduled_and_placed(optimise):
    got = bench.verify(bench.assembled(LINEAR, optimise=optimise))
    assert bench.texts([got.outputs["y"]]) == floats(0.5 + 5.5 + 22)


def test_disassembly__assembles_to_the_same_words(tmp_path):
    image = bench.assembled(LINEAR)
    source = tmp_path / "again.s"
    source.write_text(disassemble(image))
    again = assemble(source)
    assert (again.bundles, again.streams) == (image.bundles, image.streams)


def test_image__lanes_of_another_length__are_refused():
    image = bench.assembled(LINEAR)
    short = msgspec.structs.replace(image.streams[0], lanes=image.streams[0].lanes[:1])
    with pytest.raises(ImageError, match="'W' has not 4 equal lanes"):
        msgspec.structs.replace(image, streams=[short]).check()


def test_image_in_c__with_vectors__is_refused():
    with pytest.raises(AssemblyError, match="an image in C has no vectors"):
        to_c(bench.assembled(LINEAR))
