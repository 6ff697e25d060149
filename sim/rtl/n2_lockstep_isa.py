# SPDX-License-Identifier: Apache-2.0
"""The Nios II instruction set of nios_sw/isa.toml: validated records, encoder, disassembler."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from asip_asm.project import ROOT

ISA_FILE = ROOT / "nios_sw/isa.toml"
OP_R, OP_CUSTOM = 58, 50
UNITS = (
    *("alu", "shift", "mul", "div", "load", "store", "branch", "jump", "control", "cache"),
    *("custom", "illegal"),
)
# Operand kind: lowest bit of its field, bits, signed.
FIELDS = {
    "a": (27, 5, False),
    "b": (22, 5, False),
    "c": (17, 5, False),
    "i5": (6, 5, False),
    "ctl": (6, 5, False),
    "s16": (6, 16, True),
    "u16": (6, 16, False),
    "h16": (6, 16, False),
    "rel16": (6, 16, True),
    "i26": (6, 26, False),
    "n": (6, 8, False),
}
CUSTOM_REGISTERS = {"readra": 16, "readrb": 15, "writerc": 14}


class N2IsaError(ValueError):
    """isa.toml is wrong, or an operand does not fit; the message says where and what to do."""


@dataclass(frozen=True)
class Instruction:
    """One record; `operands` are keys of FIELDS in the order of assembly."""

    name: str
    op: int
    opx: int | None
    operands: tuple[str, ...]
    unit: str
    doc: str
    fixed: Mapping[str, int] = field(default_factory=dict)

    @property
    def base(self) -> int:
        """Instruction word with every operand 0 (custom: all three registers used)."""
        word = self.op | (self.opx << 11 if self.opx is not None else 0)
        for name, value in self.fixed.items():
            word |= value << FIELDS[name][0]
        if self.op == OP_CUSTOM:
            word |= sum(1 << bit for bit in CUSTOM_REGISTERS.values())
        return word

    def encode(self, *values: int, **flags: int) -> int:
        """Instruction word; values in the order of `operands`.

        custom takes readra, readrb, writerc (0 or 1, default 1). Raises N2IsaError.
        """
        if len(values) != len(self.operands):
            want = " ".join(self.operands) or "none"
            raise N2IsaError(f"{self.name}: {len(values)} operands; expected: {want}")
        word = self.base
        for name, bit in CUSTOM_REGISTERS.items():
            if not flags.get(name, 1):
                word &= ~(1 << bit)
        for kind, value in zip(self.operands, values, strict=True):
            low, width, signed = FIELDS[kind]
            least, most = (-(1 << width - 1), (1 << width - 1) - 1) if signed else (0, 2**width - 1)
            if not least <= value <= most:
                raise N2IsaError(f"{self.name}: {kind}={value}; expected: {least}..{most}")
            word |= (value & (1 << width) - 1) << low
        return word

    def decode(self, word: int) -> dict[str, int]:
        """Values of the operands in an instruction word."""
        values = {}
        for kind in self.operands:
            low, width, signed = FIELDS[kind]
            value = word >> low & (1 << width) - 1
            values[kind] = value - (1 << width) if signed and value >> width - 1 else value
        return values


@dataclass(frozen=True)
class Isa:
    """The whole file."""

    instructions: Mapping[str, Instruction]
    codes: Mapping[tuple[int, int | None], Instruction]  # by op and opx
    control: Mapping[str, int]
    cause: Mapping[str, int]
    register: Mapping[str, int]

    def find(self, word: int) -> Instruction | None:
        """Record of an instruction word; None where the opcode is reserved."""
        key = (word & 63, word >> 11 & 63 if word & 63 == OP_R else None)
        return self.codes.get(key)

    def disassemble(self, word: int) -> str:
        """Name and operands, or the word itself."""
        record = self.find(word)
        if record is None:
            return f".word 0x{word:08x}"
        values = record.decode(word)
        text = ", ".join(f"r{v}" if k in "abc" else str(v) for k, v in values.items())
        return f"{record.name} {text}".strip()


def _line_of(text: str, name: str) -> int:
    match = re.search(rf"^{re.escape(name)}\s*=", text, re.M)
    return text.count("\n", 0, match.start()) + 1 if match else 1


def load_isa(path: Path = ISA_FILE) -> Isa:
    """Read and check an instruction set; raises N2IsaError with file and line."""
    text = path.read_text(encoding="utf-8")
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise N2IsaError(f"{path}:1:1: error: not TOML: {error}") from None
    records: dict[str, Instruction] = {}
    codes: dict[tuple[int, int | None], Instruction] = {}
    for name, row in data.get("instruction", {}).items():

        def refuse(what: str, name: str = name) -> N2IsaError:
            return N2IsaError(f"{path}:{_line_of(text, name)}:1: error: {name}: {what}")

        unknown = set(row) - {"op", "opx", "asm", "unit", "fixed", "doc"}
        if unknown:
            raise refuse(f"unknown key '{min(unknown)}'; expected: op opx asm unit fixed doc")
        if ("op" in row) == ("opx" in row):
            raise refuse("needs either op or opx")
        operands = tuple(re.findall(r"\w+", row.get("asm", "")))
        wrong = [operand for operand in operands if operand not in FIELDS]
        if wrong:
            raise refuse(f"unknown operand '{wrong[0]}'; expected: {' '.join(FIELDS)}")
        if row.get("unit") not in UNITS:
            raise refuse(f"unknown unit '{row.get('unit')}'; expected: {' '.join(UNITS)}")
        op, opx = row.get("op", OP_R), row.get("opx")
        for code in (op, opx):
            if code is not None and not 0 <= code < 64:
                raise refuse(f"code {code}; expected: 0..63")
        if op == OP_R and opx is None:
            raise refuse(f"op {OP_R} is the R format; expected: opx")
        if (op, opx) in codes:
            raise refuse(f"has the code of {codes[op, opx].name}")
        codes[op, opx] = records[name] = Instruction(
            name, op, opx, operands, row["unit"], row.get("doc", ""), row.get("fixed", {})
        )
    return Isa(records, codes, data["control"], data["cause"], data["register"])


@cache
def default_isa() -> Isa:
    """Instruction set of the project."""
    return load_isa()
