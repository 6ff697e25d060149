# SPDX-License-Identifier: Apache-2.0
"""Constant expressions, evaluated in double precision, and their binary32 and int32 bits."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Mapping

from asip_asm.diagnostics import Place, SourceError, closest, shortened
from asip_asm.lexer import Cursor, Token
from asip_asm.limits import NESTING

FUNCTIONS: Mapping[str, Callable[[float], float]] = {
    "sqrt": math.sqrt,
    "sin": math.sin,
    "cos": math.cos,
    "abs": abs,
}
INT_RANGE = (-(1 << 31), (1 << 32) - 1)


def float_bits(value: float, place: Place | None = None) -> int:
    """Bits of the value rounded once to binary32. SourceError if the result is not finite."""
    try:
        bits = int.from_bytes(struct.pack(">f", value), "big")
    except OverflowError:
        bits = 0x7F800000
    if bits & 0x7F800000 == 0x7F800000:
        raise SourceError(
            place,
            f"{value:g} is not a finite binary32 number",
            "constants are finite; the largest magnitude is 3.40282347e+38",
        )
    return bits


def float_value(bits: int) -> float:
    """Value of binary32 bits."""
    return struct.unpack(">f", bits.to_bytes(4, "big"))[0]


def int_bits(value: float, place: Place | None = None) -> int:
    """Two's complement bits of an integer value. SourceError if it has none of 32 bits."""
    if not value.is_integer():
        raise SourceError(place, f"{value:g} is not an integer")
    low, high = INT_RANGE
    if not low <= value <= high:
        raise SourceError(place, f"{int(value)} does not fit 32 bits", f"range {low}..{high}")
    return int(value) & 0xFFFFFFFF


def word_bits(value: float, type_name: str, place: Place | None = None) -> int:
    """Bits of a value of type 'float' or 'int'."""
    return int_bits(value, place) if type_name == "int" else float_bits(value, place)


def literal_name(bits: int, type_name: str) -> str:
    """Name of an unnamed constant: its shortest decimal text."""
    if type_name == "int":
        return str(bits - (1 << 32) if bits >> 31 else bits)
    value = float_value(bits)
    if not math.isfinite(value):
        return f"0f{bits:08x}"
    for digits in range(1, 10):
        text = f"{value:.{digits}g}"
        if float_bits(float(text)) == bits:
            return text if any(c in text for c in ".e") else text + ".0"
    return f"0f{bits:08x}"


def number_value(token: Token) -> float:
    """Value of a number token. SourceError if it is not finite."""
    text = token.text
    if text.startswith("0f"):
        bits = int(text[2:], 16)
        if bits & 0x7F800000 == 0x7F800000:
            raise SourceError(
                token.place,
                f"{text} is not a finite number",
                "NaN and infinity cannot be constants",
            )
        return float_value(bits)
    try:
        value = float(int(text, 16)) if text.startswith("0x") else float(text)
    except OverflowError:
        value = math.inf
    if math.isinf(value):
        raise SourceError(token.place, f"{shortened(text)} is not a finite number")
    return value


class Evaluator:
    """Recursive descent over `+ - * / ( )`, unary minus, functions, pi and names."""

    def __init__(
        self, lookup: Callable[[str], float | None], known: Callable[[], list[str]]
    ) -> None:
        """`lookup` gives the value of a name or None, `known` all names for suggestions."""
        self.lookup = lookup
        self.known = known
        self._depth = 0

    def expression(self, cursor: Cursor) -> float:
        """Value of the expression at the cursor, finite. Raises SourceError."""
        value = self._product(cursor)
        while cursor.at("+") or cursor.at("-"):
            operator = cursor.take()
            right = self._product(cursor)
            value = _finite(value + right if operator.text == "+" else value - right, operator)
        return value

    def _product(self, cursor: Cursor) -> float:
        value = self.operand(cursor)
        while cursor.at("*") or cursor.at("/"):
            operator = cursor.take()
            right = self.operand(cursor)
            if operator.text == "*":
                value *= right
            elif right == 0:
                raise SourceError(operator.place, "division by zero in an expression")
            else:
                value /= right
            _finite(value, operator)
        return value

    def operand(self, cursor: Cursor) -> float:
        """Value of a number, name, call or parenthesis with its signs. Raises SourceError."""
        sign = 1.0
        while cursor.accept("-"):
            sign = -sign
        return sign * self._primary(cursor)

    def _inner(self, cursor: Cursor, opened: Token) -> float:
        """Value of the expression after an opening parenthesis."""
        if self._depth >= NESTING:
            raise SourceError(
                opened.place,
                f"more than {NESTING} parentheses are open in this expression",
                "give a part of it a name with .const",
            )
        self._depth += 1
        try:
            return self.expression(cursor)
        finally:
            self._depth -= 1

    def _primary(self, cursor: Cursor) -> float:
        token = cursor.token
        if token.kind == "number":
            return number_value(cursor.take())
        if cursor.accept("("):
            value = self._inner(cursor, token)
            cursor.expect(")", "to close the parenthesis")
            return value
        if token.kind != "name":
            raise cursor.unexpected("a number, a name or '('")
        cursor.take()
        if cursor.at("("):
            return self._call(token, cursor)
        if token.text == "pi":
            return math.pi
        named = self.lookup(token.text)
        if named is None:
            raise SourceError(
                token.place,
                f"'{token.text}' is not the name of a constant",
                closest(token.text, [*self.known(), "pi", *FUNCTIONS])
                or "declare it above with .const or .param",
            )
        return named

    def _call(self, token: Token, cursor: Cursor) -> float:
        if token.text not in FUNCTIONS:
            raise SourceError(
                token.place,
                f"unknown function '{token.text}'",
                closest(token.text, FUNCTIONS) or "functions are " + ", ".join(FUNCTIONS),
            )
        cursor.take()
        argument = self._inner(cursor, token)
        cursor.expect(")", f"to close {token.text}(")
        if token.text == "sqrt" and argument < 0:
            raise SourceError(token.place, f"square root of the negative number {argument:g}")
        return FUNCTIONS[token.text](argument)


def _finite(value: float, operator: Token) -> float:
    if not math.isfinite(value):
        raise SourceError(
            operator.place,
            f"the result of '{operator.text}' is not finite",
            "expressions are evaluated in double precision, up to 1.8e308",
        )
    return value
