# SPDX-License-Identifier: Apache-2.0
"""Mistakes of a text: where they are, what was found, what was expected, what helps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

MAX_ERRORS = 20
SHOWN = 120  # characters of a long line on either side of a mistake

Report = Callable[[int, str, str, str, str], None]
"""Takes column, text, what, expected, help of a mistake."""


@dataclass(eq=False, repr=False)
class GcodeError(ValueError):
    """One mistake: file, line and column (from 1), offending text, what, expected, help."""

    file: str
    line: int
    column: int
    source: str
    text: str
    what: str
    expected: str
    help: str

    def __str__(self) -> str:
        got = repr(self.text[:SHOWN]) if self.text else "end of file"
        first = max(0, self.column - 1 - SHOWN) if len(self.source) > 2 * SHOWN else 0
        shown = self.source[first : first + 2 * SHOWN]
        shown = "".join(letter if letter.isprintable() else "?" for letter in shown)
        marks = max(1, min(len(self.text), len(shown) - (self.column - 1 - first)))
        caret = " " * (self.column - 1 - first) + "^" * marks
        return (
            f"{self.file}:{self.line}:{self.column}: error: {self.what}; got {got}; "
            f"expected {self.expected}\n"
            f"{self.line:5d} |   {shown}\n"
            f"      |   {caret}  help: {self.help}"
        )


@dataclass(eq=False, repr=False)
class GcodeErrors(ValueError):
    """Every mistake found in one file, in the order of the text, at most MAX_ERRORS."""

    errors: tuple[GcodeError, ...]

    def __str__(self) -> str:
        text = "\n".join(str(error) for error in self.errors)
        if len(self.errors) == MAX_ERRORS:
            text += f"\nstopped after {MAX_ERRORS} errors, the rest of the file was not read"
        return text


class MistakeError(Exception):
    """Ends the reading of one word; the mistake has been reported."""


class TooManyErrors(Exception):
    """Ends the reading of a file, with MAX_ERRORS mistakes or one that leaves no text."""


class Mistakes:
    """The mistakes of a file so far (`found`), and the current line, at which they are reported."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.found: list[GcodeError] = []
        self.line, self.source = 0, ""

    def place(self, line: int, source: str) -> None:
        """The line under work: its number, from 1, and its text."""
        self.line, self.source = line, source

    def report(self, column: int, text: str, what: str, expected: str, help: str) -> None:
        """Takes a mistake, as Report. Raises TooManyErrors."""
        place = self.file, self.line, column, self.source
        self.found.append(GcodeError(*place, text, what, expected, help))
        if len(self.found) == MAX_ERRORS:
            raise TooManyErrors
