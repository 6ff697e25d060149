# SPDX-License-Identifier: Apache-2.0
"""Instruction set of the model: `isa.toml`, and decoding of bundles into operations."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

from asip_asm.gen.asip_regmap import REGMAP

_ASM = Path(__file__).resolve().parents[2] / "asip_asm"
ISA = tomllib.loads((_ASM / "isa.toml").read_text(encoding="utf-8"))
Fault = IntEnum("Fault", {fault.name: fault.code for fault in REGMAP.faults.values()})
"""Causes of a fault; NONE is 0."""

BANK_CODE = {bank["name"]: bank["code"] for bank in ISA["bank"]}
BANK_SIZE = {bank["name"]: bank["size"] for bank in ISA["bank"]}
BANK_WORDS = 64  # operand code = 64 * bank code + index
K_BASE = BANK_WORDS * BANK_CODE["K"]
OUTPUTS = ISA["limits"]["outputs"]
PROGRAM_BUNDLES = ISA["limits"]["program_bundles"]
DATA_WORDS = ISA["limits"]["data_words"]
BRANCHES = frozenset({"jmp", "bz", "bnz"})

_MNEMONIC = {int(op["encoding"], 2): name for name, op in ISA["op"].items()}
_SOURCES = ("a", "b", "c")


class IllegalOperation(ValueError):
    """A bundle holds an opcode, slot, register or reserved bit that does not exist."""


@dataclass(frozen=True)
class Decoded:
    """One operation. `sources` and `dst` are operand codes: 64 * bank + index.

    output: index of the output written instead of a register; imm: data or program address.
    """

    mnemonic: str
    sources: tuple[int, ...]
    dst: int | None
    output: int | None
    imm: int


def slots(configuration: str) -> tuple[str, ...]:
    """Kinds of the slots, 'fma', 'aux' or 'any', of configuration 'fast' or 'small'."""
    return tuple(ISA["configuration"][configuration]["slots"])


def _field(word: int, name: str) -> int:
    high, low = ISA["operation_word"][name]
    return word >> low & (1 << high - low + 1) - 1


def _check_source(code: int, configuration: str) -> int:
    bank, index = divmod(code, BANK_WORDS)
    if (
        bank > BANK_CODE["K"] + 1
        or (bank == 0 and index)
        or (bank == 2 and configuration != "fast")
    ):
        raise IllegalOperation(f"operand code {code:#x}: no such register")
    return code


def _check_unused(word: int, operands: list[str], configuration: str) -> None:
    """Source fields that the operation ignores, immediates aside, must name a register too."""
    immediate = "address" in operands or "target" in operands
    for name in _SOURCES:
        holds_immediate = immediate and (name == "c" or (name == "a" and "dst" in operands))
        if name not in operands and not holds_immediate:
            _check_source(_field(word, name), configuration)


def decode_operation(word: int, slot: int, configuration: str) -> Decoded | None:
    """Operation of one slot, None for nop. Raises IllegalOperation."""
    mnemonic = _MNEMONIC.get(_field(word, "op"))
    if mnemonic is None:
        raise IllegalOperation(f"slot {slot}: opcode {_field(word, 'op'):06b}")
    record = ISA["op"][mnemonic]
    _check_unused(word, record["operands"], configuration)
    if mnemonic == "nop":
        return None
    unit = ISA["unit"][record["unit"]]
    multiply_add = unit["bank"] == "pipe"
    kind = slots(configuration)[slot]
    if kind not in ("any", "fma" if multiply_add else "aux"):
        raise IllegalOperation(f"slot {slot}: {mnemonic} in a slot of kind {kind}")

    operands = record["operands"]
    names = [name for name in _SOURCES if name in operands]
    if "address" in operands:
        names.append("b")
    sources = tuple(_check_source(_field(word, name), configuration) for name in names)
    dst = output = None
    if "dst" in operands:
        field = _field(word, "dst")
        to_output, index = field >> 6, field & BANK_WORDS - 1
        if not to_output:
            dst = BANK_WORDS * (BANK_CODE["AB"[slot]] if multiply_add else BANK_CODE["C"]) + index
        elif multiply_add or index >= OUTPUTS:
            raise IllegalOperation(f"slot {slot}: {mnemonic} cannot write output {index}")
        else:
            output = index
    imm = 0
    if "address" in operands or "target" in operands:
        upper = _field(word, "a") & 0x7F if "dst" in operands else _field(word, "dst")
        imm = upper << 9 | _field(word, "c")
    return Decoded(mnemonic, sources, dst, output, imm)


def decode_bundle(bundle: int, configuration: str) -> tuple[list[Decoded | None], bool]:
    """Operations of the slots, and whether the run halts. Raises IllegalOperation."""
    width = ISA["operation_word"]["width"]
    count = len(slots(configuration))
    control = bundle >> width * count
    if control & ~(1 << ISA["bundle"]["halt_bit"]):
        raise IllegalOperation(f"control bits {control:#04x}: reserved bits are set")
    mask = (1 << width) - 1
    operations = [
        decode_operation(bundle >> width * slot & mask, slot, configuration)
        for slot in range(count)
    ]
    halt = bool(control >> ISA["bundle"]["halt_bit"] & 1)
    if halt and any(op is not None and op.mnemonic in BRANCHES for op in operations):
        raise IllegalOperation("halt and a branch in one bundle")
    return operations, halt


def register_code(name: str) -> int:
    """Operand code of 'a3', 'k100', 'zero', ...; KeyError for a name that is no register."""
    if name == "zero":
        return 0
    bank, digits = name[:1].upper(), name[1:]
    if not digits.isdecimal() or bank not in ("A", "B", "C", "K"):
        raise KeyError(name)
    if int(digits) >= BANK_SIZE[bank]:
        raise KeyError(name)
    return BANK_WORDS * BANK_CODE[bank] + int(digits)


def register_name(code: int) -> str:
    """Inverse of `register_code`."""
    if code >= K_BASE:
        return f"k{code - K_BASE}"
    return f"{'zabc'[code // BANK_WORDS]}{code % BANK_WORDS}" if code else "zero"
