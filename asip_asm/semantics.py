# SPDX-License-Identifier: Apache-2.0
"""What an operation computes, as isa.toml states it: expressions over 32-bit words.

The language is that of Python's expressions: `x if truth else y`, `and or not`, comparisons of
binary32 numbers (`< <= > >= == !=`, quiet; false with a NaN, but `!=`), `nan(x)`, `signalling(x)`,
`negative(x)` (sign bit), `& | ^` and `+ -` of 32-bit patterns modulo 2^32, `-x` (sign bit
inverted), `power(x)` (2^n, n the integer in the lowest 8 bits of x), integers (bits), decimal
numbers (binary32), NAN (canonical), and IEEE 754 operations that round to nearest even and raise
their flags: fma, mul, add, div, sqrt, sin, cos, from_int, to_int, to_int_truncated. A `Backend`
says what each of them is in a model, in C++ or in a proof.
"""

from __future__ import annotations

import ast
import struct
from collections.abc import Sequence
from typing import Any, Protocol

CANONICAL_NAN = 0x7FC00000
OPERANDS = ("a", "b", "c")
TESTS = ("nan", "signalling", "negative")
ROUNDED = {
    **{"fma": 3, "mul": 2, "add": 2, "div": 2, "sqrt": 1, "sin": 1, "cos": 1},
    **{"from_int": 1, "to_int": 1, "to_int_truncated": 1},
}
"""Rounded operations and their numbers of operands."""

_COMPARES: dict[type, str] = {ast.Lt: "<", ast.LtE: "<=", ast.Eq: "=="}
_SWAPPED: dict[type, str] = {ast.Gt: "<", ast.GtE: "<="}
_BITS: dict[type, str] = {
    **{ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^"},
    **{ast.Add: "+", ast.Sub: "-"},
}


class SemanticsError(ValueError):
    """An expression is not of the language; the text says what and what would be."""


class Backend(Protocol):
    """Meaning of the language: words and truths are whatever the backend takes them for."""

    def operand(self, name: str) -> Any:
        """Word of operand a, b or c."""

    def constant(self, bits: int) -> Any:
        """Word of 32 bits."""

    def choose(self, truth: Any, first: Any, second: Any) -> Any:
        """Word: first if the truth holds, else second."""

    def both(self, *truths: Any) -> Any: ...

    def either(self, *truths: Any) -> Any: ...

    def negation(self, truth: Any) -> Any: ...

    def compare(self, operator: str, left: Any, right: Any) -> Any:
        """Truth of '<', '<=' or '==' between binary32 numbers; false with a NaN, no flags."""

    def test(self, name: str, word: Any) -> Any:
        """Truth of a member of `TESTS`."""

    def bits(self, operator: str, left: Any, right: Any) -> Any:
        """Word: '&', '|', '^' of the bits, '+', '-' modulo 2^32."""

    def power(self, word: Any) -> Any:
        """Word: 2^n of the int8 in the lowest bits; its exponent field is n + 127 modulo 256."""

    def rounded(self, name: str, words: Sequence[Any]) -> Any:
        """Word: an operation of `ROUNDED`."""


def render(expression: str, backend: Backend, truth: bool = False) -> Any:
    """The expression, a word or with `truth` a truth, in the backend. Raises SemanticsError."""
    try:
        tree = ast.parse(expression, mode="eval").body
    except (SyntaxError, ValueError):
        raise SemanticsError(f"'{expression}' is not an expression") from None
    return _Walk(backend).truth(tree) if truth else _Walk(backend).word(tree)


def check(expression: str, operands: Sequence[str], truth: bool = False) -> None:
    """Raises SemanticsError if the expression is wrong or reads another operand than these."""
    render(expression, _Checker(operands), truth)


class _Walk:
    def __init__(self, backend: Backend) -> None:
        self.backend = backend

    def word(self, node: ast.expr) -> Any:
        backend = self.backend
        match node:
            case ast.IfExp():
                choices = self.word(node.body), self.word(node.orelse)
                return backend.choose(self.truth(node.test), *choices)
            case ast.Name(id="NAN"):
                return backend.constant(CANONICAL_NAN)
            case ast.Name(id=name) if name in OPERANDS:
                return backend.operand(name)
            case ast.Constant() | ast.UnaryOp(op=ast.USub(), operand=ast.Constant()):
                return backend.constant(_bits(node))
            case ast.UnaryOp(op=ast.USub()):
                return backend.bits("^", self.word(node.operand), backend.constant(1 << 31))
            case ast.BinOp() if type(node.op) in _BITS:
                words = self.word(node.left), self.word(node.right)
                return backend.bits(_BITS[type(node.op)], *words)
            case ast.Call(func=ast.Name(id="power"), args=[argument], keywords=[]):
                return backend.power(self.word(argument))
            case ast.Call(func=ast.Name(id=name), keywords=[]) if name in ROUNDED:
                if len(node.args) != ROUNDED[name]:
                    raise SemanticsError(f"{name} takes {ROUNDED[name]} words: {_text(node)}")
                return backend.rounded(name, [self.word(argument) for argument in node.args])
        raise SemanticsError(
            f"'{_text(node)}' is no word; words are a, b, c, NAN, numbers, `x if truth else y`, "
            f"& | ^ + -, {', '.join(ROUNDED)}"
        )

    def truth(self, node: ast.expr) -> Any:
        backend = self.backend
        match node:
            case ast.BoolOp():
                join = backend.both if isinstance(node.op, ast.And) else backend.either
                return join(*(self.truth(value) for value in node.values))
            case ast.UnaryOp(op=ast.Not()):
                return backend.negation(self.truth(node.operand))
            case ast.Compare(ops=[operator], comparators=[right]):
                words = self.word(node.left), self.word(right)
                if type(operator) in _COMPARES:
                    return backend.compare(_COMPARES[type(operator)], *words)
                if type(operator) in _SWAPPED:
                    return backend.compare(_SWAPPED[type(operator)], *reversed(words))
                if isinstance(operator, ast.NotEq):
                    return backend.negation(backend.compare("==", *words))
            case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in TESTS:
                return backend.test(name, self.word(argument))
        raise SemanticsError(
            f"'{_text(node)}' is no truth; truths are comparisons, and or not, {', '.join(TESTS)}"
        )


class _Checker:
    """Backend without values."""

    def __init__(self, operands: Sequence[str]) -> None:
        self.operands = operands

    def operand(self, name: str) -> None:
        if name not in self.operands:
            raise SemanticsError(f"'{name}' is none of its operands, {', '.join(self.operands)}")

    def __getattr__(self, name: str) -> Any:
        return lambda *_: None


def _bits(node: ast.expr) -> int:
    value = ast.literal_eval(node)
    if isinstance(value, float):
        return int.from_bytes(struct.pack(">f", value), "big")
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 1 << 32:
        return value
    raise SemanticsError(f"'{_text(node)}' is no 32-bit pattern and no decimal number")


def _text(node: ast.expr) -> str:
    return ast.unparse(node)
