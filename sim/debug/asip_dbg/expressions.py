# SPDX-License-Identifier: Apache-2.0
"""Expressions over values of a program: arithmetic in double precision, comparisons, functions."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping
from typing import Any

CHARACTERS = 1000
"""Longest expression."""
FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "abs": abs,
    "sqrt": math.sqrt,
    "sin": math.sin,
    "cos": math.cos,
    "min": min,
    "max": max,
    "isnan": math.isnan,
    "isfinite": math.isfinite,
}
_BINARY = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_COMPARE = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
_NAME = re.compile(r"(?<![0-9A-Za-z_.])\$?[A-Za-z_][A-Za-z0-9_.]*(?:@-?[0-9]+|\[[0-9]+\])?")
_WORDS = {"and", "or", "not"}
_PARTS = (ast.BoolOp, ast.expr_context, ast.operator, ast.unaryop, ast.cmpop, ast.boolop)


class ExpressionError(ValueError):
    """The text is not an expression, or has no value; the message says why."""


class Expression:
    """An expression that has been parsed; `names` are those that its value needs."""

    def __init__(self, text: str) -> None:
        """Raises ExpressionError."""
        if len(text) > CHARACTERS:
            raise ExpressionError(
                f"the expression has {len(text)} characters, at most {CHARACTERS}"
            )
        self.text = text.strip()
        short: dict[str, str] = {}

        def stand_in(match: re.Match[str]) -> str:
            name = match.group()
            if name in _WORDS or name in FUNCTIONS:
                return name
            return short.setdefault(name, f"v{len(short)}_")

        plain = _NAME.sub(stand_in, self.text)
        self.names = tuple(short)
        self._meant = {stand: name for name, stand in short.items()}
        try:
            self._tree = ast.parse(plain, mode="eval").body
            _check(self._tree, self._meant)
        except (SyntaxError, RecursionError, MemoryError, ValueError) as error:
            if isinstance(error, ExpressionError):
                raise
            raise ExpressionError(
                f"'{self.text:.60}' is not an expression; see help print"
            ) from None

    def value(self, read: Callable[[str], float | int]) -> float | int | bool:
        """The value; `read` gives the number of a name, its errors pass. Raises ExpressionError."""
        try:
            return _Value(read, self._meant).of(self._tree)
        except ZeroDivisionError:
            raise ExpressionError(f"'{self.text:.60}' divides by zero") from None
        except (OverflowError, TypeError, RecursionError) as error:
            raise ExpressionError(f"'{self.text:.60}': {error}") from None
        except ValueError as error:
            if type(error) is not ValueError:  # `read` says why a name has no value.
                raise
            raise ExpressionError(
                f"'{self.text:.60}': a number outside of the function's range"
            ) from None


def is_name(text: str) -> bool:
    """Whether a text is one name: of a value, a definition of it (`e@2`) or a word (`table[3]`)."""
    return _NAME.fullmatch(text) is not None and text not in _WORDS and text not in FUNCTIONS


def evaluate(text: str, read: Callable[[str], float | int]) -> float | int | bool:
    """Value of an expression; `read` gives the number of a name. Raises ExpressionError."""
    return Expression(text).value(read)


def _check(tree: ast.expr, names: Mapping[str, str]) -> None:
    """Refuse what is no part of an expression. Raises ExpressionError."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant):
            right = type(node.value) in (int, float)
        elif isinstance(node, ast.Name):
            right = node.id in names or node.id in FUNCTIONS
        elif isinstance(node, ast.Call):
            right = isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS
            right = right and not node.keywords
        elif isinstance(node, ast.BinOp):
            right = type(node.op) in _BINARY
        elif isinstance(node, ast.Compare):
            right = all(type(op) in _COMPARE for op in node.ops)
        elif isinstance(node, ast.UnaryOp):
            right = isinstance(node.op, ast.Not | ast.USub | ast.UAdd)
        else:
            right = isinstance(node, _PARTS)
        if not right:
            raise ExpressionError(
                "an expression has numbers, names, + - * / ( ), comparisons, and, or, not, and "
                + ", ".join(FUNCTIONS)
            )


class _Value:
    """Value of a tree that `_check` has passed."""

    def __init__(self, read: Callable[[str], float | int], names: Mapping[str, str]) -> None:
        self.read = read
        self.names = names

    def of(self, node: ast.expr) -> Any:
        if isinstance(node, ast.Constant):
            return node.value
        if isinstance(node, ast.Name):
            if node.id not in self.names:
                raise ExpressionError(f"{node.id} is a function: {node.id}(...)")
            return self.read(self.names[node.id])
        if isinstance(node, ast.BinOp):
            return _BINARY[type(node.op)](self.of(node.left), self.of(node.right))
        if isinstance(node, ast.UnaryOp):
            value = self.of(node.operand)
            if isinstance(node.op, ast.Not):
                return not value
            return -value if isinstance(node.op, ast.USub) else value
        if isinstance(node, ast.BoolOp):
            joined = all if isinstance(node.op, ast.And) else any
            return joined(self.of(value) for value in node.values)
        if isinstance(node, ast.Compare):
            values = [self.of(item) for item in (node.left, *node.comparators)]
            tests = zip(node.ops, values, values[1:], strict=False)
            return all(_COMPARE[type(op)](left, right) for op, left, right in tests)
        assert isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        return FUNCTIONS[node.func.id](*(self.of(arg) for arg in node.args))
