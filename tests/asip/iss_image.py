# SPDX-License-Identifier: Apache-2.0
"""Hand-made program images for tests of the instruction-set model.

Operation words are composed here from their printed layout (docs/isa.md), not by the assembler:
|39 op 34|33 dst 27|26 a 18|17 b 9|8 c 0|, operand = bank(3) index(6), bundle = control(8) slots.
"""

from __future__ import annotations

from asip_asm.image import checksum
from asip_asm.isa import default_isa

# Published encodings, written out again; those of later operations are their records'.
OPCODES = {
    "nop": 0b000001,
    "jmp": 0b000010,
    "bz": 0b000011,
    "bnz": 0b000100,
    "st": 0b000101,
    "fmadd": 0b010000,
    "fnmsub": 0b010001,
    "fmsub": 0b010010,
    "fnmadd": 0b010011,
    "fmul": 0b010100,
    "fnmul": 0b010101,
    "fadd": 0b011000,
    "fsub": 0b011010,
    "feq": 0b100000,
    "flt": 0b100001,
    "fle": 0b100010,
    "fmin": 0b100011,
    "fmax": 0b100100,
    "fabs": 0b100101,
    "fneg": 0b100110,
    "mov": 0b100111,
    "fsgn": 0b101000,
    "fsat": 0b101001,
    "sel": 0b101010,
    "selge": 0b101011,
    "selgt": 0b101100,
    "iadd": 0b101101,
    "isub": 0b101110,
    "fdiv": 0b110000,
    "fsqrt": 0b110001,
    "fsin": 0b110010,
    "fcos": 0b110011,
    "i2f": 0b110100,
    "f2i": 0b110101,
    "f2it": 0b110110,
    "ld": 0b110111,
}
MULTIPLY_ADD = {"fmadd", "fnmsub", "fmsub", "fnmadd", "fmul", "fnmul", "fadd", "fsub"}
SECOND_IS_C = {"fadd", "fsub"}
NOP = OPCODES["nop"] << 34
TO_OUTPUT = 1 << 6


def opcode(name: str) -> int:
    """Opcode of an operation."""
    return OPCODES.get(name) or default_isa().operations[name].opcode


def source(name: str) -> int:
    """Operand code of 'a3', 'k100' or 'zero'."""
    if name == "zero":
        return 0
    bank, index = "abck".index(name[0]) + 1, int(name[1:])
    return (bank << 6) + index


def word(op: str, dst: int = 0, a: str = "zero", b: str = "zero", c: str = "zero") -> int:
    """Operation word; dst is the 7-bit field."""
    fields = dst << 27 | source(a) << 18 | source(b) << 9 | source(c)
    return opcode(op) << 34 | fields


def immediate(op: str, imm: int, dst: int = 0, a: str = "zero", b: str = "zero") -> int:
    """Operation with imm[15:0] = {x, c}: x is the a field for ld, else the dst field."""
    x, c = imm >> 9, imm & 0x1FF
    if op == "ld":
        return opcode(op) << 34 | dst << 27 | x << 18 | source(b) << 9 | c
    return opcode(op) << 34 | x << 27 | source(a) << 18 | source(b) << 9 | c


def bundle(*slots: int, halt: bool = False, control: int = 0, width: int = 3) -> str:
    """Bundle as hexadecimal text; missing slots are nops."""
    value = control | halt
    for slot in reversed((*slots, *(NOP,) * (width - len(slots)))):
        value = value << 40 | slot
    return f"{value:0{(8 + 40 * width) // 4}x}"


def image(bundles: list[str], **changes: object) -> dict:
    """Image with inputs k0..k2 named p, q, r (float), n (int, k3) and an output F, safe 7.0."""
    result = {
        "format": "microtick-asip-image",
        "version": 2,
        "title": "test",
        "configuration": "fast",
        "entry": 0,
        "bundles": bundles,
        "sources": [[] for _ in bundles],
        "constants": [],
        "inputs": [
            {"name": "p", "index": 0, "type": "float"},
            {"name": "q", "index": 1, "type": "float"},
            {"name": "r", "index": 2, "type": "float"},
            {"name": "n", "index": 3, "type": "int"},
        ],
        "outputs": [{"name": "F", "index": 0, "safe": "40e00000"}],
        "states": [],
        "exports": [],
        "data": [],
        "data_names": {},
        "labels": {},
        "watchdog": 100,
        "output_mask": 0,
        "cycles": None,
    }
    result |= changes
    return result | {"checksum": checksum(result)}
