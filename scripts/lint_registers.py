# SPDX-License-Identifier: Apache-2.0
"""Refuse literal bit positions of registers outside generated files.

Rule. A register with named fields is put together and taken apart by the fields' generated names:
  Python  the word that goes to such a register, or is compared with what comes from it, holds no
          integer but 0 and no shift, and a word read from it is neither shifted nor masked with an
          integer. Names are followed to their assignments: in the function, in the module, in an
          imported one. A field's value is not put together of shifted parts.
  RTL     no bits are selected by number of a word or address of the bus, or of a signal that takes
          a whole word; a file that names a register map package does not fill a register's word
          up with counted zeros.
  C, C++  a line that accesses such a register, and an expression of a variable that holds its
          word, has no integer but 0 and no shift or mask by an integer.
Registers whose one field is called `value` are numbers: the rule leaves them alone in Python and C.

What it does not see. An access by the number of an address; a word that comes by an argument, a
container or a returned value; arithmetic other than shifts and masks. In C a constant of another
line, and a word that another function has read. In RTL a bus with names of its own, a word that an
expression or a port of a submodule hands on, and literals next to a generated name: bytes of a word
(`8*i+:8`, `LSB%8`) and widths.
Prints what was looked at; exit 1 with file and line of every finding.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

from asip_asm.command import command
from asip_asm.project import ROOT
from scripts.register_words import ESC, FIELDS, Finding, python_findings

# The register that a line of C accesses.
NAME = r"(?:\b(?:REG_|csr\.|CSR\()(\w+)|\b(ESC_\w+))"
ACCESS = re.compile(rf"\b\w*(?:read|write)\w*\s*\(.*?{NAME}|\bmemory\[{NAME}")
INTEGER = r"\(?~?(?:0[xX]0*[1-9a-fA-F][0-9a-fA-F]*|[1-9]\d*)[uU]?\b(?!\s*<<\s*\(?\w*_LSB)"
SHIFTED = r"(?:<<|>>)(?!\s*\(?(?:\w*_LSB|\w*_bp|\w+\.\w*low)\b)"
C_LITERAL = re.compile(rf"{SHIFTED}|(?:[|&,]|[^=!<>]=)\s*{INTEGER}")
# Of a block of bytes; its last argument is how many.
BLOCK = re.compile(r"(\b(?:esc|double)_(?:read|write)\(.*),\s*\d+\)")
# A variable that takes what a register gives, as a value or by a pointer.
TAKES = (
    re.compile(rf"\b(\w+)\s*=[^=;]*\bread\w*\s*\([^;]*?(?:{NAME}|\w+\.status\b)"),
    re.compile(rf"\b(\w+)\s*=[^=;]*\b\w+_read\w*\s*\([^;]*?{NAME}"),
    re.compile(r"\bread\w*\s*\(\s*\w+\.\w*status\s*,\s*&(\w+)"),
)
# Words and addresses of the bus, and words that registers show.
SV_BUS = r"\b(?:writedata_i|wdata_i|address_i|readdata_\w+|rdata_\w+|register_i\.data|live_data_o)"
SV_WORD = rf"(?:{SV_BUS}|\b(?:data_i|read_data|status_o|feed_o|\w+_word))"
SV_PLACE = r"\s*(?:\[\s*\d+\s*(?:\]|:\s*\d|\+:)|\[\s*(?!8\*)\d+\s*\*(?![^\]]*(?:_pkg::|LSB)))"
SV_FILLED = r"(?:\[[^\]]*\])?\s*<?=\s*\{\d+'[bd]0+,|\s*<?=\s*\d+'[bhd]\w*[1-9a-f]"
SV_LITERAL = re.compile(rf"{SV_WORD}(?:{SV_PLACE}|{SV_FILLED})")
SV_BUS_LITERAL = re.compile(SV_BUS + SV_PLACE)  # in a file that names no package
SV_TAKES = re.compile(r"\b(\w+)\s*<?=\s*(?:register_i\.data|writedata_i|wdata_i)\s*;")
HOSTS = re.compile(r"_regmap_pkg::")


def fields_of(name: str) -> bool:
    """Whether a name of C is that of a register with fields."""
    return name in FIELDS or name.removeprefix("ESC_") in ESC


def stripped(line: str) -> str:
    """A line without comments and texts."""
    return re.sub(r"//.*|/\*.*?\*/|\"[^\"]*\"", "", line)


def sv_findings(lines: list[str]) -> Iterator[tuple[int, bool]]:
    """Uses of register maps a line, and whether it has a literal position."""
    literal = SV_LITERAL if any(map(HOSTS.search, lines)) else SV_BUS_LITERAL
    held = {name for line in lines for name in SV_TAKES.findall(stripped(line))}
    of_held = re.compile(rf"\b(?:{'|'.join(sorted(held))})\[\s*\d") if held else None
    for line in lines:
        code = stripped(line)
        wrong = literal.search(code) or (of_held and of_held.search(code))
        yield len(HOSTS.findall(code)), bool(wrong)


def c_findings(lines: list[str]) -> Iterator[tuple[int, bool]]:
    """Accesses a line, and whether it has a literal position."""
    held = {"status"}
    for line in lines:
        code = BLOCK.sub(r"\1)", stripped(line))
        for takes in TAKES:
            for match in takes.finditer(code):
                names = [name for name in match.groups()[1:] if name]
                if not names or any(fields_of(name) for name in names):
                    held.add(match[1])
        held |= {a for a, b in re.findall(r"\b(\w+)\s*=\s*(\w+)\s*;", code) if b in held}
        named = [name for found in ACCESS.findall(code) for name in found if name]
        word = rf"\b(?:{'|'.join(sorted(held))})\b[^;(){{}}?:&|]*(?:<<|>>|&|\|)[^;(){{}}?:|]*?"
        wrong = re.search(rf"{word}(?<![\w.]){INTEGER}", code) or (
            any(map(fields_of, named)) and C_LITERAL.search(code)
        )
        yield len(named), bool(wrong)


def text_findings(path: Path) -> tuple[int, list[Finding]]:
    """Lines of RTL, C or C++ with register accesses, and the findings among them."""
    lines = path.read_text(encoding="utf-8").splitlines()
    look = sv_findings if path.suffix == ".sv" else c_findings
    uses, found = 0, []
    for number, (count, wrong) in enumerate(look(lines), 1):
        uses += count
        if wrong:
            found.append((number, f"by number: {lines[number - 1].strip()}"))
    return uses, found


def files() -> Iterator[Path]:
    """What people write: not what is generated or built."""
    for folder in ("asip_asm", "sim", "scripts", "tests", "rtl", "nios_sw"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".py", ".sv", ".c", ".h", ".cpp") and "gen" not in path.parts:
                yield path


@command("scripts/lint_registers.py")
def main() -> int:
    """Look at the whole tree; returns the exit status."""
    uses, wrong = 0, 0
    for path in files():
        count, found = (python_findings if path.suffix == ".py" else text_findings)(path)
        uses += count
        wrong += len(found)
        for line, text in found:
            print(f"{path.relative_to(ROOT)}:{line}: error: {text}; use the generated field names")
    print(f"lint_registers: {uses} uses of registers, {wrong} literal bit positions")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
