# SPDX-License-Identifier: Apache-2.0
"""Words of a G-code line: letters with values (NISTIR 6556, 3.3; expressions.py), settings.

As in LinuxCNC, blanks inside numbers do not count (X1 000. is X1000), and a `/` first in the line
changes nothing: block delete is off.

Settings `#n = value` take effect after their line; all reads in the line see the old values.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from sim.motion.gcode.errors import MistakeError, Report
from sim.motion.gcode.expressions import FUNCTIONS, LETTERS, Key, ValueReader

OFFSETS = "IJK"  # letters of the centre of an arc
MAX_NUMBER = 1e7  # larger magnitudes are typing mistakes on any machine
MAX_FEED = 1e12  # of F: a number that no machine reaches says as fast as it can


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


WordReport = Callable[[Word, str, str, str], None]
"""Takes the word that is wrong, what, expected, help."""

_NUMBER_RUN = re.compile(r"[ \t]*([+\-.\d]+)")
_PLAIN_WORD = re.compile(r"([A-NP-Za-np-z@^])[ \t]*([+-]?(?:\d+\.?\d*|\.\d+))(?![.\d+\-])")
_STRAY_RUN = re.compile(r"[^ \t(;]+")
_ABORT = re.compile(r"\(abort,", re.IGNORECASE)
_SPLIT_NUMBER = re.compile(
    r"\([^()]*+\)|;.*|[+\-][ \t]++[\d.]++(?:[ \t]++[\d.]++)*+|(?<![\d.])[\d.]++(?:[ \t]++[\d.]++)++"
)
_BLOCK_DELETE = re.compile(r"[ \t]*/")
# Statements of Fanuc's macro language; no words of RS-274 begin like them.
_MACRO = re.compile(
    r"(WHILE|IF|THEN)(?=[ \t]*\[)|THEN(?=[ \t]*#)|(GOTO|DO|END)(?=[ \t]*[\d#\[])", re.IGNORECASE
)
_MACRO_HELP = {
    "WHILE": "write O100 while [#1 LT 5], and O100 endwhile after the loop",
    "DO": "write O100 while [#1 LT 5], and O100 endwhile after the loop",
    "END": "write O100 endwhile with the label of the loop",
    "IF": "write O100 if [#1 LT 5], and O100 endif after the branch",
    "THEN": "write O100 if [#1 LT 5], and O100 endif after the branch",
    "GOTO": "write branches and loops with O words; no statement jumps to a line",
}
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)")


def _joined(match: re.Match[str]) -> str:
    """A number without its blanks, as long as before; comments as they are."""
    text = match.group()
    return text if text[0] in "(;" else "".join(text.split()).ljust(len(text))


class LineReader(ValueReader):
    """Reads the words of one line."""

    def __init__(self, source: str, report: Report, read: Callable[[Key], float | None]) -> None:
        self.written, self.told = source, report
        joined = _SPLIT_NUMBER.sub(_joined, source)
        deleted = _BLOCK_DELETE.match(joined)
        at = deleted.end() if deleted else 0
        super().__init__(" " * at + joined[at:], self._tell, read)

    def _tell(self, column: int, text: str, what: str, expected: str, help: str) -> None:
        self.told(column, self._as_written(column - 1, text), what, expected, help)

    def _as_written(self, begin: int, text: str) -> str:
        """A part of the line that begins there, with the blanks inside its numbers."""
        end, wanted = begin, "".join(text.split())
        if self.written.startswith(text, begin):
            return text
        for letter in wanted:
            end = self.written.find(letter, end) + 1
        return self.written[begin:end]

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
                    text = self._as_written(self.at, plain.group())
                    words.append(Word(letter.upper(), value, text, self.at + 1))
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
                elif char in "wWiItTgGdDeE" and (macro := _MACRO.match(source, begin)):
                    self.at = len(source)
                    name = macro.group().upper()
                    self._fail(
                        f"{name}, a statement of Fanuc's macro language, is not supported",
                        "O words (docs/gcode.md)",
                        _MACRO_HELP[name],
                        begin,
                        macro.group(),
                    )
                elif char in "oO":
                    self.at = len(source)
                    self._fail(
                        "O word after other words",
                        "an O word first in its line",
                        "put it on a line of its own",
                        begin,
                        source[begin:],
                    )
                elif char in "@^" or (char.isascii() and char.isalpha()):
                    self.at += 1
                    words.append(self._word(begin))
                elif char == "#":
                    settings.append(self._setting(begin))
                else:
                    self._stray(begin)
            except MistakeError:
                # The words after a broken expression cannot be distinguished from its rest.
                broken = self.depth > 0 or char == "#"
                self.at = len(source) if broken else max(self.at, begin + 1)
        return words, settings

    def _stray(self, begin: int) -> None:
        run = _STRAY_RUN.match(self.source, begin)
        text = run.group() if run else self.source[begin]
        self.at = begin + len(text)
        help = "remove it or put it into a comment ( )"
        if text[0] == "/":
            help = "block delete is a / at the start of the line"
        elif text[0] == ",":
            help = (
                "numbers have a decimal point, X2.5; write the roundings ,R and chamfers ,C of "
                "other controls as moves"
            )
        elif text[0] == ":":
            help = "write the number of the program as O100, or remove it"
        elif self.source[:begin].isspace() and self.written[:begin].strip() == "/":
            help = "block delete is / without a number"
        elif text[0] in "[]=*<>":
            help = "an expression follows a letter, such as X[1 + 2], or a setting, #1 = [1 + 2]"
        self._fail(
            "unexpected character",
            "a word such as X10.5, a comment, or the end of the line",
            help,
            begin,
            text,
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
        if _ABORT.match(self.source, begin):
            self.report(
                begin + 1,
                self.source[begin : end + 1],
                f"the program stops: {self.source[begin + 7 : end].strip()}",
                "a program that does not reach this line",
                "(abort, text) ends a program with its text, as in LinuxCNC",
            )
        return end + 1

    def _word(self, begin: int) -> Word:
        letter = self.source[begin]
        run = _NUMBER_RUN.match(self.source, self.at)
        end = run.end() if run else self.at
        follower = self.source[end : end + 1]
        if run and not (run.group(1) in "+-" and (follower in ("#", "[") or follower.isalpha())):
            self.at = end
            value = self._number(begin, run.group(1))
        elif self._starts_value():
            value = self._value()
        else:
            self.at = begin + 1
            self._fail(
                "the letter has no number",
                f"a number after {letter.upper()}, such as {letter.upper()}1",
                "text that is not code belongs into a comment ( )",
                begin,
                letter,
            )
        text = self.source[begin : self.at].rstrip()
        self._check_range(begin, text, value, MAX_FEED if letter in "Ff" else MAX_NUMBER)
        return Word(letter.upper(), value, self._as_written(begin, text), begin + 1)

    def _starts_value(self) -> bool:
        if self._peek() in ("+", "-", "#", "["):
            return True
        name = LETTERS.match(self.source, self.at)
        return name is not None and name.group().upper() in {*FUNCTIONS, "ATAN", "EXISTS"}

    def _number(self, begin: int, number: str) -> float:
        if not _NUMBER.fullmatch(number):
            self._fail(
                "the number is malformed",
                "an optional sign, digits and at most one decimal point",
                "write for instance -12.5",
                begin,
            )
        return float(number)

    def _check_range(
        self, begin: int, text: str, value: float, largest: float = MAX_NUMBER
    ) -> None:
        if not abs(value) <= largest:
            most = f"a magnitude of at most {largest:g}"
            self._fail("the number is out of range", most, "check the decimal point", begin, text)

    def _setting(self, begin: int) -> tuple[Key, float, int, str]:
        self.at += 1
        key = self._key()
        if self._peek() != "=":
            self._fail(
                "a parameter without a letter",
                "#n = value, or a letter before it such as X#1",
                "set it with = or use it after a letter",
                begin,
                self.source[begin : self.at].rstrip(),
            )
        self.at += 1
        value = self._value()
        text = self.source[begin : self.at].rstrip()
        if not math.isfinite(value):
            self._check_range(begin, text, math.inf)
        return key, value, begin + 1, self._as_written(begin, text)
