# SPDX-License-Identifier: Apache-2.0
"""Values of G-code words: numbers, parameters, expressions (NISTIR 6556, 3.3.2).

value      = number | #value | #<name> | [expression] | function[expression] | - value
expression = values joined by ** | * / MOD | + - | EQ NE GT GE LT LE | AND OR XOR, in falling
             precedence, equal ones from the left, as LinuxCNC reads them
functions  = ABS ACOS ASIN ATAN[]/[] COS EXISTS[#n] EXP FIX FUP LN ROUND SIN SQRT TAN (degrees)
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import NoReturn

from sim.motion.gcode.errors import MistakeError, Report

MAX_PARAMETER = 5999
MAX_NESTING = 50
EQUAL = 1e-4  # greatest difference of numbers that are EQ, as in rs274

Key = int | str

_UNSIGNED = re.compile(r"\d+\.?\d*|\.\d+")
_NAME = re.compile(r"<[ \t]*([A-Za-z_][\w \t.-]*)>")
_FOREIGN = re.compile(r"[ \t]*<[ \t]*_(?:ini|hal)[ \t]*\[[^>]*>", re.IGNORECASE)
LETTERS = re.compile(r"[A-Za-z]+")

_OPERATORS: tuple[dict[str, Callable[[float, float], float]], ...] = (
    {
        "AND": lambda a, b: float(a != 0 and b != 0),
        "OR": lambda a, b: float(a != 0 or b != 0),
        "XOR": lambda a, b: float((a != 0) != (b != 0)),
    },
    {
        "EQ": lambda a, b: float(abs(a - b) <= EQUAL),
        "NE": lambda a, b: float(abs(a - b) > EQUAL),
        "GT": lambda a, b: float(a > b),
        "GE": lambda a, b: float(a >= b),
        "LT": lambda a, b: float(a < b),
        "LE": lambda a, b: float(a <= b),
    },
    {"+": lambda a, b: a + b, "-": lambda a, b: a - b},
    {"*": lambda a, b: a * b, "/": lambda a, b: a / b, "MOD": lambda a, b: a % abs(b)},
    {"**": lambda a, b: a**b},
)
_OPERATOR = re.compile(r"\*\*|[*/+\-]|(?:AND|OR|XOR|EQ|NE|GT|GE|LT|LE|MOD)(?![A-Za-z])", re.I)
FUNCTIONS: dict[str, Callable[[float], float]] = {
    "ABS": abs,
    "ACOS": lambda x: math.degrees(math.acos(x)),
    "ASIN": lambda x: math.degrees(math.asin(x)),
    "COS": lambda x: math.cos(math.radians(x)),
    "EXP": math.exp,
    "FIX": lambda x: float(math.floor(x)),
    "FUP": lambda x: float(math.ceil(x)),
    "LN": math.log,
    "ROUND": lambda x: math.copysign(math.floor(abs(x) + 0.5), x),
    "SIN": lambda x: math.sin(math.radians(x)),
    "SQRT": math.sqrt,
    "TAN": lambda x: math.tan(math.radians(x)),
}


def shown(key: Key) -> str:
    """A number or name as it is written after # or O."""
    return f"<{key}>" if isinstance(key, str) else str(key)


class NoValueError(Exception):
    """A parameter cannot be read: what, expected, help."""


class ValueReader:
    """Reads values at `at` of one line. `read` gives the values of numbers and names."""

    def __init__(self, source: str, report: Report, read: Callable[[Key], float | None]) -> None:
        self.source, self.report, self.read = source, report, read
        self.at = 0
        self.depth = 0

    def _fail(
        self, what: str, expected: str, help: str, begin: int | None = None, text: str | None = None
    ) -> NoReturn:
        """Reports a mistake that begins there, in a text, by default all up to here; without a
        beginning it is the character here, at the end of the line the last one."""
        if begin is None:
            begin = min(self.at, len(self.source) - 1)
            text = self.source[begin]
        if text is None:
            text = self.source[begin : self.at]
        self.report(begin + 1, text, what, expected, help)
        raise MistakeError

    def _blank(self) -> None:
        while self.at < len(self.source) and self.source[self.at] in " \t":
            self.at += 1

    def _peek(self) -> str:
        self._blank()
        return self.source[self.at] if self.at < len(self.source) else ""

    def _value(self) -> float:
        self.depth += 1
        if self.depth > MAX_NESTING:
            self._fail(
                "the expression is nested too deeply",
                f"at most {MAX_NESTING} levels",
                "compute parts of it into parameters before",
            )
        value = self._single()
        self.depth -= 1
        return value

    def _single(self) -> float:
        char = self._peek()
        if char in ("+", "-"):
            self.at += 1
            value = self._value()
            return -value if char == "-" else value
        if char == "[":
            return self._bracket()
        if char == "#":
            return self._parameter_value()
        number = _UNSIGNED.match(self.source, self.at)
        if number:
            value = float(number.group())
            if not math.isfinite(value):
                what, expected = "the number is out of range", "a number of at most 308 digits"
                self._fail(what, expected, "check the decimal point", self.at, number.group())
            self.at = number.end()
            return value
        name = LETTERS.match(self.source, self.at)
        if name:
            return self._function(name.group())
        self._fail(
            "a value is missing", "a number, #n, [ ] or a function", "complete the expression"
        )

    def _bracket(self) -> float:
        begin = self.at
        if self._peek() != "[":
            self._fail(
                "an opening bracket is missing",
                "[ after the function",
                "write for instance SIN[30]",
            )
        self.at += 1
        value = self._expression(0)
        if self._peek() != "]":
            self._fail("the expression is not closed", "an operator or ]", "close it with ]", begin)
        self.at += 1
        return value

    def _expression(self, level: int) -> float:
        if level == len(_OPERATORS):
            return self._value()
        value = self._expression(level + 1)
        while True:
            self._blank()
            match = _OPERATOR.match(self.source, self.at)
            operator = _OPERATORS[level].get(match.group().upper()) if match else None
            if match is None or operator is None:
                return value
            begin = self.at
            self.at = match.end()
            other = self._expression(level + 1)
            value = self._computed(begin, match.group(), lambda: operator(value, other))  # noqa: B023

    def _computed(self, begin: int, text: str, function: Callable[[], float]) -> float:
        try:
            value = function()
            if isinstance(value, complex) or not math.isfinite(value):
                raise ValueError
        except (ValueError, OverflowError, ZeroDivisionError):
            self._fail(
                f"{text.upper()} has no value for these numbers",
                "a finite result",
                "check for division by 0, roots and logarithms of negative numbers",
                begin,
                text,
            )
        return float(value)

    def _function(self, name: str) -> float:
        begin = self.at
        known = name.upper()
        if known not in {*FUNCTIONS, "ATAN", "EXISTS"}:
            self._fail(
                f"unknown function {known}",
                "one of " + " ".join(sorted({*FUNCTIONS, "ATAN", "EXISTS"})),
                "operators are ** * / MOD + - EQ NE GT GE LT LE AND OR XOR",
                begin,
                name,
            )
        self.at += len(name)
        if known == "EXISTS":
            return self._exists()
        value = self._bracket()
        if known == "ATAN":
            if self._peek() != "/":
                self._fail(
                    "ATAN needs two values",
                    "ATAN[y]/[x]",
                    "write ATAN[y]/[1] for the angle of a slope",
                    begin,
                )
            self.at += 1
            other = self._bracket()
            return math.degrees(math.atan2(value, other))
        return self._computed(begin, name, lambda: FUNCTIONS[known](value))

    def _exists(self) -> float:
        if self._peek() == "[":
            self.at += 1
            if self._peek() == "#":
                self.at += 1
                key = self._key(most=math.inf)
                if self._peek() == "]":
                    self.at += 1
                    if isinstance(key, int) and key > MAX_PARAMETER:
                        return 0.0
                    try:
                        return float(self.read(key) is not None)
                    except NoValueError:
                        return 1.0
        self._fail(
            "EXISTS asks for a parameter",
            "EXISTS[#n] or EXISTS[#<name>]",
            "put a parameter into the brackets",
        )

    def _name(self) -> str | None:
        """Name in < >, without blanks and in lower case, None if there is none."""
        self._blank()
        name = _NAME.match(self.source, self.at)
        if name is None:
            return None
        self.at = name.end()
        return re.sub(r"[ \t]", "", name.group(1)).lower()

    def _key(self, most: float = MAX_PARAMETER) -> Key:
        """Parameter after a #."""
        name = self._name()
        if name is not None:
            return name
        begin = self.at
        if foreign := _FOREIGN.match(self.source, begin):
            self.at = foreign.end()
            self._fail(
                f"the parameter {foreign.group()} of a machine's configuration",
                "a parameter that the program sets",
                "there is no INI file and no HAL here; set #<name> = 5 before",
                begin,
            )
        number = self._value()
        nearest = round(number)
        if abs(number - nearest) > 1e-4 or not 1 <= nearest <= most:
            self._fail(
                "not the number of a parameter",
                f"an integer from 1 to {MAX_PARAMETER}",
                "parameters are #1, #2, ... or #<name>",
                begin,
            )
        return nearest

    def _parameter_value(self) -> float:
        begin = self.at
        self.at += 1
        key = self._key()
        try:
            value = self.read(key)
        except NoValueError as error:
            what, expected, help = error.args
            self._fail(what, expected, help, begin)
        if value is None:
            self._fail(
                f"the parameter #{shown(key)} has no value",
                "a parameter set on a line before",
                "set it, for instance #1 = 5; settings count from the next line on",
                begin,
            )
        return value
