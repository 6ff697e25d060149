# SPDX-License-Identifier: Apache-2.0
"""Words of a G-code line: letters with numbers, parameters and expressions (NISTIR 6556, 3.3).

value      = number | #value | #<name> | [expression] | function[expression] | - value
expression = values joined by ** | * / MOD | + - | EQ NE GT GE LT LE | AND OR XOR, in falling
             precedence, equal ones from the left, as LinuxCNC reads them
functions  = ABS ACOS ASIN ATAN[]/[] COS EXISTS[#n] EXP FIX FUP LN ROUND SIN SQRT TAN (degrees)

Settings `#n = value` of a line take effect behind it; all reads of the line see the old values.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

MAX_ERRORS = 20
MAX_NUMBER = 1e7  # larger magnitudes are typing mistakes on any machine
MAX_PARAMETER = 5999
MAX_NESTING = 50
EQUAL = 1e-4  # greatest difference of numbers that are EQ, as in rs274


class GcodeError(ValueError):
    """One mistake: file, line and column (from 1), offending text, what, expected, help."""

    def __init__(
        self,
        file: str,
        line: int,
        column: int,
        source: str,
        text: str,
        what: str,
        expected: str,
        help: str,
    ) -> None:
        self.file, self.line, self.column = file, line, column
        self.source, self.text = source, text
        self.what, self.expected, self.help = what, expected, help
        super().__init__(str(self))

    def __str__(self) -> str:
        got = repr(self.text) if self.text else "end of file"
        caret = " " * (self.column - 1) + "^" * max(1, len(self.text))
        return (
            f"{self.file}:{self.line}:{self.column}: error: {self.what}; got {got}; "
            f"expected {self.expected}\n"
            f"{self.line:5d} |   {self.source}\n"
            f"      |   {caret}  help: {self.help}"
        )


class GcodeErrors(ValueError):
    """Every mistake found in one file, in the order of the text, at most MAX_ERRORS."""

    def __init__(self, errors: tuple[GcodeError, ...]) -> None:
        self.errors = errors
        super().__init__(str(self))

    def __str__(self) -> str:
        text = "\n".join(str(error) for error in self.errors)
        if len(self.errors) == MAX_ERRORS:
            text += f"\nstopped after {MAX_ERRORS} errors, the rest of the file was not read"
        return text


@dataclass(frozen=True)
class Word:
    """A letter with its value; text as written, column from 1."""

    letter: str
    value: float
    text: str
    column: int

    @property
    def code(self) -> str:
        """`G1` for G01 and G1.0, `G59.1` for G59.1."""
        return f"{self.letter}{self.value:.10g}"


Key = int | str
Report = Callable[[int, str, str, str, str], None]
"""Takes column, text, what, expected, help of a mistake."""
WordReport = Callable[[Word, str, str, str], None]
"""Takes the word that is wrong, what, expected, help."""

_NUMBER_RUN = re.compile(r"[ \t]*([+\-.\d]+)")
_PLAIN_WORD = re.compile(r"([A-NP-Za-np-z@^])[ \t]*([+-]?(?:\d+\.?\d*|\.\d+))(?![.\d+\-])")
_STRAY_RUN = re.compile(r"[^ \t(;]+")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)")
_UNSIGNED = re.compile(r"\d+\.?\d*|\.\d+")
_NAME = re.compile(r"<[ \t]*([A-Za-z_][\w \t.-]*)>")
_LETTERS = re.compile(r"[A-Za-z]+")

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
_FUNCTIONS: dict[str, Callable[[float], float]] = {
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


class MistakeError(Exception):
    """Ends the reading of one word; the mistake has been reported."""


class LineReader:
    """Reads the words of one line. `parameters` maps numbers and names to values."""

    def __init__(self, source: str, report: Report, read: Callable[[Key], float | None]) -> None:
        self.source, self.report, self.read = source, report, read
        self.at = 0
        self.depth = 0

    def words(self) -> tuple[list[Word], list[tuple[Key, float, int, str]]]:
        """Words in order, and settings (parameter, value, column, text)."""
        words: list[Word] = []
        settings: list[tuple[Key, float, int, str]] = []
        source = self.source
        while self.at < len(source):
            plain = _PLAIN_WORD.match(source, self.at)
            if plain:
                letter, number = plain.groups()
                value = float(number)
                if abs(value) <= MAX_NUMBER and letter.isascii():
                    words.append(Word(letter.upper(), value, plain.group(), self.at + 1))
                    self.at = plain.end()
                    continue
            begin, char = self.at, source[self.at]
            self.depth = 0
            try:
                if char in " \t":
                    self.at += 1
                elif char == ";":
                    break
                elif char == "(":
                    self.at = self._skip_comment(begin)
                elif char in "oO":
                    self.at = len(source)
                    self._fail(
                        begin + 1,
                        source[begin:],
                        "O word behind other words",
                        "an O word first in its line",
                        "put it on a line of its own",
                    )
                elif char in "@^" or (char.isascii() and char.isalpha()):
                    self.at += 1
                    words.append(self._word(begin))
                elif char == "#":
                    settings.append(self._setting(begin))
                else:
                    self._stray(begin)
            except MistakeError:
                # What follows a broken expression cannot be told from its rest.
                broken = self.depth > 0 or char == "#"
                self.at = len(source) if broken else max(self.at, begin + 1)
        return words, settings

    def _fail(self, column: int, text: str, what: str, expected: str, help: str) -> None:
        self.report(column, text, what, expected, help)
        raise MistakeError

    def _blank(self) -> None:
        while self.at < len(self.source) and self.source[self.at] in " \t":
            self.at += 1

    def _peek(self) -> str:
        self._blank()
        return self.source[self.at] if self.at < len(self.source) else ""

    def _here(self) -> tuple[int, str]:
        """Column and character where the reader is, at the end of the line those of the last."""
        at = min(self.at, len(self.source) - 1)
        return at + 1, self.source[at]

    def _stray(self, begin: int) -> None:
        text = _STRAY_RUN.match(self.source, begin).group()
        self.at = begin + len(text)
        help = "remove it or put it into a comment ( )"
        if text[0] == "/":
            help = "block delete is outside the accepted subset; remove the / or the line"
        elif text[0] in "[]=*<>":
            help = "an expression follows a letter, such as X[1 + 2], or a setting, #1 = [1 + 2]"
        self._fail(
            begin + 1,
            text,
            "unexpected character",
            "a word such as X10.5, a comment, or the end of the line",
            help,
        )

    def _skip_comment(self, begin: int) -> int:
        end = self.source.find(")", begin)
        nested = self.source.find("(", begin + 1)
        if end < 0:
            self.report(
                begin + 1,
                self.source[begin:],
                "the comment is not closed",
                "`)` on the same line",
                "close it with ) or start it with ;",
            )
            return len(self.source)
        if begin < nested < end:
            self.report(
                nested + 1,
                "(",
                "comment inside a comment",
                "`)` before the next `(`",
                "comments do not nest; use other brackets inside",
            )
        return end + 1

    def _word(self, begin: int) -> Word:
        letter = self.source[begin]
        run = _NUMBER_RUN.match(self.source, self.at)
        end = run.end() if run else self.at
        follower = self.source[end : end + 1]
        if run and not (run.group(1) in "+-" and (follower in ("#", "[") or follower.isalpha())):
            self.at = end
            value = self._number(begin + 1, self.source[begin:end], run.group(1))
        elif self._starts_value():
            value = self._value()
        else:
            text = self.source[begin : begin + 1]
            self.at = begin + 1
            self._fail(
                begin + 1,
                text,
                "the letter has no number",
                f"a number after {letter.upper()}, such as {letter.upper()}1",
                "text that is not code belongs into a comment ( )",
            )
        text = self.source[begin : self.at].rstrip()
        self._check_range(begin + 1, text, value)
        return Word(letter.upper(), value, text, begin + 1)

    def _starts_value(self) -> bool:
        char = self._peek()
        if char in ("+", "-"):
            return True
        if char in ("#", "["):
            return True
        name = _LETTERS.match(self.source, self.at)
        return bool(name) and name.group().upper() in {*_FUNCTIONS, "ATAN", "EXISTS"}

    def _number(self, column: int, text: str, number: str) -> float:
        if not _NUMBER.fullmatch(number):
            self._fail(
                column,
                text,
                "the number is malformed",
                "an optional sign, digits and at most one decimal point",
                "write for instance -12.5",
            )
        return float(number)

    def _check_range(self, column: int, text: str, value: float) -> None:
        if not abs(value) <= MAX_NUMBER:
            self._fail(
                column,
                text,
                "the number is out of range",
                f"a magnitude of at most {MAX_NUMBER:g}",
                "check the decimal point",
            )

    # Values and expressions

    def _value(self) -> float:
        self.depth += 1
        if self.depth > MAX_NESTING:
            self._fail(
                *self._here(),
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
            self.at = number.end()
            return float(number.group())
        name = _LETTERS.match(self.source, self.at)
        if name:
            return self._function(name.group())
        self._fail(
            *self._here(),
            "a value is missing",
            "a number, #n, [ ] or a function",
            "complete the expression",
        )
        return 0.0

    def _bracket(self) -> float:
        begin = self.at
        if self._peek() != "[":
            self._fail(
                *self._here(),
                "an opening bracket is missing",
                "[ behind the function",
                "write for instance SIN[30]",
            )
        self.at += 1
        value = self._expression(0)
        if self._peek() != "]":
            self._fail(
                begin + 1,
                self.source[begin : self.at],
                "the expression is not closed",
                "an operator or ]",
                "close it with ]",
            )
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
            if operator is None:
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
                begin + 1,
                text,
                f"{text.upper()} has no value for these numbers",
                "a finite result",
                "check for division by 0, roots and logarithms of negative numbers",
            )
        return float(value)

    def _function(self, name: str) -> float:
        begin = self.at
        known = name.upper()
        if known not in {*_FUNCTIONS, "ATAN", "EXISTS"}:
            self._fail(
                begin + 1,
                name,
                f"unknown function {known}",
                "one of " + " ".join(sorted({*_FUNCTIONS, "ATAN", "EXISTS"})),
                "operators are ** * / MOD + - EQ NE GT GE LT LE AND OR XOR",
            )
        self.at += len(name)
        if known == "EXISTS":
            return self._exists()
        value = self._bracket()
        if known == "ATAN":
            if self._peek() != "/":
                self._fail(
                    begin + 1,
                    self.source[begin : self.at],
                    "ATAN needs two values",
                    "ATAN[y]/[x]",
                    "write ATAN[y]/[1] for the angle of a slope",
                )
            self.at += 1
            other = self._bracket()
            return math.degrees(math.atan2(value, other))
        return self._computed(begin, name, lambda: _FUNCTIONS[known](value))

    def _exists(self) -> float:
        if self._peek() == "[":
            self.at += 1
            if self._peek() == "#":
                self.at += 1
                key = self._key()
                if self._peek() == "]":
                    self.at += 1
                    return float(self.read(key) is not None)
        self._fail(
            *self._here(),
            "EXISTS asks for a parameter",
            "EXISTS[#n] or EXISTS[#<name>]",
            "put a parameter into the brackets",
        )
        return 0.0

    def _name(self) -> str | None:
        """Name in < >, without blanks and in lower case, None if there is none."""
        self._blank()
        name = _NAME.match(self.source, self.at)
        if name is None:
            return None
        self.at = name.end()
        return re.sub(r"[ \t]", "", name.group(1)).lower()

    def _key(self) -> Key:
        """Parameter behind a #."""
        name = self._name()
        if name is not None:
            return name
        begin = self.at
        number = self._value()
        nearest = round(number)
        if abs(number - nearest) > 1e-4 or not 1 <= nearest <= MAX_PARAMETER:
            self._fail(
                begin + 1,
                self.source[begin : self.at],
                "not the number of a parameter",
                f"an integer from 1 to {MAX_PARAMETER}",
                "parameters are #1, #2, ... or #<name>",
            )
        return nearest

    def _parameter_value(self) -> float:
        begin = self.at
        self.at += 1
        key = self._key()
        value = self.read(key)
        if value is None:
            self._fail(
                begin + 1,
                self.source[begin : self.at],
                f"the parameter #{f'<{key}>' if isinstance(key, str) else key} has no value",
                "a parameter set on a line before",
                "set it, for instance #1 = 5; settings count from the next line on",
            )
        return value

    def _setting(self, begin: int) -> tuple[Key, float, int, str]:
        self.at += 1
        key = self._key()
        if self._peek() != "=":
            self._fail(
                begin + 1,
                self.source[begin : self.at].rstrip(),
                "a parameter without a letter",
                "#n = value, or a letter before it such as X#1",
                "set it with = or use it behind a letter",
            )
        self.at += 1
        value = self._value()
        text = self.source[begin : self.at].rstrip()
        if not math.isfinite(value):
            self._check_range(begin + 1, text, math.inf)
        return key, value, begin + 1, text
