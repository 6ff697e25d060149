# SPDX-License-Identifier: Apache-2.0
"""Instruction set of the model: `isa.toml`, and decoding of bundles into operations."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from enum import IntEnum

from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.isa import IMMEDIATE_WIDTH, LOOP_BITS, default_isa
from asip_asm.isa_records import SOURCE_FIELDS

ISA = default_isa()


class Fault(IntEnum):
    """Causes of a fault that the model has; the others are of a core's surroundings."""

    NONE = REGMAP.faults["NONE"].code
    ILLEGAL = REGMAP.faults["ILLEGAL"].code
    ADDRESS = REGMAP.faults["ADDRESS"].code
    WATCHDOG = REGMAP.faults["WATCHDOG"].code
    NOT_FINITE = REGMAP.faults["NOT_FINITE"].code
    OUTPUT_MISSING = REGMAP.faults["OUTPUT_MISSING"].code


BANK_CODE = {name: bank.code for name, bank in ISA.banks.items()}
BANK_SIZE = {name: bank.size for name, bank in ISA.banks.items()}
BANK_WORDS = 1 << ISA.index_bits  # operand code = BANK_WORDS * bank code + index
K_BASE = BANK_WORDS * BANK_CODE["K"]
S_BASE = BANK_WORDS * BANK_CODE["S"]  # operand codes of the next word of each stream
PICK = frozenset(op.name for op in ISA.of_unit("lanes") if "lane" in op.operands)
VECTOR = frozenset(op.name for op in ISA.of_unit("lanes")) - PICK
EVERY = frozenset(op.name for op in ISA.of_unit("lanes") if op.every)
OUTPUTS = ISA.outputs
PROGRAM_BUNDLES = ISA.program_bundles
DATA_WORDS = ISA.data_words


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


def _field(word: int, name: str) -> int:
    field = ISA.fields[name]
    return (word & field.mask) >> field.low


def _check_source(code: int, slot: int, configuration: str) -> int:
    bank, index = divmod(code, BANK_WORDS)
    if bank == BANK_CODE["S"] and ISA.configurations[configuration].streams(slot) and index == slot:
        return code
    if (
        bank > BANK_CODE["K"] + 1
        or (bank == BANK_CODE["zero"] and index)
        or (bank == BANK_CODE["B"] and ISA.configurations[configuration].fma_pipes < 2)
    ):
        raise IllegalOperation(f"operand code {code:#x}: no such register")
    return code


@functools.lru_cache(maxsize=1 << 16)
def decode_operation(word: int, slot: int, configuration: str) -> Decoded | None:
    """Operation of one slot, None for nop. Raises IllegalOperation."""
    opcode = _field(word, "op")
    record = ISA.by_opcode.get(opcode)
    if record is None:
        raise IllegalOperation(f"slot {slot}: opcode {opcode:06b}")
    mnemonic, unit = record.name, ISA.units[record.unit]
    immediate = (record.immediate_high, "c") if record.immediate_high else ()
    build = ISA.configurations[configuration]
    if unit.name == "lanes" and not build.lanes:
        raise IllegalOperation(f"slot {slot}: {mnemonic} without lanes")
    for name in SOURCE_FIELDS:  # also those that the operation ignores
        if name == "b" and "lane" in record.operands:
            if _field(word, name) > build.lanes:
                raise IllegalOperation(f"slot {slot}: lane {_field(word, name)}")
        elif name not in immediate:
            _check_source(_field(word, name), slot, configuration)
    if mnemonic == "nop":
        return None
    if mnemonic == "seek" and not build.stream_words:
        raise IllegalOperation(f"slot {slot}: seek without streams")
    if mnemonic == "loop" and not build.loops:
        raise IllegalOperation(f"slot {slot}: loop without loops")
    if not build.allows(slot, unit):
        raise IllegalOperation(f"slot {slot}: {mnemonic} in a slot of kind {build.slots[slot]}")
    dst = output = None
    if record.writes:
        to_output, index = divmod(_field(word, "dst"), BANK_WORDS)
        if not to_output:
            dst = BANK_WORDS * BANK_CODE[build.result_bank(slot, unit)] + index
        elif unit.bank == "pipe" or index >= OUTPUTS:
            raise IllegalOperation(f"slot {slot}: {mnemonic} cannot write output {index}")
        else:
            output = index
    imm = 0
    if immediate:
        low = ISA.fields["c"].width
        imm = (_field(word, immediate[0]) << low | _field(word, "c")) & (1 << IMMEDIATE_WIDTH) - 1
    if mnemonic == "loop" and imm >> LOOP_BITS >= build.loops:
        raise IllegalOperation(f"slot {slot}: level {imm >> LOOP_BITS} of loops")
    sources = tuple(_field(word, name) for name in record.sources)
    if unit.name == "lanes":
        own = BANK_CODE[build.result_bank(slot, unit)]
        foreign = _field(word, "c") // BANK_WORDS not in (own, BANK_CODE["zero"])
        if foreign and not record.every:
            raise IllegalOperation(f"slot {slot}: {mnemonic} of a register of another bank")
        if "lane" in record.operands:
            imm = _field(word, "b")
        elif sources[0] != S_BASE + slot and not record.every:
            raise IllegalOperation(f"slot {slot}: {mnemonic} of no word of the stream")
        if record.vector is not None:
            vectors = (own, BANK_CODE["S"]) if record.vector == "a" else (own,)
            if _field(word, record.vector) // BANK_WORDS not in vectors:
                raise IllegalOperation(f"slot {slot}: operand {record.vector} is no vector")
    return Decoded(mnemonic, sources, dst, output, imm)


def decode_bundle(bundle: int, configuration: str) -> tuple[list[Decoded | None], bool, int]:
    """Operations of the slots, whether the run halts, levels of loops marked, as bits. Raises
    IllegalOperation.
    """
    width = ISA.word_width
    count = len(ISA.configurations[configuration].slots)
    control = bundle >> width * count
    marks = (1 << ISA.configurations[configuration].loops) - 1
    if control & ~(1 << ISA.halt_bit | marks << ISA.loop_bit):
        raise IllegalOperation(f"control bits {control:#04x}: reserved bits are set")
    mask = (1 << width) - 1
    operations = [
        decode_operation(bundle >> width * slot & mask, slot, configuration)
        for slot in range(count)
    ]
    halt = bool(control >> ISA.halt_bit & 1)
    if halt and any(op is not None and op.mnemonic in ISA.branches for op in operations):
        raise IllegalOperation("halt and a branch in one bundle")
    return operations, halt, control >> ISA.loop_bit & marks


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
