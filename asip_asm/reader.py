# SPDX-License-Identifier: Apache-2.0
"""Source lines after `.include`, `.macro` and `.if`, in the order in which they are assembled."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from asip_asm.diagnostics import Line, Place, Reporter, SourceError, closest, counted
from asip_asm.files import read_text
from asip_asm.interface import load_interface
from asip_asm.interface_text import assembly
from asip_asm.lexer import Cursor, Token, split_comment, tokenize
from asip_asm.limits import (
    EXPANSIONS,
    INCLUDE_DEPTH,
    LINE_CHARACTERS,
    MACRO_DEPTH,
    TEXT_CHARACTERS,
)
from asip_asm.parameters import ParameterFileError, Parameters, read_parameters
from asip_asm.signals import InterfaceError

READER_DIRECTIVES = (
    ".include",
    ".interface",
    ".params",
    ".macro",
    ".endm",
    ".if",
    ".else",
    ".endif",
)

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.]*")
_PARAMETER = re.compile(r"\\(@|[A-Za-z_][A-Za-z0-9_]*)")


@dataclass
class Macro:
    """Definition: name, parameter names, body lines."""

    name: str
    parameters: list[str]
    body: list[Line]
    place: Place


@dataclass
class Condition:
    """An open .if: whether its current branch is assembled, one of its branches was, everything
    around it is, and whether .else has come.
    """

    place: Place
    active: bool
    chosen: bool
    around: bool = True
    in_else: bool = False


@dataclass
class Reader:
    """Lines of a file with everything it includes and expands.

    `evaluate` gives the value of the expression at a cursor (constants known so far), `reserved`
    lists the names that a macro cannot have, `failed` takes the names of each line with an error.
    `params` is read in place of the parameter files that the source names.
    """

    reporter: Reporter
    evaluate: Callable[[Cursor], float]
    reserved: Callable[[str], bool]
    failed: Callable[[list[str]], None]
    include_path: Sequence[Path] = ()
    params: Path | None = None
    macros: dict[str, Macro] = field(default_factory=dict)
    files: list[Path] = field(default_factory=list)
    _parameter_files: dict[Path, Parameters] = field(default_factory=dict)
    _open_files: list[Path] = field(default_factory=list)
    _open_macros: int = 0
    _expansions: int = 0
    _characters: int = 0

    def read(self, path: Path, display: str | None = None) -> Iterator[list[Token]]:
        """Tokens of each line of the file, which is added to `files`. Raises OSError for this file,
        AssemblyError where a limit of `limits` ends the assembly.
        """
        display = display or display_path(path)
        text = read_text(path, TEXT_CHARACTERS, "a source text")
        rows = text.replace("\r\n", "\n").replace("\r", "\n").removesuffix("\n").split("\n")
        lines = [Line(display, i, row) for i, row in enumerate(rows, 1)]
        self.files.append(path)
        self._open_files.append(path.resolve())
        yield from self._lines(lines, path.parent)
        self._open_files.pop()

    def _check_size(self, line: Line) -> None:
        """Raises SourceError for a line that is too long, AssemblyError for too much text."""
        self._characters += len(line.text) + 1
        if self._characters > TEXT_CHARACTERS:
            self.reporter.fatal(
                Place(line),
                f"the program has more than {TEXT_CHARACTERS} characters with all that it includes "
                "and expands",
                "a full program memory needs a third of that; look for macros that multiply",
            )
        if len(line.text) > LINE_CHARACTERS:
            raise SourceError(
                Place(line),
                f"the line has {len(line.text)} characters, {LINE_CHARACTERS} are allowed",
                "go on in another line",
            )

    def _lines(self, lines: Sequence[Line], folder: Path) -> Iterator[list[Token]]:
        conditions: list[Condition] = []
        queue = iter(lines)
        for line in queue:
            try:
                self._check_size(line)
                head = _head(line)
                active = not conditions or (conditions[-1].around and conditions[-1].active)
                if head in (".if", ".else", ".endif"):
                    self._condition(head, line, conditions, active)
                elif not active:
                    if head == ".macro":
                        _skip_macro(queue)
                elif head == ".macro":
                    self._define(line, queue)
                elif head == ".endm":
                    raise SourceError(_whole(line), ".endm without .macro")
                else:
                    yield from self._line(tokenize(line), folder)
            except SourceError as error:
                self.reporter.take(error.diagnostic)
                self.failed(_NAME.findall(split_comment(line.text)[0]))
        for condition in conditions:
            self.reporter.add(condition.place, ".if without .endif", "add .endif")

    def _line(self, tokens: list[Token], folder: Path) -> Iterator[list[Token]]:
        read = {
            ".include": self._include,
            ".params": self._parameters,
            ".interface": self._interface,
        }
        if tokens[0].kind == "directive" and tokens[0].text in read:
            yield from read[tokens[0].text](Cursor(tokens), folder)
            return
        label = 0
        while (
            tokens[label].kind == "name"
            and tokens[label + 1].kind == "symbol"
            and tokens[label + 1].text == ":"
        ):
            label += 2
        if tokens[label].kind == "name" and tokens[label].text in self.macros:
            if label:
                yield [*tokens[:label], tokens[-1]]
            yield from self._expand(tokens[label], tokens, folder)
        else:
            yield tokens

    def _condition(self, head: str, line: Line, conditions: list[Condition], around: bool) -> None:
        cursor = Cursor(tokenize(line))
        place = cursor.take().place
        if head == ".if":
            # Placed first, so that a wrong expression does not leave .endif alone.
            condition = Condition(place, False, True, around)
            conditions.append(condition)
            if around:
                value = self.evaluate(cursor)
                cursor.expect_end()
                condition.active = value != 0
                condition.chosen = condition.active
            return
        if not conditions:
            raise SourceError(place, f"{head} without .if")
        if head == ".endif":
            conditions.pop()
        else:
            condition = conditions[-1]
            if condition.in_else:
                raise SourceError(place, "second .else of one .if")
            condition.in_else = True
            condition.active = not condition.chosen
        cursor.expect_end()

    def _define(self, line: Line, queue: Iterator[Line]) -> None:
        body: list[Line] = []
        for row in queue:
            head = _head(row)
            if head == ".endm":
                break
            if head == ".macro":
                self.reporter.add(
                    _whole(row), ".macro inside a macro", "close the outer with .endm"
                )
            body.append(row)
        else:
            raise SourceError(_whole(line), ".macro without .endm", "add .endm")
        cursor = Cursor(tokenize(line))
        cursor.take()
        name = cursor.expect_kind("name", "the macro's name")
        parameters: list[str] = []
        while cursor.token.kind != "end":
            if parameters:
                cursor.expect(",", "between parameters")
            token = cursor.expect_kind("name", "a parameter name")
            if token.text in parameters:
                raise SourceError(token.place, f"parameter '{token.text}' is named twice")
            parameters.append(token.text)
        if self.reserved(name.text):
            raise SourceError(name.place, f"a macro cannot be named '{name.text}': it is reserved")
        if name.text in self.macros:
            before = self.macros[name.text].place.line
            raise SourceError(
                name.place,
                f"macro '{name.text}' is defined twice",
                f"first at {before.file}:{before.number}",
            )
        self.macros[name.text] = Macro(name.text, parameters, body, name.place)

    def _expand(self, name: Token, tokens: list[Token], folder: Path) -> Iterator[list[Token]]:
        macro = self.macros[name.text]
        line = name.place.line
        if self._open_macros >= MACRO_DEPTH:
            raise SourceError(
                name.place,
                f"macro '{macro.name}' expands itself more than {MACRO_DEPTH} levels deep",
                "end the recursion with .if",
            )
        arguments = _arguments(line, name.end)
        if len(arguments) != len(macro.parameters):
            raise SourceError(
                name.place,
                f"macro '{macro.name}' takes {counted(len(macro.parameters), 'argument')}, "
                f"found {len(arguments)}",
                f"{macro.name} {', '.join(macro.parameters)}".strip(),
            )
        self._expansions += 1
        if self._expansions > EXPANSIONS:
            self.reporter.fatal(
                name.place,
                f"more than {EXPANSIONS} macro calls",
                "look for macros that call themselves twice",
            )
        values = dict(zip(macro.parameters, arguments, strict=True))
        values["@"] = str(self._expansions)
        expansions = (f"{macro.name} at {line.file}:{line.number}", *line.expansions)
        lines = [
            Line(row.file, row.number, self._substitute(row, macro, values), expansions)
            for row in macro.body
        ]
        self._open_macros += 1
        yield from self._lines(lines, folder)
        self._open_macros -= 1

    def _substitute(self, row: Line, macro: Macro, values: dict[str, str]) -> str:
        def value(match: re.Match[str]) -> str:
            if match.group(1) in values:
                return values[match.group(1)]
            raise SourceError(
                Place(row, match.start(), len(match.group())),
                f"macro '{macro.name}' has no parameter '{match.group(1)}'",
                f"its parameters are {', '.join(macro.parameters) or 'none'}; \\@ numbers the "
                "expansion",
            )

        code, comment = split_comment(row.text)
        return _PARAMETER.sub(value, code) + comment

    def _include(self, cursor: Cursor, folder: Path) -> Iterator[list[Token]]:
        name, path = self._file(cursor, folder)
        if path.resolve() in self._open_files:
            chain = " -> ".join(p.name for p in [*self._open_files, path])
            raise SourceError(name.place, f"file '{name.text}' includes itself", chain)
        if len(self._open_files) >= INCLUDE_DEPTH:
            self.reporter.fatal(
                name.place,
                f"more than {INCLUDE_DEPTH} files include one another",
                "include them one after the other",
            )
        try:
            yield from self.read(path)
        except OSError as error:
            problem = f"cannot read '{name.text}': {error.strerror}"
            raise SourceError(name.place, problem) from None

    def _parameters(self, cursor: Cursor, folder: Path) -> Iterator[list[Token]]:
        """The lines `.param name = value` that a parameter file, or part of it, means."""
        wanted: list[Token] = []
        name, path = self._file(cursor, folder, wanted)
        yield from self._parameter_lines(path, name, {t.text: t.place for t in wanted})

    def _parameter_lines(
        self, path: Path, name: Token, wanted: Mapping[str, Place]
    ) -> Iterator[list[Token]]:
        """Lines of the parameters wanted, each at its place, or of all. Raises SourceError."""
        path = self.params or path
        try:
            if path not in self._parameter_files:
                self._parameter_files[path] = read_parameters(path)
                self.files.append(path)
            found = self._parameter_files[path]
        except (OSError, ParameterFileError) as error:
            raise SourceError(name.place, f"cannot read '{path}': {error}") from None
        for parameter, place in wanted.items():
            if parameter not in found:
                near = closest(parameter, found)
                raise SourceError(place, f"'{path}' has no parameter '{parameter}'", near)
        for parameter in wanted or found:
            value, line = found[parameter]
            yield self._made(display_path(path), line, f".param {parameter} = {value!r}")

    def _interface(self, cursor: Cursor, folder: Path) -> Iterator[list[Token]]:
        """The declarations that an interface record makes, its parameters first."""
        name, path = self._file(cursor, folder)
        try:
            interface = load_interface(path)
        except (OSError, InterfaceError) as error:
            raise SourceError(name.place, f"cannot read '{name.text}': {error}") from None
        self.files += interface.files
        if interface.parameter_file is not None:
            wanted = dict.fromkeys(interface.parameter_names, name.place)
            yield from self._parameter_lines(interface.parameter_file, name, wanted)
        for file, line, text in assembly(interface):
            yield self._made(display_path(file), line, text)

    def _made(self, file: str, line: int, text: str) -> list[Token]:
        """Tokens of a line that a directive expands to."""
        row = Line(file, line, text)
        self._check_size(row)
        return tokenize(row)

    def _file(
        self, cursor: Cursor, folder: Path, names: list[Token] | None = None
    ) -> tuple[Token, Path]:
        """The file that a directive names: next to the source or in a folder of -I.

        names: takes what may follow the file's name, `, name` any number of times.
        """
        directive = cursor.take()
        name = cursor.expect_kind("string", f'a file name in quotes: {directive.text} "file"')
        while names is not None and cursor.token.kind != "end":
            cursor.expect(",", "between names")
            names.append(cursor.expect_kind("name", "the name of a parameter"))
        cursor.expect_end()
        for candidate in [folder / name.text, *(p / name.text for p in self.include_path)]:
            if os.path.exists(candidate):
                self._check_within(name, candidate)
                return name, candidate
        raise SourceError(
            name.place,
            f"file '{name.text}' not found",
            "searched " + ", ".join(display_path(p) for p in [folder, *self.include_path]),
        )

    def _check_within(self, name: Token, file: Path) -> None:
        """A text from a stranger shall not show the user's other files, as an error would.

        Raises SourceError for a file outside the folders of the program and of -I.
        """
        allowed = [self.files[0].parent, *self.include_path]
        if not any(file.resolve().is_relative_to(folder.resolve()) for folder in allowed):
            raise SourceError(
                name.place,
                f"file '{name.text}' is outside the folder of the program",
                "if it is wanted, name its folder by -I and leave the folder out here",
            )


def display_path(path: Path) -> str:
    """The path as messages and images show it: relative to the working directory."""
    shown = os.path.relpath(path) if path.is_absolute() else os.path.normpath(path)
    text = Path(shown).as_posix().encode(errors="backslashreplace").decode()
    return "".join(c if c.isprintable() else "?" for c in text)


def _head(line: Line) -> str:
    """First word of the line if it is a directive."""
    words = split_comment(line.text)[0].split(maxsplit=1)
    return words[0] if words and words[0].startswith(".") else ""


def _whole(line: Line) -> Place:
    code = split_comment(line.text)[0].rstrip()
    column = len(code) - len(code.lstrip())
    return Place(line, column, max(1, len(code) - column))


def _skip_macro(queue: Iterator[Line]) -> None:
    for row in queue:
        if _head(row) == ".endm":
            return


def _arguments(line: Line, column: int) -> list[str]:
    """Texts of a macro call's arguments, split at commas outside of parentheses and brackets."""
    text = split_comment(line.text)[0][column:]
    if not text.strip():
        return []
    arguments, depth, start = [], 0, 0
    for i, character in enumerate(text):
        depth += (character in "([") - (character in ")]")
        if character == "," and depth == 0:
            arguments.append(text[start:i].strip())
            start = i + 1
    return [*arguments, text[start:].strip()]
