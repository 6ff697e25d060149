# SPDX-License-Identifier: Apache-2.0
"""Tokens of one source line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from asip_asm.assembly_text import unquoted
from asip_asm.diagnostics import Line, Place, SourceError, shortened

_TOKEN = re.compile(
    r"(?P<space>\s+)"
    r"|(?P<number>\.?[0-9](?:[eE][+-](?=[0-9])|[A-Za-z0-9_.])*)"
    r"|(?P<name>[A-Za-z_][A-Za-z0-9_.]*)"
    r"|(?P<directive>\.[A-Za-z_][A-Za-z0-9_.]*)"
    r'|(?P<string>"(?:[^"\\]|\\.)*")'
    r"|(?P<symbol>[-+*/()\[\]{}|,:=])"
)
_NUMBER = re.compile(r"0f[0-9A-Fa-f]{8}|0x[0-9A-Fa-f]+|[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?")
_CONTROL = re.compile(r"[\x00-\x1f\x7f]")
_EQUATION = re.compile(r"[;#]\s*\(([A-Z]?[0-9][0-9A-Za-z., -]*)\)")


@dataclass(frozen=True)
class Token:
    """Lexical unit: kind 'name', 'directive', 'number', 'string', 'symbol' or 'end' of the line."""

    kind: str
    text: str
    place: Place

    @property
    def end(self) -> int:
        """Column after the token."""
        return self.place.column + self.place.length


def split_comment(text: str) -> tuple[str, str]:
    """Code and comment of a line; a comment starts at `;` or `#` outside of a string."""
    in_string = escaped = False
    for i, character in enumerate(text):
        if character == '"' and not escaped:
            in_string = not in_string
        escaped = in_string and character == "\\" and not escaped
        if in_string:
            continue
        if character in ";#":
            return text[:i], text[i:]
    return text, ""


def equation(text: str) -> str:
    """Number of the equation that the line's comment names, or empty."""
    match = _EQUATION.match(split_comment(text)[1])
    return match.group(1).strip() if match else ""


def tokenize(line: Line) -> list[Token]:
    """Tokens of the line, an 'end' token last. Raises SourceError."""
    code, _ = split_comment(line.text)
    tokens: list[Token] = []
    column = 0
    while column < len(code):
        match = _TOKEN.match(code, column)
        if match is None:
            if code[column] == '"':
                place = Place(line, column, len(code) - column)
                raise SourceError(place, "string without closing quote", 'add "')
            raise SourceError(
                Place(line, column), f"character {_shown(code[column])} means nothing here"
            )
        kind, text = match.lastgroup or "", match.group()
        place = Place(line, column, len(text))
        if kind == "number" and not _NUMBER.fullmatch(text):
            raise SourceError(
                place,
                f"malformed number '{shortened(text)}'",
                "numbers are written 12, 0x1f, 1.5, 2e-3 or 0f3fc00000",
            )
        if kind == "string" and (found := _CONTROL.search(text)):
            raise SourceError(place, f"a string has no character {_shown(found[0])}")
        if kind != "space":
            tokens.append(Token(kind, unquoted(text) if kind == "string" else text, place))
        column = match.end()
    return [*tokens, Token("end", "", Place(line, len(code.rstrip())))]


def _shown(character: str) -> str:
    return f"'{character}'" if character.isprintable() else f"U+{ord(character):04X}"


class Cursor:
    """Reads tokens of one statement from left to right."""

    def __init__(self, tokens: list[Token]) -> None:
        self.tokens = tokens
        self.position = 0

    @property
    def token(self) -> Token:
        """Next token."""
        return self.tokens[self.position]

    def peek(self) -> Token:
        """Token after the next one."""
        return self.tokens[min(self.position + 1, len(self.tokens) - 1)]

    def take(self) -> Token:
        """Next token, consumed (the end token stays)."""
        token = self.token
        if token.kind != "end":
            self.position += 1
        return token

    def at(self, symbol: str) -> bool:
        """Whether the next token is the symbol."""
        return self.token.kind == "symbol" and self.token.text == symbol

    def accept(self, symbol: str) -> bool:
        """Consume the symbol if it is next."""
        if self.at(symbol):
            self.position += 1
            return True
        return False

    def expect(self, symbol: str, context: str) -> Token:
        """Consume the symbol. Raises SourceError."""
        if not self.at(symbol):
            raise self.unexpected(f"'{symbol}' {context}")
        return self.take()

    def expect_kind(self, kind: str, what: str) -> Token:
        """Consume a token of the kind. Raises SourceError naming `what` was expected."""
        if self.token.kind != kind:
            raise self.unexpected(what)
        return self.take()

    def names(self, what: str, between: str) -> Iterator[Token]:
        """Names up to the end of the statement, with commas `between`; the caller takes what
        belongs to one before it asks for the next. Raises SourceError.
        """
        yield self.expect_kind("name", what)
        while self.token.kind != "end":
            self.expect(",", between)
            yield self.expect_kind("name", what)

    def unexpected(self, wanted: str) -> SourceError:
        """Error: the next token is not what is wanted."""
        found = (
            f"'{shortened(self.token.text)}'" if self.token.kind != "end" else "the end of the line"
        )
        return SourceError(self.token.place, f"expected {wanted}, found {found}")

    def expect_end(self) -> None:
        """Raises SourceError unless the statement ends here."""
        if self.token.kind != "end":
            raise SourceError(
                self.token.place,
                f"'{self.token.text}' is more than this statement takes",
                "one statement per line",
            )
