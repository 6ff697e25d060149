# SPDX-License-Identifier: Apache-2.0
"""Validation of instruction-set and register-map files: each contradiction is refused by name."""

from pathlib import Path

import pytest

from asip_asm.isa import ISA_FILE, IsaError, load_isa
from tests.bench.copies import changed

ISA_CASES = {
    "op fields overlap": ("dst = <[33, 27]|[34, 27]>", "operation_word.dst: bit 34 belongs to op"),
    "op bit uncovered": ("dst = <[33, 27]|[33, 28]>", "operation_word: bit 27 belongs to no"),
    "field outside word": ("op = <[39, 34]|[40, 34]>", "operation_word.op: bits 40..34 do not fit"),
    "opcode twice": ('encoding = <"010001"|"010000">', "op.fnmsub: encoding 010000 is fmadd's"),
    "opcode zero": ('encoding = <"000001"|"000000">', "op.nop: encoding 0 must stay illegal"),
    "opcode too short": ('encoding = <"000001"|"00001">', "op.nop: encoding '00001' is not 6"),
    "unknown unit": ('unit = <"sincos"|"cordic">', "op.fsin: unknown unit 'cordic'"),
    "unknown operand": ('operands = <["dst", "a"]|["dst", "d"]>', "op.fabs: unknown operand 'd'"),
    "unknown flag": ('flags = <"NV UF NX"|"NV UF XX">', "op.fsin: unknown flag 'XX'"),
    "unknown type": ('types = { a = <"int"|"half"> }', "op.i2f: unknown type of operand a 'half'"),
    "typed operand missing": ('types = { <a|c> = "int" }', "op.i2f: unknown typed operand 'c'"),
    "field used twice": (
        'operands = <["a", "target"]|["c", "target"]>',
        "op.bz: its operands use field c 2",
    ),
    "result without bank": ('bank = <"C"|"none">\ncontrol = { load', "op.ld: has a destination"),
    "unknown control field": (
        "cmp = 1, <cmp_op|cmp_up> = 2 }",
        "op.fle: unknown control field 'cmp_up'; known are cmp, cmp_op",
    ),
    "control too wide": ("cmp_op = <14|16> }", "op.isub: cmp_op = 16 does not fit 4 bits"),
    "control twice": ("cmp_op = <14|13> }", "op.isub: control is that of iadd"),
    "control missing": ("<control = { cmp = 1, cmp_op = 2 }\n|>", "op.fle: needs control"),
    "control field of two units": (
        "control = { f2i = 1, <truncate|cos> = 1 }",
        "unit.sincos: control field 'cos' is one of unit f2i too",
    ),
    "result missing": ('<result = "a & 0x7fffffff"\n|>', "op.fabs: needs result"),
    "result is no expression": ('<"a & 0x7fffffff"|"a & & a">', "op.fabs: result: 'a & & a' is"),
    "result reads another operand": (
        '<"a & 0x7fffffff"|"b & 0x7fffffff">',
        "op.fabs: result: 'b' is none of its operands, a",
    ),
    "result is a truth": ('<"a & 0x7fffffff"|"a < 0.0">', "op.fabs: result: 'a < 0.0' is no word"),
    "result calls what is not there": (
        '<"sqrt(a)"|"cbrt(a)">',
        "op.fsqrt: result: 'cbrt(a)' is no word; words are",
    ),
    "too few words": ('<"div(a, b)"|"div(a)">', "op.fdiv: result: div takes 2 words: div(a)"),
    "invalid is a word": ('invalid = <"signalling(a)"|"a">', "op.fsgn: invalid: 'a' is no truth"),
    "pipeline incomplete": ("<refetch|fetch> = 6 ", "pipeline: missing key refetch"),
    "unknown key": ("[op.nop]\n<|latency = 3\n>", "op.nop: unknown key latency"),
    "missing key": ('[op.nop]\n<encoding = "000001"\n|>', "op.nop: missing key encoding"),
    "bank codes overlap": ('name = "C"\ncode = <3|2>', "bank C: code 2 belongs to bank B"),
    "bank code that the RTL does not take": (
        'name = "zero"\ncode = <0|7>',
        "bank zero: the RTL tells A and C from zero and B by bit 0 of the code",
    ),
    "bank K elsewhere": ('name = "K"\ncode = <4|7>', "bank K: needs code 4 and 128 words"),
    "bank S elsewhere": ('name = "S"\ncode = <6|7>', "bank S: needs code 6 and 2 registers"),
    "words of a stream": (
        "stream_words = <8192|8191>",
        "configuration.stream: stream_words is 8191, must be 0 or a power of two",
    ),
    "words beyond an immediate": (
        "stream_words = <8192|65536>",
        "configuration.stream: stream_words is 65536, must be 0 or a power of two to 32768",
    ),
    "bank missing": ('name = <"C"|"A">\ncode = 3', "bank A: declared twice"),
    "unknown slot kind": (
        'slots = <["any"]|["all"]>',
        "configuration.small: unknown slot kind 'all'",
    ),
    "pipes contradict slots": ("fma_pipes = <2|3>", "configuration.fast: fma_pipes is 3"),
    "interval of no unit": (
        "intervals = { <divsqrt|divide> = 7, sincos = 37 }",
        "configuration.small: unknown unit of an interval 'divide'",
    ),
    "interval of no cycle": (
        "intervals = { divsqrt = <7|0>, sincos = 37 }",
        "configuration.small: interval 0 of unit divsqrt is not 1 or more cycles",
    ),
    "interval no number": (
        'intervals = { divsqrt = <7|"7">, sincos = 37 }',
        "configuration.small: interval '7' of unit divsqrt is not 1 or more cycles",
    ),
    "unit bank": ('bank = <"pipe"|"D">', "unit.fma: unknown bank 'D'"),
    "two latencies": ('latency = 3<|\nlatency_constant = "X">', "unit.memory: needs either"),
    "too many outputs": ("outputs = <32|65>", "limits.outputs: does not fit 6"),
    "too much data": ("data_words = <1024|65537>", "limits.data_words: does not fit 16"),
    "halt bit": ("halt_bit = <0|8>", "bundle.halt_bit: not below"),
    "unknown section": ("<|[other]\n>[limits]", "file: unknown key other"),
}


@pytest.mark.parametrize("name", ISA_CASES)
def test_isa__contradiction__is_refused_by_name(name: str, tmp_path: Path) -> None:
    change, message = ISA_CASES[name]
    with pytest.raises(IsaError) as caught:
        load_isa(changed(ISA_FILE, tmp_path, change))
    assert f"isa.toml: {message}" in str(caught.value)


def test_isa__of_the_project__has_the_published_sizes() -> None:
    isa = load_isa()
    assert (isa.bundle_width("fast"), isa.lanes("fast")) == (128, 4)
    assert (isa.bundle_width("small"), isa.lanes("small")) == (48, 2)
