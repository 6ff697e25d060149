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
_NAME = re.compile(r"(?<![0-9A-Za-z_.])\$?[A-Za-z_][A-Za-z0-9_.]*(?:@-?[0-9]+)?")
_WORDS = {"and", "or", "not"}


class ExpressionError(ValueError):
    """The text is no expression, or has no value; the message says why."""


def evaluate(text: str, read: Callable[[str], float | int]) -> float | int | bool:
    """Value of an expression; `read` gives the number of a name. Raises ExpressionError."""
    if len(text) > CHARACTERS:
        raise ExpressionError(f"the expression has {len(text)} characters, at most {CHARACTERS}")
    names: dict[str, str] = {}

    def stand_in(match: re.Match[str]) -> str:
        name = match.group()
        if name in _WORDS or name in FUNCTIONS:
            return name
        return names.setdefault(name, f"v{len(names)}_")

    plain = _NAME.sub(stand_in, text)
    meant = {short: name for name, short in names.items()}
    try:
        tree = ast.parse(plain.strip(), mode="eval")
        return _Value(read, meant).of(tree.body)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        if isinstance(error, ExpressionError):
            raise
        why = "a number outside of the function's range" if _is_domain(error) else "see help print"
        raise ExpressionError(f"'{text.strip():.60}' is not an expression; {why}") from None
    except ZeroDivisionError:
        raise ExpressionError(f"'{text.strip():.60}' divides by zero") from None
    except (OverflowError, TypeError) as error:
        raise ExpressionError(f"'{text.strip():.60}': {error}") from None


def _is_domain(error: Exception) -> bool:
    return type(error) is ValueError and "domain" in str(error)


class _Value:
    def __init__(self, read: Callable[[str], float | int], names: Mapping[str, str]) -> None:
        self.read = read
        self.names = names

    def of(self, node: ast.expr) -> Any:
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            return node.value
        if isinstance(node, ast.Name) and node.id in self.names:
            return self.read(self.names[node.id])
        if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
            return _BINARY[type(node.op)](self.of(node.left), self.of(node.right))
        if isinstance(node, ast.UnaryOp):
            value = self.of(node.operand)
            if isinstance(node.op, ast.Not):
                return not value
            if isinstance(node.op, ast.USub | ast.UAdd):
                return -value if isinstance(node.op, ast.USub) else value
        if isinstance(node, ast.BoolOp):
            joined = all if isinstance(node.op, ast.And) else any
            return joined(self.of(value) for value in node.values)
        if isinstance(node, ast.Compare):
            values = [self.of(item) for item in (node.left, *node.comparators)]
            tests = zip(node.ops, values, values[1:], strict=False)
            if all(type(op) in _COMPARE for op in node.ops):
                return all(_COMPARE[type(op)](left, right) for op, left, right in tests)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
            if node.func.id in FUNCTIONS:
                return FUNCTIONS[node.func.id](*(self.of(arg) for arg in node.args))
        raise ExpressionError(
            "an expression has numbers, names, + - * / ( ), comparisons, and, or, not, and "
            + ", ".join(FUNCTIONS)
        )
