# SPDX-License-Identifier: Apache-2.0
"""Errors of a source text: where, what, what would be right; collected and reported together."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass, field

ERROR_LIMIT = 20


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
    """One error: `message` says what is wrong, `help` what would be right."""

    place: Place | None
    message: str
    help: str = ""

    def __str__(self) -> str:
        if self.place is None:
            tail = f"\n  help: {self.help}" if self.help else ""
            return f"error: {self.message}{tail}"
        line = self.place.line
        text = line.text.replace("\t", " ")
        number = f"{line.number:5d}"
        caret = "^" * max(1, min(self.place.length, len(text) - self.place.column))
        rows = [
            f"{line.file}:{line.number}:{self.place.column + 1}: error: {self.message}",
            f"{number} | {text}".rstrip(),
            f"{' ' * len(number)} | {' ' * self.place.column}{caret}",
        ]
        if self.help:
            rows[-1] += f"  help: {self.help}"
        rows += [f"{' ' * len(number)} = in macro {name}" for name in line.expansions]
        return "\n".join(rows)


class AssemblyError(Exception):
    """The source text has errors; `diagnostics` lists them, those of single statements first."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = list(diagnostics)
        super().__init__(self.report())

    def report(self) -> str:
        """All errors, the first `ERROR_LIMIT` of them in full."""
        shown = [str(diagnostic) for diagnostic in self.diagnostics[:ERROR_LIMIT]]
        rest = len(self.diagnostics) - ERROR_LIMIT
        if rest > 0:
            shown.append(f"and {rest} more error{'s' if rest > 1 else ''}")
        return "\n".join(shown)


class SourceError(Exception):
    """One error that ends the treatment of a line; the reporter collects it."""

    def __init__(self, place: Place | None, message: str, help: str = "") -> None:
        super().__init__(message)
        self.diagnostic = Diagnostic(place, message, help)


@dataclass
class Reporter:
    """Collects errors of one assembly; one message per place."""

    diagnostics: list[Diagnostic] = field(default_factory=list)

    def add(self, place: Place | None, message: str, help: str = "") -> None:
        self.take(Diagnostic(place, message, help))

    def take(self, diagnostic: Diagnostic) -> None:
        if diagnostic not in self.diagnostics:
            self.diagnostics.append(diagnostic)

    def stop(self) -> None:
        """Raise AssemblyError if there is any error."""
        if self.diagnostics:
            raise AssemblyError(self.diagnostics)


def closest(word: str, known: Iterable[str]) -> str:
    """Help text with the closest spelling, or empty."""
    matches = difflib.get_close_matches(word, sorted(set(known)), n=1, cutoff=0.6)
    return f"did you mean '{matches[0]}'?" if matches else ""
