# SPDX-License-Identifier: Apache-2.0
"""Operation words against bit strings written by hand, and decoding of every word."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from asip_asm.disassemble import DecodeError, decode_bundle, decode_operation, operation_text
from asip_asm.encode import EncodeError, encode_bundle, encode_operation
from asip_asm.ir import ZERO, Bundle, Operation, Output, Register, Virtual
from asip_asm.isa import default_isa

ISA = default_isa()
LABELS = {"there": 0x2A5}


def reg(name: str) -> Register:
    return Register(name[0].upper(), int(name[1:]))


# op | dst | a | b | c as drawn in isa.toml.
HAND = [
    (
        Operation("fmadd", reg("a3"), reg("a1"), reg("k2"), reg("b7")),
        "010000 0000011 001000001 100000010 010000111",
    ),
    (
        Operation("fadd", reg("b63"), reg("k127"), c=reg("c9")),
        "011000 0111111 101111111 000000000 011001001",
    ),
    (
        Operation("fsat", Output(31), reg("c1"), reg("k64")),
        "101001 1011111 011000001 101000000 000000000",
    ),
    (
        Operation("fsqrt", reg("c5"), reg("a2")),
        "110001 0000101 001000010 000000000 000000000",
    ),
    # imm = 1023 = 0000001 111111111: high part in a[6:0] of a load, in dst of a store or branch
    (
        Operation("ld", reg("c2"), imm=1023, b=reg("c4")),
        "110111 0000010 000000001 011000100 111111111",
    ),
    (
        Operation("st", a=reg("b1"), imm=1023),
        "000101 0000001 010000001 000000000 111111111",
    ),
    (
        Operation("st", a=reg("b1"), imm=65535, b=reg("c0")),
        "000101 1111111 010000001 011000000 111111111",
    ),
    # 0x2a5 = 0000001 010100101
    (Operation("jmp", target="there"), "000010 0000001 000000000 000000000 010100101"),
    (
        Operation("bnz", a=reg("k3"), target="there"),
        "000100 0000001 100000011 000000000 010100101",
    ),
    # the second stream: bit 15 of the immediate
    (Operation("seek", imm=1 << 15 | 5), "000110 1000000 000000000 000000000 000000101"),
    (Operation("loop", imm=2 << 14 | 9), "000111 1000000 000000000 000000000 000001001"),
    (
        Operation("fmadd", reg("b1"), reg("s1"), reg("k2"), reg("b1")),
        "010000 0000001 110000001 100000010 010000001",
    ),
    (
        Operation("vout", reg("a1"), reg("k2"), c=reg("a3"), imm=3),
        "011001 0000001 100000010 000000011 001000011",
    ),
    (Operation("nop"), "000001 0000000 000000000 000000000 000000000"),
]


@pytest.mark.parametrize(("operation", "bits"), HAND, ids=[op.mnemonic for op, _ in HAND])
def test_operation__matches_the_word_written_by_hand(operation: Operation, bits: str) -> None:
    word = encode_operation(operation, ISA, LABELS)
    assert f"{word:040b}" == bits.replace(" ", "")


def test_bundle__fast__is_control_then_slot_two_to_zero() -> None:
    nop = 0b000001 << 34
    add = Operation("fadd", reg("a0"), reg("k0"), c=reg("k1"))
    mov = Operation("mov", reg("c0"), reg("a0"))
    word = encode_bundle(Bundle([add, None, mov], True), ISA, {})
    assert word & (1 << 40) - 1 == encode_operation(add, ISA, {})
    assert word >> 40 & (1 << 40) - 1 == nop
    assert word >> 80 & (1 << 40) - 1 == encode_operation(mov, ISA, {})
    assert word >> 120 == 1


def test_operation__symbolic_register__is_refused() -> None:
    with pytest.raises(EncodeError, match="operand a is no physical register"):
        encode_operation(Operation("mov", reg("c0"), Virtual("x", 1)), ISA, {})
    with pytest.raises(EncodeError, match="destination is no physical register"):
        encode_operation(Operation("mov", Virtual("x", 1), reg("c0")), ISA, {})
    with pytest.raises(EncodeError, match="there is no register a64"):
        encode_operation(Operation("mov", reg("c0"), reg("a64")), ISA, {})


@settings(max_examples=500, derandomize=True)
@given(st.integers(0, (1 << 40) - 1), st.integers(0, 2))
def test_word__decodes_to_an_operation_of_the_same_word_or_is_refused(word: int, slot: int) -> None:
    try:
        operation = decode_operation(word, slot, "wide", ISA)
    except DecodeError:
        return
    operation.target = "there"
    assert encode_operation(operation, ISA, {"there": operation.imm or 0}) == word


@pytest.mark.parametrize("record", ISA.operations.values(), ids=lambda record: record.name)
def test_every_operation__legal_fields__decode_and_encode_to_the_same_word(record) -> None:
    """Random fields, made legal: at least one word of every record takes the round trip."""
    slot = 0 if ISA.units[record.unit].bank == "pipe" else 2
    operation = Operation(record.name)
    for i, name in enumerate(record.sources):
        setattr(operation, name, Register("ABCK"[i], 10 + i))
    if record.unit == "lanes":
        operation.a, operation.c, operation.imm = Register("S", 0), Register("A", 12), 2
        if "lane" in record.operands:
            operation.a = Register("B", 10)
        if "c" not in record.operands:
            operation.c = ZERO
        if record.vector == "b":
            operation.b = Register("A", 11)
    if record.writes:
        operation.dst = Register("A" if slot == 0 else "C", 33)
    if record.immediate_high:
        operation.imm, operation.target = 777, "there"
    word = encode_operation(operation, ISA, {"there": 777})
    decoded = decode_operation(word, slot, "wide", ISA)
    assert operation_text(decoded, ISA, {777: "there"}) == operation_text(
        operation, ISA, {777: "there"}
    )
    for bit in range(40):
        flipped = word ^ 1 << bit
        try:
            other = decode_operation(flipped, slot, "wide", ISA)
        except DecodeError:
            continue
        other.target = "there"
        assert encode_operation(other, ISA, {"there": other.imm or 0}) == flipped


@pytest.mark.parametrize(
    ("word", "slot", "configuration", "message"),
    [
        (0, 0, "fast", "opcode 0x00 does not exist"),
        (0b100111 << 34, 0, "fast", "mov cannot be in slot 0 of 'fast'"),
        (0b010100 << 34, 2, "fast", "fmul cannot be in slot 2 of 'fast'"),
        (0b100111 << 34 | 0b111000000 << 18, 2, "fast", "source field 0x1c0 names no register"),
        (0b100111 << 34 | 0b110000000 << 18, 2, "stream", "slot 2 of 'stream' has no stream 0"),
        (0b010100 << 34 | 0b110000001 << 18, 0, "stream", "slot 0 of 'stream' has no stream 1"),
        (0b010100 << 34 | 0b110000000 << 18, 0, "fast", "slot 0 of 'fast' has no stream 0"),
        (0b000110 << 34, 2, "fast", "configuration 'fast' has no streams"),
        (0b100111 << 34 | 0b000000001 << 18, 2, "fast", "source field 0x001 names no register"),
        (0b010100 << 34 | 1 << 33, 0, "fast", "fmul cannot write output 0"),
        (0b100111 << 34 | 0b1100000 << 27, 2, "fast", "mov cannot write output 32"),
        (0b100111 << 34 | 5, 2, "fast", "mov has bits set in its unused field c"),
        (0b110111 << 34 | 1 << 26, 2, "fast", "ld has reserved bits set"),
        (0b100111 << 34 | 0b010000000 << 18, 0, "small", "configuration 'small' has no bank B"),
        (0b011101 << 34 | 0b100000000 << 18, 0, "wide", "operand a of vbelow is no vector"),
        (0b011110 << 34 | 0b010000000 << 18, 0, "wide", "operand a of vabove is no vector"),
        (0b011100 << 34 | 0b011000000 << 9, 1, "wide", "operand b of vscale is no vector"),
    ],
)
def test_illegal_word__is_refused_with_the_reason(
    word: int, slot: int, configuration: str, message: str
) -> None:
    with pytest.raises(DecodeError) as caught:
        decode_operation(word, slot, configuration, ISA)
    assert str(caught.value) == message


def test_bundle__reserved_control_bit__is_refused() -> None:
    nop = encode_bundle(Bundle([None]), ISA, {})
    with pytest.raises(DecodeError, match="control bits 0x02 are reserved"):
        decode_bundle(nop | 2 << 40, "small", ISA)
