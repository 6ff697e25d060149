# SPDX-License-Identifier: Apache-2.0
"""Words of registers in a Python file: what goes to a register and what is made of what comes from
it, for scripts/lint_registers.py, which states the rule."""

from __future__ import annotations

import ast
import functools
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path

from asip_asm.project import ROOT
from asip_asm.regmap import NUMBER
from scripts.gen_regmap import MAPS
from sim.bus.gen import esc_regmap

# Fields by the names of registers that have some; the slave controller's are records of a module.
FIELDS: dict[str, set[str]] = {}
for _, _module, _ in MAPS.values():
    _map = import_module(_module.removesuffix(".py").replace("/", ".")).REGMAP
    for _name, _record in _map.registers.items():
        if set(_record.fields) - {NUMBER}:
            FIELDS.setdefault(_name, set()).update(_record.fields)
ESC = {
    record.name: set(record.fields)
    for record in esc_regmap.REGISTERS
    if set(record.fields) - {NUMBER}
}
ESC_MODULE = esc_regmap.__name__
SHIFTS = (ast.LShift, ast.RShift)
WORDS = ("word", "words", "value", "data")  # keywords that take a register's word
# A file without any of these has no use of a register: by its name, its record or its word().
NAMED = re.compile(rf"esc_regmap|\bword\(|[\"'](?:{'|'.join(sorted(FIELDS))})[\"']")

Finding = tuple[int, str]


class Module:
    """A Python file: its tree, and what its module-level names represent."""

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

    def record(self, node: ast.expr) -> str:
        """Name of the slave controller's register that `esc_regmap.NAME` or NAME represents."""
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            module = ".".join(self.imported.get(node.value.id, ("", "")))
            return node.attr if module == ESC_MODULE and node.attr in ESC else ""
        if isinstance(node, ast.Name):
            module, name = self.imported.get(node.id, ("", ""))
            return name if module == ESC_MODULE and name in ESC else ""
        return ""


@functools.cache
def parsed(path: Path) -> Module:
    return Module(path)


@dataclass
class Scope:
    """A function's names: those of addresses and of words read, by register; values assigned."""

    module: Module
    addresses: dict[str, str] = field(default_factory=dict)
    held: dict[str, str] = field(default_factory=dict)
    values: dict[str, list[ast.expr]] = field(default_factory=dict)

    def fill(self, inside: list[ast.AST]) -> Scope:
        """Take in the assignments of the nodes."""
        pairs: list[tuple[ast.expr, ast.expr]] = []
        for node in inside:
            if isinstance(node, ast.Assign):
                pairs += [(target, node.value) for target in node.targets]
            elif isinstance(node, (ast.AnnAssign, ast.AugAssign, ast.NamedExpr)) and node.value:
                pairs.append((node.target, node.value))
        for target, value in pairs:
            if isinstance(target, ast.Name):
                self.values.setdefault(target.id, []).append(value)
                if name := self.read_of(value):
                    self.held[target.id] = name
                elif isinstance(value, (ast.Call, ast.BinOp)) and (name := self.register(value)):
                    self.addresses[target.id] = name
        return self

    def register(self, node: ast.expr) -> str:
        """Name of the register with fields that an expression names: "STATUS", CSR["STATUS"], its
        address, or a place after one."""
        if name := self.module.record(node):
            return name
        if isinstance(node, ast.Name):
            return self.addresses.get(node.id, "")
        if isinstance(node, ast.Attribute) and node.attr == "address":
            return self.module.record(node.value)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            if node.func.attr == "at":
                return self.module.record(node.func.value)
            return self.register(node.args[0]) if node.func.attr == "address" and node.args else ""
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            return self.register(node.left) or self.register(node.right)
        if isinstance(node, ast.Subscript):
            node = node.slice
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in FIELDS:
            return node.value
        return ""

    def read_of(self, node: ast.AST) -> str:
        """Register that an expression reads, with or without await."""
        if isinstance(node, ast.Await):
            node = node.value
        if not isinstance(node, ast.Call) or not node.args:
            return ""
        function = called(node)
        if function == "int":
            return self.read_of(node.args[0])
        first = node.args[0]
        if "read" in function:
            return next(filter(None, map(self.register, node.args)), "")
        return self.module.record(first) if len(node.args) == 1 else ""

    def word(self, node: ast.expr) -> str:
        """Register whose word the expression is."""
        return self.held.get(node.id, "") if isinstance(node, ast.Name) else self.read_of(node)

    def part(self, node: ast.expr) -> str:
        """Register whose word the expression is, or a masked part of it."""
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitAnd):
            return self.word(node.left) or self.word(node.right)
        return self.word(node)

    def literal(self, node: ast.expr, seen: frozenset[str] = frozenset()) -> bool:
        """Whether a register word is put together by number."""
        if isinstance(node, ast.Constant):
            if isinstance(node.value, bytes):
                return any(node.value)
            return isinstance(node.value, int) and node.value is not True and node.value != 0
        if isinstance(node, ast.Name):
            if node.id in seen:
                return False
            values: list[ast.expr | None] = [*self.values.get(node.id, ())]
            values = values or [self.module.value(node.id)]
            return any(self.literal(v, seen | {node.id}) for v in values if v is not None)
        if isinstance(node, ast.BinOp):
            return isinstance(node.op, SHIFTS) or any(
                self.literal(side, seen) for side in (node.left, node.right)
            )
        if isinstance(node, ast.IfExp):
            return self.literal(node.body, seen) or self.literal(node.orelse, seen)
        if isinstance(node, (ast.List, ast.Tuple)):
            return any(self.literal(one, seen) for one in node.elts)
        return isinstance(node, ast.UnaryOp) and self.literal(node.operand, seen)


def called(node: ast.Call) -> str:
    """Name of the function or method."""
    return getattr(node.func, "attr", "") or getattr(node.func, "id", "")


def put_together(node: ast.expr) -> bool:
    """Whether a field's value is made of shifted parts: 1 | 1 << 2, 2 << 2; 1 << 20 is a number."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr):
        return any(isinstance(n, ast.BinOp) and isinstance(n.op, SHIFTS) for n in ast.walk(node))
    if not (isinstance(node, ast.BinOp) and isinstance(node.op, ast.LShift)):
        return False
    return isinstance(node.left, ast.Constant) and node.left.value != 1


def scopes(module: Module) -> Iterator[tuple[list[ast.AST], Scope]]:
    """Every node of a function, a method or a statement outside of them, with its names."""
    for top in module.tree.body:
        for one in top.body if isinstance(top, ast.ClassDef) else [top]:
            inside = list(ast.walk(one))
            yield inside, Scope(module).fill(inside)


def writes(node: ast.AST, scope: Scope) -> Iterator[tuple[str, ast.expr]]:
    """Registers, and words that go to them."""
    pairs: list[tuple[ast.expr, ast.expr]] = []
    if isinstance(node, ast.Call) and node.args and "read" not in called(node):
        pairs = list(zip(node.args[:1], node.args[1:], strict=False))
        for place, value in zip(node.args[1:], node.args[2:], strict=False):
            if name := scope.module.record(getattr(place, "value", place)):
                yield name, value
        if name := scope.register(node.args[0]):
            fields = FIELDS.get(name) or ESC[name]
            yield from ((name, k.value) for k in node.keywords if k.arg in {*WORDS} - fields)
    elif isinstance(node, (ast.Tuple, ast.List)) and len(node.elts) == 2:
        pairs = [(node.elts[0], node.elts[1])]
    elif isinstance(node, ast.Dict):
        pairs = [(k, v) for k, v in zip(node.keys, node.values, strict=True) if k]
    for target, value in pairs:
        if name := scope.register(target):
            yield name, value


def uses_of(node: ast.AST, scope: Scope) -> Iterator[tuple[str, ast.expr, bool]]:
    """Register, place, and whether a word is put together or taken apart by number there."""
    for name, value in writes(node, scope):
        yield name, value, scope.literal(value)
    if isinstance(node, ast.Call):
        names = [n for n in map(scope.register, node.args) if n]
        for keyword in node.keywords:
            if called(node) == "word" or any(keyword.arg in FIELDS.get(n, ()) for n in names):
                yield keyword.arg or "field", keyword.value, put_together(keyword.value)
    elif isinstance(node, ast.Compare):
        sides = [node.left, *node.comparators]
        parts = [scope.part(side) for side in sides]
        for name in filter(None, parts):
            others = (s for s, of in zip(sides, parts, strict=True) if not of)
            yield name, node, any(scope.literal(side) for side in others)
    elif isinstance(node, ast.BinOp) and isinstance(node.op, (*SHIFTS, ast.BitAnd)):
        left = scope.word(node.left)
        if name := left or scope.word(node.right):
            other = node.right if left else node.left
            yield name, node, isinstance(node.op, SHIFTS) or scope.literal(other)


def python_findings(path: Path) -> tuple[int, list[Finding]]:
    """Uses of registers with fields, and the findings among them."""
    uses = 0
    found: list[Finding] = []
    if not NAMED.search(path.read_text(encoding="utf-8")):
        return uses, found
    for inside, scope in scopes(parsed(path)):
        for node in inside:
            for name, at, wrong in uses_of(node, scope):
                uses += 1
                if wrong:
                    found.append((at.lineno, f"{name} by number: {ast.unparse(at)}"))
    return uses, found
