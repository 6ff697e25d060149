# SPDX-License-Identifier: Apache-2.0
"""O words of a line: label, keyword and arguments; flow.py has the grammar."""

from __future__ import annotations

import re
from dataclasses import dataclass

from sim.motion.gcode.expressions import Key
from sim.motion.gcode.words import LineReader

NUMBER = ""  # keyword of a line with a number alone, where a subprogram of M98 begins
ARGUMENTS = 30  # #1 to #30 belong to a subroutine

O_LINE = re.compile(r"[ \t]*/?[ \t]*(?:[nN][ \t\d.]*)?[oO]")
_KEYWORD = re.compile(r"[ \t]*([A-Za-z]+)")

CLOSING = {"if": "endif", "while": "endwhile", "do": "while", "repeat": "endrepeat"}
_KEYWORDS = (
    *("sub", "endsub", "call", "return", "if", "elseif", "else", "endif"),
    *("while", "do", "endwhile", "repeat", "endrepeat", "break", "continue"),
)


@dataclass(frozen=True)
class Head:
    """An O word: label, keyword, and column and text of both."""

    label: Key
    keyword: str
    column: int
    text: str


class HeadReader(LineReader):
    """Reads an O word and its arguments."""

    def head(self) -> Head:
        start = O_LINE.match(self.source)
        assert start is not None  # only such lines come here
        self.at = start.end()
        begin = self.at - 1
        label: Key | None = self._name()
        if label is None:
            label = self._number_label(begin)
        keyword = _KEYWORD.match(self.source, self.at)
        text = self.source[begin : self.at].rstrip()
        known = keyword.group(1).lower() if keyword else ""
        if keyword is None and self._peek() in ("", "(", ";") and isinstance(label, int):
            return Head(label, NUMBER, begin + 1, self._as_written(begin, text))
        if keyword is None or known not in _KEYWORDS:
            self._fail(
                "the O word has no known keyword",
                "one of " + " ".join(_KEYWORDS),
                f"write for instance {text} call, or {text} if [#1 GT 0]",
                begin,
                self.source[begin : keyword.end() if keyword else self.at].rstrip(),
            )
        self.at = keyword.end()
        return Head(label, known, begin + 1, self._as_written(begin, self.source[begin : self.at]))

    def _number_label(self, begin: int) -> int:
        if self.source[self.at : self.at + 1] not in (*"0123456789#[",):
            self._fail(
                "the O word has no label",
                "a number, #n, [ ] or <name> after O",
                "write for instance O100 call or O<pocket> call",
                begin,
                self.source[begin : self.at].rstrip(),
            )
        number = self._value()
        if number < 0 or abs(number - round(number)) > 1e-4:
            self._fail(
                f"the label is {number:g}",
                "an integer of at least 0",
                "write for instance O100 call",
                begin,
                self.source[begin : self.at].rstrip(),
            )
        return round(number)

    def arguments(self, head: Head, least: int, most: int) -> list[float]:
        """Values in brackets up to the end of the line."""
        values: list[float] = []
        while True:
            char = self._peek()
            if char == "(":
                self.at = self._skip_comment(self.at)
            elif char in ("", ";"):
                break
            elif char == "[" and len(values) < most:
                self.depth = 0
                values.append(self._bracket())
            elif char == "[" and most == ARGUMENTS:
                self._fail(
                    "too many arguments",
                    f"at most {ARGUMENTS}",
                    "set parameters from #31 on before the call",
                )
            else:
                self._fail(
                    f"unexpected text after {head.keyword}",
                    "[value] or the end of the line" if most else "the end of the line",
                    "an O word is alone in its line, values in brackets",
                )
        if len(values) < least:
            self._fail(
                f"{head.keyword} without a value",
                f"[ ] after {head.keyword}",
                f"write for instance {head.text} [#1 LT 10]",
                head.column - 1,
                head.text,
            )
        return values
