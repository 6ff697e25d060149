# SPDX-License-Identifier: Apache-2.0
"""Refuse literal bit positions and addresses of registers outside generated files.

Rule. A register with named fields is put together and taken apart by the fields' generated names:
  Python  the word that goes to such a register, or is compared with what comes from it, holds no
          integer but 0 and no shift, and a word read from it is neither shifted nor masked with an
          integer. Names are followed to their assignment, in an imported module too.
  RTL     a file that names a register map package selects no bits of a bus word or address by
          number, and does not fill a register's word up with counted zeros.
  C, C++  a register access has no integer but 0 and no shift or mask by an integer in its line.
Registers whose one field is called `value` are numbers: the rule leaves them alone in Python and C.
Prints what was looked at; exit 1 with file and line of every finding.
"""

from __future__ import annotations

import ast
import functools
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from asip_asm.gen import asip_regmap  # noqa: E402
from scripts.regmap_source import NUMBER  # noqa: E402
from sim.debug.gen import debug_regmap  # noqa: E402
from sim.harness.gen import (  # noqa: E402
    biss_regmap,
    drive_regmap,
    dual_regmap,
    motion_regmap,
    n2_debug_regmap,
    n2_io_regmap,
)

MAPS = (
    asip_regmap.REGMAP,
    motion_regmap.REGMAP,
    dual_regmap.REGMAP,
    debug_regmap.REGMAP,
    drive_regmap.REGMAP,
    biss_regmap.REGMAP,
    n2_debug_regmap.REGMAP,
    n2_io_regmap.REGMAP,
)
FIELDED = frozenset(
    name
    for regmap in MAPS
    for name, register in regmap.registers.items()
    if set(register.fields or ()) - {NUMBER}
)
SHIFTS = (ast.LShift, ast.RShift)
ACCESS = re.compile(r"\b(?:io_read|io_write|read32|write32)\s*\(.*\b(?:REG_|csr\.|CSR\()(\w+)")
C_WORD = re.compile(r"\bstatus\s*(?:<<|>>|&)\s*\d")
C_LITERAL = re.compile(r"<<|>>|[|&,]\s*\(?~?(?:0[xX][0-9a-fA-F]+|[1-9]\d*)[uU]?\b")
# Words and addresses of the bus, and words that registers show.
SV_WORD = (
    r"\b(?:writedata_i|wdata_i|data_i|address_i|readdata_\w+|rdata_\w+|read_data|status_o|feed_o"
    r"|\w+_word)"
)
SV_LITERAL = re.compile(
    rf"{SV_WORD}\s*(?:\[\s*\d+\s*(?:\]|:\s*\d|\+:)|<?=\s*\{{\d+'d0,|<?=\s*\d+'[bhd]\w*[1-9a-f])"
)
HOSTS = re.compile(r"_regmap_pkg::")

Finding = tuple[int, str]


class Module:
    """A Python file: its tree, and what its module-level names stand for."""

    def __init__(self, path: Path) -> None:
        self.tree = ast.parse(path.read_text(encoding="utf-8"))
        self.values: dict[str, ast.expr] = {}
        self.imported: dict[str, tuple[str, str]] = {}
        for node in self.tree.body:
            if isinstance(node, ast.ImportFrom) and node.module:
                for alias in node.names:
                    self.imported[alias.asname or alias.name] = (node.module, alias.name)
            elif isinstance(node, ast.Assign):
                for target in node.targets:
                    self._assign(target, node.value)

    def _assign(self, target: ast.expr, value: ast.expr) -> None:
        if isinstance(target, ast.Name):
            self.values[target.id] = value
        elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            for one, its in zip(target.elts, value.elts, strict=False):
                self._assign(one, its)

    def value(self, name: str) -> ast.expr | None:
        """Expression of a module-level name, its own or an imported one."""
        if name in self.imported:
            module, other = self.imported[name]
            path = ROOT / (module.replace(".", "/") + ".py")
            return parsed(path).value(other) if path.exists() else None
        return self.values.get(name)


@functools.cache
def parsed(path: Path) -> Module:
    return Module(path)


def register(node: ast.expr) -> str:
    """Name of the register with fields that the expression names: "STATUS", CSR["STATUS"]."""
    if isinstance(node, ast.Subscript):
        node = node.slice
    return node.value if isinstance(node, ast.Constant) and node.value in FIELDED else ""


def read_of(node: ast.AST) -> str:
    """Register that an expression reads, with or without await."""
    if isinstance(node, ast.Await):
        node = node.value
    if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "read" and node.args:
        return register(node.args[0])
    return ""


def word(node: ast.expr, held: dict[str, str]) -> str:
    """Register whose word the expression is; `held` by name."""
    return held.get(node.id, "") if isinstance(node, ast.Name) else read_of(node)


def literal(node: ast.expr, module: Module) -> bool:
    """Whether a register word is put together by number."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int) and not isinstance(node.value, bool) and node.value != 0
    if isinstance(node, ast.Name):
        value = module.value(node.id)
        return value is not None and literal(value, module)
    if isinstance(node, ast.BinOp):
        return isinstance(node.op, SHIFTS) or any(
            literal(side, module) for side in (node.left, node.right)
        )
    if isinstance(node, ast.IfExp):
        return literal(node.body, module) or literal(node.orelse, module)
    return isinstance(node, ast.UnaryOp) and literal(node.operand, module)


def nodes(tree: ast.Module) -> Iterator[tuple[ast.AST, dict[str, str]]]:
    """Every node, with the names that hold a word read from a register in its function."""
    for top in tree.body:
        for scope in top.body if isinstance(top, ast.ClassDef) else [top]:
            inside = list(ast.walk(scope))
            held = {
                target.id: read_of(node.value)
                for node in inside
                if isinstance(node, ast.Assign) and read_of(node.value)
                for target in node.targets
                if isinstance(target, ast.Name)
            }
            yield from ((node, held) for node in inside)


def python_findings(path: Path) -> tuple[int, list[Finding]]:
    """Uses of registers with fields, and the findings among them."""
    module = parsed(path)
    uses, found = 0, []

    def look(name: str, at: ast.expr, wrong: bool) -> None:
        nonlocal uses
        uses += 1
        if wrong:
            found.append((at.lineno, f"{name} by number: {ast.unparse(at)}"))

    for node, held in nodes(module.tree):
        pairs: list[tuple[ast.expr, ast.expr]] = []
        if isinstance(node, ast.Call) and len(node.args) > 1:
            pairs = [(node.args[0], node.args[1])]
        elif isinstance(node, (ast.Tuple, ast.List)) and len(node.elts) == 2:
            pairs = [(node.elts[0], node.elts[1])]
        elif isinstance(node, ast.Dict):
            pairs = [(k, v) for k, v in zip(node.keys, node.values, strict=True) if k]
        elif isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            for name in filter(None, (word(side, held) for side in sides)):
                look(name, node, any(literal(side, module) for side in sides))
        elif isinstance(node, ast.BinOp) and isinstance(node.op, (*SHIFTS, ast.BitAnd)):
            left = word(node.left, held)
            name = left or word(node.right, held)
            if name:
                other = node.right if left else node.left
                look(name, node, isinstance(node.op, SHIFTS) or literal(other, module))
        for target, value in pairs:
            if register(target):
                look(register(target), value, literal(value, module))
    return uses, found


def text_findings(path: Path) -> tuple[int, list[Finding]]:
    """Lines of RTL, C or C++ with register accesses, and the findings among them."""
    text = path.read_text(encoding="utf-8")
    sv = path.suffix == ".sv"
    if sv and not HOSTS.search(text):
        return 0, []
    uses, found = 0, []
    for number, line in enumerate(text.splitlines(), 1):
        code = re.sub(r"//.*|/\*.*?\*/|\"[^\"]*\"", "", line)
        uses += len((HOSTS if sv else ACCESS).findall(code))
        if sv:
            wrong = SV_LITERAL.search(code)
        else:
            named = FIELDED & set(ACCESS.findall(code))
            wrong = C_WORD.search(code) or (named and C_LITERAL.search(code))
        if wrong:
            found.append((number, f"by number: {line.strip()}"))
    return uses, found


def files() -> Iterator[Path]:
    """What people write: not what is generated or built."""
    for folder in ("asip_asm", "sim", "scripts", "tests", "rtl", "nios_sw"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".py", ".sv", ".c", ".h", ".cpp") and "gen" not in path.parts:
                yield path


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
