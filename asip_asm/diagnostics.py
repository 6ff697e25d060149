# SPDX-License-Identifier: Apache-2.0
"""Errors of a source text: where, what, what would be right; collected and reported together."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NoReturn

from asip_asm.limits import ERRORS, ERRORS_SHOWN

SHOWN_CHARACTERS = 160
"""Characters of a source line, and of a name, that a message shows."""
_OBEYED = dict.fromkeys(
    {*range(32), *range(127, 160), *range(0x202A, 0x202F), *range(0x2066, 0x206A)} - {ord("\n")},
    "\N{REPLACEMENT CHARACTER}",
)
LINES_NAMED = 8
"""Further lines of one cause that a message names."""


@dataclass(frozen=True)
class Line:
    """One line of source text as the assembler sees it: macro parameters are already replaced.

    `expansions` names the macro calls that it comes from, innermost first, as 'macro at file:line'.
    """

    file: str
    number: int
    text: str
    expansions: tuple[str, ...] = ()


@dataclass(frozen=True)
class Place:
    """Characters of a line: 0-based column and length."""

    line: Line
    column: int = 0
    length: int = 1


@dataclass(frozen=True)
class Diagnostic:
    """One error, or the warning of a `code`: `message` says what is wrong, `help` what would be
    right.
    """

    place: Place | None
    message: str
    help: str = ""
    code: str = ""

    def __str__(self) -> str:
        headline = f"warning: {self.message} [-W{self.code}]" if self.code else ""
        headline = headline or f"error: {self.message}"
        if self.place is None:
            return headline + (f"\n  help: {self.help}" if self.help else "")
        line = self.place.line
        text, column = _window(line.text.replace("\t", " "), self.place.column)
        number = f"{line.number:5d}"
        caret = "^" * max(1, min(self.place.length, len(text) - column))
        rows = [
            f"{line.file}:{line.number}:{self.place.column + 1}: {headline}",
            f"{number} | {text}".rstrip(),
            f"{' ' * len(number)} | {' ' * column}{caret}",
        ]
        if self.help:
            rows[-1] += f"  help: {self.help}"
        rows += [f"{' ' * len(number)} = in macro {name}" for name in line.expansions]
        return visible("\n".join(rows))


class AssemblyError(Exception):
    """The source text has errors; `diagnostics` lists them, those of single statements first."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = list(diagnostics)
        super().__init__(self.report())

    def report(self) -> str:
        """The errors as `report_text` shows them."""
        return report_text(self.diagnostics)


def report_text(diagnostics: Iterable[Diagnostic]) -> str:
    """Errors or warnings: each cause once with its further places, the first causes in full."""
    causes: dict[tuple[str, str], list[Diagnostic]] = {}
    for diagnostic in diagnostics:
        causes.setdefault((diagnostic.message, diagnostic.help), []).append(diagnostic)
    groups = list(causes.values())
    shown = [str(first) + _again(rest) for first, *rest in groups[:ERRORS_SHOWN]]
    left = sum(len(group) for group in groups[ERRORS_SHOWN:])
    if left:
        kind = "warning" if groups[-1][0].code else "error"
        shown.append(f"and {counted(left, f'more {kind}')}")
    if sum(map(len, groups)) >= ERRORS:
        shown.append(f"gave up after {ERRORS} errors")
    return "\n".join(shown)


def _again(rest: list[Diagnostic]) -> str:
    """Line that names the further places with the same cause."""
    if not rest:
        return ""
    lines = [f"{d.place.line.file}:{d.place.line.number}" for d in rest if d.place]
    lines = list(dict.fromkeys(lines))
    named = ", ".join(lines[:LINES_NAMED]) + (", ..." if len(lines) > LINES_NAMED else "")
    return f"\n      = the same {counted(len(rest), 'more time')}: {named}"


def visible(text: str) -> str:
    """The text without characters that a terminal obeys; each is one other character then."""
    return text.translate(_OBEYED)


def _window(text: str, column: int) -> tuple[str, int]:
    """Part of a line to show, and the column in it."""
    if len(text) <= SHOWN_CHARACTERS:
        return text, column
    start = max(0, column - SHOWN_CHARACTERS // 2)
    head = "..." if start else ""
    tail = "..." if start + SHOWN_CHARACTERS < len(text) else ""
    return head + text[start : start + SHOWN_CHARACTERS] + tail, column - start + len(head)


def shortened(text: str) -> str:
    """A name or number as messages show it."""
    return text if len(text) <= 40 else f"{text[:37]}..."


class SourceError(Exception):
    """One error that ends the treatment of a line; the reporter collects it."""

    def __init__(self, place: Place | None, message: str, help: str = "") -> None:
        super().__init__(message)
        self.diagnostic = Diagnostic(place, message, help)


@dataclass
class Reporter:
    """Collects errors and warnings of one assembly; one message per place. Gives up after `ERRORS`
    errors.
    """

    warnings: list[Diagnostic] = field(default_factory=list)
    _taken: dict[Diagnostic, None] = field(default_factory=dict)

    @property
    def diagnostics(self) -> list[Diagnostic]:
        return list(self._taken)

    def add(self, place: Place | None, message: str, help: str = "") -> None:
        self.take(Diagnostic(place, message, help))

    def take(self, diagnostic: Diagnostic) -> None:
        self._taken[diagnostic] = None
        if len(self._taken) >= ERRORS:
            self.stop()

    def warn(self, code: str, place: Place, message: str, help: str = "") -> None:
        """A warning, unless the line's comment says `-Wno-<code>: reason`."""
        allowed = f"-Wno-{code}:" in place.line.text
        if not allowed and len(self.warnings) < ERRORS:
            self.warnings.append(Diagnostic(place, message, help, code))

    def fatal(self, place: Place | None, message: str, help: str) -> NoReturn:
        """An error after which it makes no sense to continue. Raises AssemblyError."""
        raise AssemblyError([*self._taken, Diagnostic(place, message, help)])

    def stop(self) -> None:
        """Raise AssemblyError if there is any error."""
        if self._taken:
            raise AssemblyError(self._taken)


def counted(number: int, noun: str) -> str:
    """The number and its noun."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def closest(word: str, known: Iterable[str]) -> str:
    """Help text with the closest spelling, or empty."""
    if len(word) > SHOWN_CHARACTERS:
        return ""
    names = sorted({name for name in known if len(name) <= SHOWN_CHARACTERS})
    matches = difflib.get_close_matches(word, names, n=1, cutoff=0.6)
    return f"did you mean '{matches[0]}'?" if matches else ""
